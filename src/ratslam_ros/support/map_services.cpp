#include "ratslam_ros/support/map_services.h"

#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <stdexcept>

#include "ratslam/system/map_fit.h"
#include "ratslam/system/map_store.h"
#include "ratslam_ros/support/drop_oldest_queue.h"
#include "ratslam_ros/support/inside_folder.h"
#include "ratslam_ros/support/node_parameters.h"

namespace ratslam {
namespace {

using Request = PartCommands::Request;

Request command(std::uint32_t what, const std::string& path = "", bool on = false) {
  Request request;
  request.command = what;
  request.path = path;
  request.on = on ? 1 : 0;
  return request;
}

/// Temporary files, one for each part. The destructor removes them.
class PartFiles {
 public:
  explicit PartFiles(const std::string& map) : map_(map) {}
  ~PartFiles() {
    std::error_code ignored;
    for (const std::string& file : files_) {
      for (const char* ending : {"", ".lock", "-journal"}) std::filesystem::remove(file + ending, ignored);
    }
  }
  PartFiles(const PartFiles&) = delete;
  PartFiles& operator=(const PartFiles&) = delete;

  const std::string& add() {
    files_.push_back(map_ + "." + std::to_string(files_.size()) + ".part");
    return files_.back();
  }
  const std::vector<std::string>& all() const { return files_; }

