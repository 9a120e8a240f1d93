#include "ratslam_ros/support/trajectory_files.h"

#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "ratslam/dataset/trajectory_io.h"
#include "ratslam/experience_map/map_file.h"
#include "ratslam/system/run_log.h"

namespace ratslam {

TrajectoryFiles trajectoryFiles(const std::string& file, const std::string& format) {
  std::filesystem::path base(file);
  if (base.extension() == ".tum" || base.extension() == ".txt") base.replace_extension();
  const std::string ending = format == "kitti" ? ".txt" : ".tum";
  return {base.string() + "_online" + ending, base.string() + "_final" + ending, base.string() + "_map.yaml"};
}

TrajectoryFiles writeTrajectories(const ExperienceMap& map, const std::string& file,
                                  const std::string& format) {
  TrajectoryFiles files = trajectoryFiles(file, format);
  const std::filesystem::path folder = std::filesystem::path(files.online).parent_path();
  std::error_code error;
  if (!folder.empty()) std::filesystem::create_directories(folder, error);
  if (error) throw std::runtime_error(folder.string() + ": cannot make this folder: " + error.message());
  const auto write = format == "kitti" ? writeKitti : writeTum;
  write(files.online, toPoses3(map.onlineTrajectory()));
  write(files.final, toPoses3(map.finalTrajectory()));
  std::ofstream map_file(files.map);
  writeMap(map_file, map.graph());
  map_file.flush();
  if (!map_file) throw std::runtime_error(files.map + ": cannot write this map");
  return files;
}

}  // namespace ratslam
