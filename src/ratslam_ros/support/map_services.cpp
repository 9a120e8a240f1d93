#include "ratslam_ros/support/map_services.h"

#include <ros/service.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include <filesystem>
#include <stdexcept>

#include "ratslam/system/map_store.h"
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
    map.sessions = std::move(part.sessions);
    for (const auto& [name, state] : part.state.children()) map.state.child(name) = state;
  }
  return map;
}

}  // namespace

MapServices::MapServices(const ros::NodeHandle& handle, const NodeParams& params, PartCommands& own,
                         IsEmpty is_empty, Write write)
    : handle_(handle), params_(params), own_(own), is_empty_(std::move(is_empty)), write_(std::move(write)) {
  advertiseAll();
}

template <class Service>
void MapServices::advertise(const char* name, std::function<std::string(typename Service::Request&)> action) {
  using Response = typename Service::Response;
  servers_.push_back(handle_.advertiseService<typename Service::Request, Response>(
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
    return "everything forgotten by " + toAll(command(Request::RESET));
  });
  advertise<std_srvs::SetBool>("Pause", [this](std_srvs::SetBool::Request& request) {
    const std::string parts = toAll(command(Request::PAUSE, "", request.data != 0));
    return (request.data != 0 ? "paused: " : "goes on: ") + parts;
  });
  advertise<std_srvs::SetBool>("LocaliseOnly", [this](std_srvs::SetBool::Request& request) {
    const std::string parts = toAll(command(Request::LEARN, "", request.data == 0));
    return (request.data != 0 ? "nothing is learned by " : "learning: ") + parts;
  });
  advertise<std_srvs::Trigger>("WriteTrajectories", [this](std_srvs::Trigger::Request&) {
    if (params_.trajectory_file.empty()) throw std::runtime_error("the parameter trajectory_file is not set");
    requireMap();
    return write_(params_.trajectory_file);
  });
  advertise<Path>("SaveTrajectories", [this](Path::Request& request) {
    std::string beside;
    if (!params_.trajectory_file.empty()) {
      beside = std::filesystem::absolute(params_.trajectory_file).parent_path().string();
    }
    const std::string file = pathInside(request.path, {beside, params_.map_dir}, "");
    requireMap();
    return write_(file);
  });
}

void MapServices::requireMap() const {
  if (is_empty_()) throw std::runtime_error("there is nothing to save yet: the map is empty");
}

std::string MapServices::saveMap(const std::string& path) {
  if (path.empty()) {
    if (params_.map_dir.empty()) throw std::runtime_error("the parameter map_dir is not set");
    return "checkpoints in " + params_.map_dir + " of " + toAll(command(Request::CHECKPOINT));
  }
  std::string file = pathInside(path, {params_.map_dir}, ".db");
  if (std::filesystem::path(file).stem().has_extension()) {
    throw std::runtime_error("path '" + path +
                             "': NAME.db must have no other dot: checkpoints are called so");
  }
  const std::vector<std::string> other_parts = others();
  requireMap();
  const MapLock lock(file);
  PartFiles parts(file);
  for (const std::string& other : other_parts) send(other, command(Request::SAVE, parts.add()));
  own_.run(command(Request::SAVE, parts.add()));
  MapWriter(file).save(joined(parts.all()));
  return file;
}

std::string MapServices::loadMap(const std::string& path) {
  std::string file = pathInside(path, {params_.map_dir}, ".db");
  toAll(command(Request::CHECK, file));  // so that either all parts load it or none
  return file + ": loaded by " + toAll(command(Request::LOAD, file)) + "; a new stretch begins in it";
}

std::string MapServices::toAll(const Request& request) {
  std::string parts;
  for (const std::string& other : others()) {
    send(other, request);
    parts += other + ", ";
  }
  own_.run(request);
  return parts + own_.part();
}

std::vector<std::string> MapServices::others() const {
  std::vector<std::string> services;
  for (const char* name : {"LocalView/Command", "PoseCell/Command"}) {
    services.push_back(handle_.resolveName(topicName(params_.topic_root, name)));
    if (!ros::service::exists(services.back(), false)) {
      throw std::runtime_error("nobody offers " + services.back() +
                               ": all nodes must be up; nothing was done");
    }
  }
  return services;
}

void MapServices::send(const std::string& service, const Request& request) {
  Request copy = request;
  PartCommands::Response response;
  if (!ros::service::call(service, copy, response)) throw std::runtime_error(service + " does not answer");
  if (response.success == 0) throw std::runtime_error(response.message);
}

}  // namespace ratslam