 private:
  std::string map_;
  std::vector<std::string> files_;
};

/// Joins all parts into one map, which ratslam_run can load, too.
MapCheckpoint joined(const std::vector<std::string>& files) {
  MapCheckpoint map;
  for (const std::string& file : files) {
    MapCheckpoint part = loadMapFile(file);
    map.stamp = std::max(map.stamp, part.stamp);
    map.parameters.merge(part.parameters);
    map.sessions = std::move(part.sessions);  // the last ones are those of the experience map
    for (const auto& [name, state] : part.state.children()) map.state.child(name) = state;
  }
  return map;
}

}  // namespace

MapServices::MapServices(const ros::NodeHandle& handle, const NodeParams& params, PartCommands& own,
                         IsEmpty is_empty, Write write, Behind behind)
    : handle_(handle),
      params_(params),
      own_(own),
      is_empty_(std::move(is_empty)),
      write_(std::move(write)),
      behind_(std::move(behind)),
      others_(handle,
              {handle.resolveName(topicName(params.topic_root, "LocalView/Command")),
               handle.resolveName(topicName(params.topic_root, "PoseCell/Command"))},
              std::clamp(params.sync_timeout, 3.0, 30.0) + 2.0),
      node_queue_(handle.getCallbackQueue()),
      own_handle_(handle),
      thread_(1, &queue_) {
  own_handle_.setCallbackQueue(&queue_);
  advertiseAll();
  thread_.start();
}

MapServices::~MapServices() {
  others_.end();
  thread_.stop();
  node_queue_->removeByID(reinterpret_cast<std::uint64_t>(this));
}

std::string MapServices::inNode(std::function<std::string()> action) {
  struct Task {
    std::mutex mutex;
    std::condition_variable changed;
    bool done = false;
    bool good = false;
    std::string text;
  };
  const auto task = boost::make_shared<Task>();
  node_queue_->addCallback(boost::make_shared<PostedCall>([task, action = std::move(action)] {
                             std::string text;
                             bool good = false;
                             try {
                               text = action();
                               good = true;
                             } catch (const std::exception& e) {
                               text = e.what();
                             }
                             const std::lock_guard<std::mutex> lock(task->mutex);
                             task->text = text;
                             task->good = good;
                             task->done = true;
                             task->changed.notify_all();
                           }),
                           reinterpret_cast<std::uint64_t>(this));
  const auto done = [&task] {
    std::unique_lock<std::mutex> lock(task->mutex);
    return task->changed.wait_for(lock, std::chrono::milliseconds(20), [&task] { return task->done; });
  };
  while (!others_.wait(done, 60.0)) {
  }
  const std::lock_guard<std::mutex> lock(task->mutex);
  if (!task->good) throw std::runtime_error(task->text);
  return task->text;
}

template <class Service>
void MapServices::advertise(const char* name, std::function<std::string(typename Service::Request&)> action) {
  using Response = typename Service::Response;
  servers_.push_back(own_handle_.advertiseService<typename Service::Request, Response>(
      topicName(params_.topic_root, std::string("ExperienceMap/") + name),
      [action = std::move(action)](typename Service::Request& request, Response& response) {
        try {
          response.message = action(request);
          response.success = 1;
        } catch (const std::exception& e) {
          response.success = 0;
          response.message = e.what();
        }
        return true;
      }));
}

void MapServices::advertiseAll() {
  using Path = ratslam_ros::MapPath;
  advertise<Path>("SaveMap", [this](Path::Request& request) { return saveMap(request.path); });
  advertise<Path>("LoadMap", [this](Path::Request& request) { return loadMap(request.path); });
  advertise<std_srvs::Trigger>("Reset", [this](std_srvs::Trigger::Request&) {
    return "everything forgotten by " + toAll({command(Request::CHECK), command(Request::RESET)});
  });
  advertise<std_srvs::SetBool>("Pause", [this](std_srvs::SetBool::Request& request) {
    const bool on = request.data != 0;
    const std::string parts =
        toAll({command(Request::PAUSE, "", on)}, [this, on] { remember(kAskedPause, on); });
    return (on ? "paused: " : "goes on: ") + parts;
  });
  advertise<std_srvs::SetBool>("LocaliseOnly", [this](std_srvs::SetBool::Request& request) {
    const bool on = request.data != 0;
    std::vector<Request> requests;
    // What is not kept would be discarded. All parts keep it before the first one switches, or none switches.
    if (on) requests.push_back(command(Request::KEEP));
    requests.push_back(command(Request::LEARN, "", !on));
    std::string parts;
    try {
      parts = toAll(requests, [this, on] { remember(kAskedLocaliseOnly, on); });
    } catch (const std::runtime_error& e) {
      if (on) throw;
      // All parts learn or none: that they learn nothing cannot fail for want of a place to write.
      toAll({command(Request::LEARN, "", false)}, [this] { remember(kAskedLocaliseOnly, true); });
      throw std::runtime_error(std::string(e.what()) + "; nothing is learned");
    }
    return (on ? "nothing is learned by " : "learning: ") + parts;
  });
  advertise<std_srvs::Trigger>("WriteTrajectories", [this](std_srvs::Trigger::Request&) {
    if (params_.trajectory_file.empty()) throw std::runtime_error("the parameter trajectory_file is not set");
    return writeTrajectories(params_.trajectory_file);
  });
  advertise<Path>("SaveTrajectories", [this](Path::Request& request) {
    std::string beside;
    if (!params_.trajectory_file.empty()) {
      beside = std::filesystem::absolute(params_.trajectory_file).parent_path().string();
    }
    return writeTrajectories(pathInside(request.path, {beside, params_.map_dir}, ""));
  });
}

void MapServices::requireMap() {
  inNode([this] {
    if (is_empty_()) throw std::runtime_error("there is nothing to save yet: the map is empty");
    return std::string();
  });
}

std::string MapServices::writeTrajectories(const std::string& file) {
  requireMap();
  return inNode([this, file] { return write_(file); });
}

std::string MapServices::saveMap(const std::string& path) {
  if (path.empty()) {
    if (params_.map_dir.empty()) throw std::runtime_error("the parameter map_dir is not set");
    return "checkpoints in " + params_.map_dir + " of " + toAll({command(Request::CHECKPOINT)});
  }
  std::string file = pathInside(path, {params_.map_dir}, ".db");
  if (std::filesystem::path(file).stem().has_extension()) {
    throw std::runtime_error("path '" + path +
                             "': NAME.db must have no other dot: checkpoints are called so");
  }
  others_.requireAll();
  requireMap();
  const MapLock lock(file);
  PartFiles parts(file);
  Standstill still(others_, behind(true));
  for (const std::string& other : others_.services())
    others_.send(other, command(Request::SAVE, parts.add()));
  toOwn(command(Request::SAVE, parts.add()));
  if (const std::string why = still.end(); !why.empty())
    throw std::runtime_error(why + "; nothing was saved");
  const MapCheckpoint map = joined(parts.all());
  if (const std::string why = misfitOf(map.state); !why.empty()) {
    throw std::runtime_error("a part has started again and not yet been heard by the others: " + why +
                             "; nothing was saved, try again after some images");
  }
  MapWriter(file).save(map);
  const std::vector<std::string> faults = misfitsOf(map.state);
  return file + (faults.empty() ? "" : "; no other map can be merged with it: " + faults.front());
}

std::string MapServices::loadMap(const std::string& path) {
  std::string file = pathInside(path, {params_.map_dir}, ".db");
  // The check comes first, so that either all parts load it or none.
  return file + ": loaded by " + toAll({command(Request::CHECK, file), command(Request::LOAD, file)}) +
         "; a new stretch begins in it";
}

std::string MapServices::toAll(const std::vector<Request>& requests, const std::function<void()>& then) {
  Standstill still(others_, behind(false));
  std::string parts;
  for (const Request& request : requests) {
    parts = others_.toAll(request);
    toOwn(request);
  }
  parts += own_.part();
  if (then) then();
  if (const std::string why = still.end(); !why.empty())
    throw std::runtime_error(why + "; it was done by " + parts + ", but not at one message: ask again");
  return parts;
}

void MapServices::remember(const char* asked, bool on) {
  handle_.setParam(handle_.resolveName(topicName(params_.topic_root, asked)), on);
}

void MapServices::toOwn(const Request& request) {
  inNode([this, request] {
    own_.run(request);
    return std::string();
  });
}

PartCalls::Behind MapServices::behind(bool all) {
  return [this, all](const StreamPoint& last, Stamp last_change) {
    return inNode([this, last, last_change, all] { return behind_(last, last_change, all); });
  };
}

}  // namespace ratslam
