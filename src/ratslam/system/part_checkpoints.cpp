#include "ratslam/system/part_checkpoints.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>

#include "ratslam/version.h"

namespace ratslam {
namespace {

constexpr std::array<const char*, 2> kTurns{".a.db", ".b.db"};
constexpr const char* kCheckpoint = "checkpoint";  // child of the state, with the checkpoint's number
constexpr const char* kNumber = "number";
constexpr const char* kNoFolder = "the parameter map_dir is not set: no checkpoints are kept";
constexpr const char* kNothingYet = "there is nothing to save yet";

/// Attempts something until no other program holds the files. @throws MapBusy after `patience` seconds
template <class Attempt>
auto patiently(double patience, Attempt&& attempt) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(patience);
  while (true) {
    try {
      return attempt();
    } catch (const MapBusy&) {
      if (std::chrono::steady_clock::now() >= until) throw;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
}

/// Checkpoints are numbered in the order of writing, because stamps may go back. @return 0 for a map saved elsewhere
std::uint64_t numberOf(const MapCheckpoint& checkpoint) {
  std::uint64_t number = 0;
  if (checkpoint.state.hasChild(kCheckpoint)) checkpoint.state.child(kCheckpoint).get(kNumber, number);
  return number;
}

}  // namespace

struct PartCheckpoints::Impl {
  explicit Impl(const CheckpointSettings& chosen) : settings(chosen) {
    for (std::size_t i = 0; i < kTurns.size(); ++i) {
      paths[i] = settings.folder + "/" + settings.part + kTurns[i];
    }
    if (!settings.read_only) open();
  }

  /// Locks the folder: from here on this is the only program that writes.
  void open() {
    std::error_code error;
    std::filesystem::create_directories(settings.folder, error);
    if (error) {
      throw std::runtime_error("map_dir " + settings.folder +
                               ": cannot make this folder: " + error.message());
    }
    lock = patiently(settings.patience, [this] { return std::make_unique<MapLock>(paths[0]); });
    thread = std::thread([this] { work(); });
  }

  ~Impl() {
    if (!thread.joinable()) return;
    {
      const std::lock_guard<std::mutex> guard(mutex);
      ending = true;
    }
    changed.notify_all();
    thread.join();
  }

  /// Loop of the writing thread.
  void work() {
    std::unique_lock<std::mutex> guard(mutex);
    while (true) {
      changed.wait(guard, [this] { return waiting || ending; });
      if (!waiting) return;
      const std::unique_ptr<MapCheckpoint> checkpoint = std::move(waiting);
      writing = true;
      guard.unlock();
      std::optional<std::string> why = write(*checkpoint);
      guard.lock();
      writing = false;
      if (why)
        failure = why;
      else
        written = numberOf(*checkpoint);
      changed.notify_all();
    }
  }

  std::optional<std::string> write(const MapCheckpoint& checkpoint) {
    const std::size_t turn = next_turn;
    try {
      if (!writers[turn]) writers[turn] = openWriter(paths[turn]);
      writers[turn]->save(checkpoint);
      next_turn = 1 - turn;
      return std::nullopt;
    } catch (const std::exception& error) {
      writers[turn].reset();
      return std::string("checkpoint lost: ") + error.what();
    }
  }

  /// The name, or the name with the first number that makes it that of no file.
  static std::string freeName(const std::string& name) {
    std::string free = name;
    for (int number = 2; std::filesystem::exists(free); ++number) free = name + std::to_string(number);
    return free;
  }

  /// Opens a file for writing. A damaged file is renamed first; the other file still holds a checkpoint.
  static std::unique_ptr<MapWriter> openWriter(const std::string& path) {
    try {
      if (std::filesystem::exists(path)) loadMapFile(path);
    } catch (const MapUnread&) {
      throw;
    } catch (const std::runtime_error&) {
      std::filesystem::rename(path, freeName(path + ".damaged"));
    }
    return std::make_unique<MapWriter>(path);
  }

  void hand(MapCheckpoint&& checkpoint) {
    checkpoint.state.child(kCheckpoint).set(kNumber, ++number);
    {
      const std::lock_guard<std::mutex> guard(mutex);
      waiting = std::make_unique<MapCheckpoint>(std::move(checkpoint));  // replaces one that still waits
    }
    changed.notify_all();
  }

  /// @return whether the newest checkpoint is on the disk
  bool waitUntilWritten() {
    std::unique_lock<std::mutex> guard(mutex);
    changed.wait(guard, [this] { return !waiting && !writing; });
    return written == number;
  }

  MapCheckpoint take(Stamp stamp, const Save& save) const {
    MapCheckpoint checkpoint;
    checkpoint.stamp = stamp;
    checkpoint.parameters = settings.parameters;
    checkpoint.sessions = sessions;
    if (first) checkpoint.sessions.push_back({version(), *first, stamp});
    save(checkpoint.state.child(settings.part));
    return checkpoint;
  }

