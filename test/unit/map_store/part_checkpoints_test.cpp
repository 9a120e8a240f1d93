#include "ratslam/system/part_checkpoints.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <memory>
#include <thread>

namespace ratslam {
namespace {

namespace fs = std::filesystem;

constexpr Stamp kSecond = 1'000'000'000;

/// A part that counts the messages it has taken in.
class Counting : public testing::Test {
 protected:
  Counting() : folder_(fs::temp_directory_path() / ("part_checkpoints_test." + std::to_string(getpid()))) {
    settings_.folder = folder_.string();
    settings_.part = "pose_cells";
    settings_.period = 5.0;
    settings_.parameters = {{"pc_dim_xy", "30"}};
  }
  ~Counting() override { fs::remove_all(folder_); }

  /// Messages of stamps (first, last], in seconds; `end` saves at the end as an orderly shutdown does.
  void run(Stamp first, Stamp last, bool end) {
    PartCheckpoints checkpoints(settings_);
    resume(checkpoints);
    const auto save = [this](State& state) { state.set("count", count_); };
    for (Stamp second = first + 1; second <= last; ++second) {
      checkpoints.before(second * kSecond, save);
      ++count_;
    }
    if (end) checkpoints.saveNow(save);
    EXPECT_FALSE(checkpoints.takeFailure());
  }
  void resume(PartCheckpoints& checkpoints) {
    reports_.clear();
    const auto state = checkpoints.resume([this](const std::string& line) { reports_.push_back(line); });
    count_ = state ? state->get<std::int64_t>("count") : 0;
  }
  std::int64_t resumed() {
    settings_.read_only = true;
    PartCheckpoints checkpoints(settings_);
    resume(checkpoints);
    settings_.read_only = false;
    return count_;
  }

