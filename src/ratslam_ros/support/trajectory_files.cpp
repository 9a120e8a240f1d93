#include "ratslam_ros/support/trajectory_files.h"

#include <ros/console.h>

#include <filesystem>
#include <memory>
#include <stdexcept>

#include "ratslam/common/atomic_file.h"
#include "ratslam/dataset/trajectory_io.h"
#include "ratslam/experience_map/map_file.h"
#include "ratslam/system/run_log.h"

namespace ratslam {
namespace {

void makeFolderOf(const std::string& file) {
  const std::filesystem::path folder = std::filesystem::path(file).parent_path();
  std::error_code error;
  if (!folder.empty()) std::filesystem::create_directories(folder, error);
  if (error) throw std::runtime_error(folder.string() + ": cannot make this folder: " + error.message());
}

}  // namespace

TrajectoryFiles trajectoryFiles(const std::string& file, const std::string& format) {
  std::filesystem::path base(file);
  if (base.extension() == ".tum" || base.extension() == ".txt") base.replace_extension();
  const std::string ending = format == "kitti" ? ".txt" : ".tum";
  return {base.string() + "_online" + ending, base.string() + "_final" + ending, base.string() + "_map.yaml",
          base.string() + "_changes.csv"};
}

TrajectoryFiles writeTrajectories(const ExperienceMap& map, const std::string& file,
                                  const std::string& format) {
  TrajectoryFiles files = trajectoryFiles(file, format);
  makeFolderOf(files.online);
  std::vector<std::unique_ptr<AtomicFile>> all;
  std::vector<std::string> stale;  // files of an earlier run whose time went back more often
  const auto add = [&all](const std::string& path) -> std::ostream& {
    return all.emplace_back(std::make_unique<AtomicFile>(path))->stream();
  };
  // Files with stamps have one stretch of time each; a file without stamps has all of them. @return the names
  const auto write = [&](const std::string& path, const std::vector<StampedPose3>& trajectory) {
    if (format == "kitti") {
      writeKitti(add(path), trajectory);
      return path;
    }
    std::string names;
    const auto stretches = stretchesOf(trajectory);
    for (std::size_t i = 0; i < stretches.size(); ++i) {
      const std::string name = stretchName(path, i);
      writeTum(add(name), stretches[i]);
      all.back()->close();  // a process may have few files open at once, and there may be many stretches
      names += (names.empty() ? "" : ", ") + name;
    }
    for (std::size_t i = stretches.size(); std::filesystem::exists(stretchName(path, i)); ++i) {
      stale.push_back(stretchName(path, i));
    }
    return names;
  };
  files.online = write(files.online, toPoses3(map.onlineTrajectory()));
  files.final = write(files.final, toPoses3(map.finalTrajectory()));
  writeMap(add(files.map), map.graph());
  for (const auto& one : all) one->close();  // all files must be complete before the first one is renamed
  for (const auto& one : all) one->commit();
  std::error_code ignored;
  for (const std::string& path : stale) std::filesystem::remove(path, ignored);
  return files;
}

void requireTrajectoriesWritable(const std::string& file, const std::string& format) {
  if (file.empty()) return;
  const TrajectoryFiles files = trajectoryFiles(file, format);
  makeFolderOf(files.online);
  for (const std::string& path : {files.online, files.final, files.map}) requireWritable(path);
}

void reportTrajectories(const std::string& files, bool empty) {
  if (empty) {
    ROS_WARN("nothing was mapped: the trajectories hold no more than the first pose: %s", files.c_str());
  } else {
    ROS_INFO("trajectories written: %s", files.c_str());
  }
}

}  // namespace ratslam