  CheckpointSettings settings;
  std::array<std::string, 2> paths;
  std::unique_ptr<MapLock> lock;
  std::array<std::unique_ptr<MapWriter>, 2> writers;
  std::size_t next_turn = 0;
  std::uint64_t number = 0;          ///< of the newest checkpoint
  std::vector<MapSession> sessions;  ///< before this one
  std::optional<Stamp> first;
  std::optional<Stamp> newest;
  std::thread thread;
  std::mutex mutex;
  std::condition_variable changed;
  std::unique_ptr<MapCheckpoint> waiting;
  bool writing = false;
  std::uint64_t written = 0;  ///< number of the newest checkpoint on the disk
  bool ending = false;
  std::optional<std::string> failure;
};

PartCheckpoints::PartCheckpoints(const CheckpointSettings& settings) : settings_(settings) {
  if (!settings.folder.empty()) impl_ = std::make_unique<Impl>(settings);
}

PartCheckpoints::~PartCheckpoints() = default;

std::optional<State> PartCheckpoints::resume(const std::function<void(const std::string&)>& report) {
  if (!impl_) return std::nullopt;
  std::optional<MapCheckpoint> best;
  std::size_t best_turn = 0;
  std::vector<std::string> damaged;
  for (std::size_t turn = 0; turn < kTurns.size(); ++turn) {
    if (!std::filesystem::exists(impl_->paths[turn])) continue;
    try {
      MapCheckpoint checkpoint =
          patiently(settings_.patience, [&] { return loadMapFile(impl_->paths[turn]); });
      const auto age = [](const MapCheckpoint& one) { return std::make_pair(numberOf(one), one.stamp); };
      if (best && age(*best) >= age(checkpoint)) continue;
      best = std::move(checkpoint);
      best_turn = turn;
    } catch (const MapUnread&) {
      throw;
    } catch (const std::runtime_error& error) {
      damaged.emplace_back(error.what());
    }
  }
  for (const std::string& what : damaged) report(what);
  if (!best) {
    report(impl_->settings.folder + ": no checkpoint of " + impl_->settings.part +
           (damaged.empty() ? "" : " that can be used") + ": it starts without memory" +
           (impl_->settings.read_only ? ", and learns nothing (localise_only): load a map" : ""));
    return std::nullopt;
  }
  requireParameters(impl_->paths[best_turn], *best, impl_->settings.parameters);
  report(impl_->paths[best_turn] + ": resumed from the checkpoint at " + formatStamp(best->stamp) + " s");
  impl_->next_turn = 1 - best_turn;
  impl_->number = numberOf(*best);
  impl_->sessions = best->sessions;
  impl_->newest = best->stamp;
  return best->state.child(impl_->settings.part);
}

void PartCheckpoints::before(Stamp message, const Save& save) {
  if (!impl_) return;
  const auto period = static_cast<Stamp>(impl_->settings.period * 1e9);
  const std::optional<Stamp> last = std::exchange(impl_->newest, message);
  if (!impl_->first) impl_->first = message;
  if (impl_->settings.read_only || !last || message / period == *last / period || message < *last) return;
  impl_->hand(impl_->take(message / period * period, save));
}

std::optional<std::string> PartCheckpoints::whyNothingIsSaved() const {
  if (!impl_) return kNoFolder;
  if (impl_->settings.read_only) return "nothing is learned (localise_only): checkpoints stay as they are";
  if (!impl_->newest) return kNothingYet;
  return std::nullopt;
}

void PartCheckpoints::saveNow(const Save& save) {
  if (whyNothingIsSaved()) return;
  impl_->hand(impl_->take(*impl_->newest, save));
  if (!impl_->waitUntilWritten()) throw std::runtime_error(takeFailure().value_or("checkpoint lost"));
}

void PartCheckpoints::saveTo(const std::string& path, const Save& save) const {
  if (!impl_ || !impl_->newest) {
    throw std::runtime_error(settings_.part + ": " + (impl_ ? kNothingYet : kNoFolder));
  }
  const MapLock lock(path);
  MapWriter(path).save(impl_->take(*impl_->newest, save));
}

void PartCheckpoints::requireRoom(const Save& save) const {
  if (!impl_ || impl_->settings.read_only) return;
  const std::string trial = settings_.folder + "/" + settings_.part + ".trial.db";
  const auto remove = [&trial] {
    std::error_code ignored;
    for (const char* ending : {"", "-journal"}) std::filesystem::remove(trial + ending, ignored);
  };
  remove();
  try {
    MapWriter(trial).save(impl_->take(impl_->newest.value_or(0), save));
  } catch (...) {
    remove();
    throw;
  }
  remove();
}

State PartCheckpoints::loadFrom(const std::string& path) const {
  MapCheckpoint checkpoint = loadMapFile(path);
  if (!checkpoint.state.hasChild(settings_.part)) {
    throw std::runtime_error(path + ": it holds nothing of " + settings_.part);
  }
  // Only the parameters of this part are compared.
  for (auto it = checkpoint.parameters.begin(); it != checkpoint.parameters.end();) {
    it = settings_.parameters.count(it->first) > 0 ? std::next(it) : checkpoint.parameters.erase(it);
  }
  requireParameters(path, checkpoint, settings_.parameters);
  return std::move(checkpoint.state.child(settings_.part));
}

void PartCheckpoints::continueFrom(const std::string& path) {
  if (!impl_) return;
  impl_->sessions.clear();
  impl_->first.reset();
  if (path.empty()) return;
  MapCheckpoint loaded = loadMapFile(path);
  impl_->sessions = std::move(loaded.sessions);
  impl_->newest = loaded.stamp;
}

void PartCheckpoints::setReadOnly(bool on) {
  if (!impl_) return;
  if (!on && !impl_->lock) impl_->open();
  impl_->settings.read_only = on;
}

std::optional<std::string> PartCheckpoints::takeFailure() {
  if (!impl_) return std::nullopt;
  const std::lock_guard<std::mutex> guard(impl_->mutex);
  return std::exchange(impl_->failure, std::nullopt);
}

}  // namespace ratslam