  fs::path folder_;
  CheckpointSettings settings_;
  std::int64_t count_ = 0;
  std::vector<std::string> reports_;
};

TEST_F(Counting, LosesAtMostThePeriod) {
  run(0, 13, false);
  EXPECT_EQ(resumed(), 9) << "messages before 10 s";
  ASSERT_EQ(reports_.size(), 1U);
  EXPECT_NE(reports_[0].find("resumed from the checkpoint at 10.000000000 s"), std::string::npos);
}

TEST_F(Counting, LosesNothingWhenItEndsInOrder) {
  run(0, 13, true);
  EXPECT_EQ(resumed(), 13);
  run(13, 21, true);
  EXPECT_EQ(resumed(), 21);
}

TEST_F(Counting, TheLastOneWrittenCountsThoughTheClockWasSetBack) {
  run(100, 113, true);
  run(0, 7, true);
  EXPECT_EQ(resumed(), 20);
  run(7, 8, true);
  EXPECT_EQ(resumed(), 21);
}

TEST_F(Counting, TheLastOneWrittenCountsAmongThoseOfOneStamp) {
  for (int more = 0; more < 2; ++more) {  // whichever of the two files is next
    run(0, 3 + more, true);
    PartCheckpoints checkpoints(settings_);
    resume(checkpoints);
    checkpoints.before((3 + more) * kSecond, [](State& state) { state.set("count", std::int64_t{0}); });
    checkpoints.saveNow([](State& state) { state.set("count", std::int64_t{-1}); });
    EXPECT_EQ(resumed(), -1);
  }
}

TEST_F(Counting, SaysThatItStartsWithoutMemory) {
  EXPECT_EQ(resumed(), 0);
  ASSERT_EQ(reports_.size(), 1U);
  EXPECT_NE(reports_[0].find("no checkpoint of pose_cells: it starts without memory"), std::string::npos);
}

TEST_F(Counting, UsesTheLastGoodCheckpoint) {
  run(0, 7, false);   // a checkpoint at 5 s
  run(7, 13, false);  // and one at 10 s
  for (const auto& entry : fs::directory_iterator(folder_)) {
    const std::string path = entry.path().string();
    if (entry.path().extension() != ".db" || loadMapFile(path).stamp != 10 * kSecond) continue;
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(fs::file_size(path) / 2));
    file.write("damage damage damage damage", 27);
    file.close();
    fs::resize_file(path, fs::file_size(path) - 4096);
  }
  EXPECT_EQ(resumed(), 4);
  EXPECT_EQ(reports_.size(), 2U) << "what is damaged, and what is used";
  run(13, 25, true);  // goes on: the damaged file makes room
  EXPECT_EQ(resumed(), 4 + 12);
}

TEST_F(Counting, RefusesOtherParameters) {
  run(0, 13, true);
  settings_.parameters["pc_dim_xy"] = "40";
  PartCheckpoints checkpoints(settings_);
  EXPECT_THROW(resume(checkpoints), std::runtime_error);
}

TEST_F(Counting, LeavesTheFilesAsTheyAreWhereNothingIsToBeLearned) {
  run(0, 13, true);
  const auto before = fs::last_write_time(folder_ / "pose_cells.a.db");
  settings_.read_only = true;
  run(13, 40, true);
  settings_.read_only = false;
  EXPECT_EQ(fs::last_write_time(folder_ / "pose_cells.a.db"), before);
  EXPECT_EQ(resumed(), 13);
}

/// No file may grow beyond a size while one of these lives, as on a full disk or beyond a quota.
class SizeLimit {
 public:
  explicit SizeLimit(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~SizeLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  SizeLimit(const SizeLimit&) = delete;
  SizeLimit& operator=(const SizeLimit&) = delete;

 private:
  void (*handler_)(int);
  rlimit before_{};
};

TEST_F(Counting, KeepsTheLastGoodCheckpointWhereTheDiskIsFull) {
  run(0, 7, true);
  PartCheckpoints checkpoints(settings_);
  resume(checkpoints);
  const auto save = [this](State& state) {
    state.set("count", count_);
    std::vector<std::uint32_t> large(1U << 16U);
    for (std::size_t i = 0; i < large.size(); ++i) large[i] = static_cast<std::uint32_t>(i * i * 2654435761U);
    state.set("large", large);
  };
  checkpoints.before(8 * kSecond, save);
  count_ = 8;
  {
    const SizeLimit limit(100'000);
    try {
      checkpoints.saveNow(save);
      FAIL() << "a checkpoint that cannot be written is told";
    } catch (const std::runtime_error& e) {
      const std::string what = e.what();
      EXPECT_EQ(what.find('\n'), std::string::npos);
      EXPECT_NE(what.find("checkpoint lost: " + folder_.string()), std::string::npos) << what;
      EXPECT_NE(what.find("the disk is full"), std::string::npos) << what;
    }
  }
  EXPECT_EQ(resumed(), 7);
  checkpoints.saveNow([](State& state) { state.set("count", std::int64_t{9}); });
  EXPECT_EQ(resumed(), 9) << "there is room again";
}

TEST_F(Counting, AnEarlierFailureIsNoFailureOfASaveThatSucceeds) {
  run(0, 7, true);
  PartCheckpoints checkpoints(settings_);
  resume(checkpoints);
  checkpoints.before(8 * kSecond, [](State& state) { state.set("count", std::int64_t{7}); });
  {
    const SizeLimit limit(100);
    checkpoints.before(11 * kSecond, [](State& state) { state.set("count", std::int64_t{8}); });
    EXPECT_THROW(checkpoints.saveNow([](State& state) { state.set("count", std::int64_t{8}); }),
                 std::runtime_error);
    checkpoints.before(16 * kSecond, [](State& state) { state.set("count", std::int64_t{8}); });
    std::this_thread::sleep_for(std::chrono::milliseconds(300));  // its writing fails
  }
  EXPECT_NO_THROW(checkpoints.saveNow([](State& state) { state.set("count", std::int64_t{9}); }));
  EXPECT_TRUE(checkpoints.takeFailure()) << "that one was lost is still told";
  EXPECT_EQ(resumed(), 9);
}

TEST_F(Counting, ADamagedFileDoesNotReplaceAnEarlierOne) {
  fs::create_directories(folder_);
  for (int time = 0; time < 2; ++time) {
    std::ofstream(folder_ / "pose_cells.a.db") << "damage " << time;
    std::ofstream(folder_ / "pose_cells.b.db") << "damage " << time;
    PartCheckpoints checkpoints(settings_);
    resume(checkpoints);
    for (const Stamp second : {1, 2}) {
      checkpoints.before(second * kSecond, [](State& state) { state.set("count", std::int64_t{1}); });
      checkpoints.saveNow([](State& state) { state.set("count", std::int64_t{1}); });
    }
  }
  for (const char* name :
       {"pose_cells.a.db.damaged", "pose_cells.a.db.damaged2", "pose_cells.b.db.damaged2"}) {
    EXPECT_TRUE(fs::exists(folder_ / name)) << name;
  }
}

TEST_F(Counting, SaysWhyNothingIsSaved) {
  {
    PartCheckpoints checkpoints(settings_);
    EXPECT_NE(checkpoints.whyNothingIsSaved().value_or("").find("nothing to save yet"), std::string::npos);
    checkpoints.before(kSecond, [](State&) {});
    EXPECT_FALSE(checkpoints.whyNothingIsSaved());
    checkpoints.setReadOnly(true);
    EXPECT_NE(checkpoints.whyNothingIsSaved().value_or("").find("localise_only"), std::string::npos);
  }
  settings_.folder.clear();
  PartCheckpoints checkpoints(settings_);
  checkpoints.before(kSecond, [](State&) {});
  EXPECT_NE(checkpoints.whyNothingIsSaved().value_or("").find("map_dir is not set"), std::string::npos);
  EXPECT_THROW(checkpoints.saveTo("/tmp/never.db", [](State&) {}), std::runtime_error);
}

TEST_F(Counting, ContinuesTheSessionsOfALoadedMap) {
  const auto save = [](State& state) { state.set("count", 1); };
  const std::string saved = (folder_ / "monday.db").string();
  PartCheckpoints checkpoints(settings_);
  const auto sessionsNow = [&] {
    checkpoints.saveTo(saved, save);
    return loadMapFile(saved).sessions;
  };
  checkpoints.before(3 * kSecond, save);
  checkpoints.before(4 * kSecond, save);
  const std::vector<MapSession> monday = sessionsNow();
  ASSERT_EQ(monday.size(), 1U);
  checkpoints.continueFrom("");
  EXPECT_TRUE(sessionsNow().empty()) << "everything was forgotten";
  checkpoints.before(6 * kSecond, save);
  ASSERT_EQ(sessionsNow().size(), 1U);
  EXPECT_EQ(sessionsNow()[0].first_stamp, 6 * kSecond);
  const std::string first = (folder_ / "first.db").string();
  fs::copy(saved, first);
  checkpoints.continueFrom(first);
  checkpoints.before(8 * kSecond, save);
  const std::vector<MapSession> both = sessionsNow();
  ASSERT_EQ(both.size(), 2U);
  EXPECT_EQ(both[0].first_stamp, 6 * kSecond);
  EXPECT_EQ(both[1].first_stamp, 8 * kSecond);
}

TEST_F(Counting, HasOneWriter) {
  settings_.patience = 0.2;
  const PartCheckpoints first(settings_);
  EXPECT_THROW(PartCheckpoints second(settings_), MapBusy);
}

TEST_F(Counting, WaitsForAWriterThatEnds) {
  auto first = std::make_unique<PartCheckpoints>(settings_);
  std::thread ending([&first] {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    first.reset();
  });
  EXPECT_NO_THROW(PartCheckpoints second(settings_));
  ending.join();
}

/// A process that locks files as SQLite does for a transaction that writes.
class LockingProcess {
 public:
  explicit LockingProcess(const std::vector<fs::path>& files) {
    int ready[2];
    if (pipe(ready) != 0) return;
    child_ = fork();
    if (child_ == 0) {
      for (const fs::path& file : files) {
        struct flock whole {};
        whole.l_type = F_WRLCK;
        whole.l_whence = SEEK_SET;
        whole.l_start = 0x40000000;  // the pending byte; the shared ones follow
        whole.l_len = 512;
        if (fcntl(open(file.c_str(), O_RDWR), F_SETLK, &whole) != 0) _exit(1);
      }
      if (write(ready[1], "", 1) != 1) _exit(1);
      while (true) pause();
    }
    char byte = 0;
    close(ready[1]);
    EXPECT_EQ(read(ready[0], &byte, 1), 1);
    close(ready[0]);
  }
  ~LockingProcess() {
    kill(child_, SIGKILL);
    waitpid(child_, nullptr, 0);
  }
  LockingProcess(const LockingProcess&) = delete;
  LockingProcess& operator=(const LockingProcess&) = delete;

 private:
  pid_t child_ = -1;
};

TEST_F(Counting, AFileThatAnotherProgramLocksIsNotTakenForDamaged) {
  run(0, 6, true);
  run(6, 12, true);
  settings_.patience = 0.2;
  const std::vector<fs::path> files(fs::directory_iterator(folder_), {});
  {
    const LockingProcess other(files);
    PartCheckpoints checkpoints(settings_);
    EXPECT_THROW(resume(checkpoints), MapBusy);
    checkpoints.before(13 * kSecond, [](State& state) { state.set("count", std::int64_t{0}); });
    EXPECT_THROW(checkpoints.saveNow([](State& state) { state.set("count", std::int64_t{0}); }),
                 std::runtime_error);
  }
  EXPECT_EQ(resumed(), 12);
  EXPECT_EQ(std::vector<fs::path>(fs::directory_iterator(folder_), {}), files) << "a sound file was renamed";
}

TEST_F(Counting, AFileOfANewerProgramIsNotTakenForDamaged) {
  run(0, 6, true);
  run(6, 12, true);
  const std::vector<fs::path> files(fs::directory_iterator(folder_), {});
  const auto setVersion = [&files](char version) {
    for (const fs::path& path : files) {
      std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
      file.seekp(63);  // the last byte of PRAGMA user_version
      file.put(version);
    }
  };
  setVersion(9);
  {
    PartCheckpoints checkpoints(settings_);
    EXPECT_THROW(resume(checkpoints), MapUnread);
    checkpoints.before(13 * kSecond, [](State&) {});
    EXPECT_THROW(checkpoints.saveNow([](State&) {}), std::runtime_error);
  }
  EXPECT_EQ(std::vector<fs::path>(fs::directory_iterator(folder_), {}), files) << "a sound file was renamed";
  setVersion(1);
  EXPECT_EQ(resumed(), 12);
}

TEST_F(Counting, RoomForACheckpointIsTriedWithoutATrace) {
  run(0, 7, true);
  PartCheckpoints checkpoints(settings_);
  resume(checkpoints);
  const std::vector<fs::path> files(fs::directory_iterator(folder_), {});
  const auto save = [](State& state) { state.set("count", std::int64_t{8}); };
  EXPECT_NO_THROW(checkpoints.requireRoom(save));
  {
    const SizeLimit limit(100);
    EXPECT_THROW(checkpoints.requireRoom(save), std::runtime_error);
    checkpoints.setReadOnly(true);
    EXPECT_NO_THROW(checkpoints.requireRoom(save)) << "nothing will be written";
  }
  EXPECT_EQ(std::vector<fs::path>(fs::directory_iterator(folder_), {}), files);
  EXPECT_EQ(resumed(), 7);
}

}  // namespace
}  // namespace ratslam
