#include "ratslam_ros/support/trajectory_files.h"

#include <filesystem>
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
  AtomicFile online(files.online);
  AtomicFile final(files.final);
  AtomicFile map_file(files.map);
  const auto write = [&format](std::ostream& out, const std::vector<StampedPose3>& trajectory) {
    format == "kitti" ? writeKitti(out, trajectory) : writeTum(out, trajectory);
  };
  write(online.stream(), toPoses3(map.onlineTrajectory()));
  write(final.stream(), toPoses3(map.finalTrajectory()));
  writeMap(map_file.stream(), map.graph());
  for (AtomicFile* one : {&online, &final, &map_file}) one->close();  // all are whole before one appears
  for (AtomicFile* one : {&online, &final, &map_file}) one->commit();
  return files;
}

void requireTrajectoriesWritable(const std::string& file, const std::string& format) {
  if (file.empty()) return;
  const TrajectoryFiles files = trajectoryFiles(file, format);
  makeFolderOf(files.online);
  for (const std::string& path : {files.online, files.final, files.map}) requireWritable(path);
}

}  // namespace ratslam
