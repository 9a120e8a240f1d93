#include "ratslam_ros/support/change_log.h"

#include <algorithm>
#include <filesystem>
#include <sstream>

#include "ratslam/common/atomic_file.h"
#include "ratslam_ros/ParameterChange.h"
#include "ratslam_ros/support/conversions.h"
#include "ratslam_ros/support/trajectory_files.h"

namespace ratslam {

ChangeLog::ChangeLog(ros::NodeHandle handle, const std::string& topic)
    : subscriber_(guard_.subscribe<ratslam_ros::ParameterChange>(
          handle, topic, 0, [this](const ratslam_ros::ParameterChange& message) {
            changes_.push_back(changeFromMessage(message));
          })) {}

std::string ChangeLog::rows() const {
  std::vector<ParameterChange> sorted = changes_;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const auto& first, const auto& second) { return first.after < second.after; });
  std::string rows;
  for (const ParameterChange& change : sorted) {
    rows += std::to_string(change.after) + ',' + change.name + ',' + change.value + '\n';
  }
  return rows;
}

void ChangeLog::load(const State& state) {
  changes_.clear();
  if (state.arrays().count(kName) == 0) return;
  std::istringstream rows(state.get<std::string>(kName));
  ParameterChange change;
  for (std::string after; std::getline(rows, after, ',');) {
    change.after = std::stoll(after);
    std::getline(rows, change.name, ',');
    std::getline(rows, change.value);
    changes_.push_back(change);
  }
}

void ChangeLog::write(const std::string& file) const {
  const std::string path = trajectoryFiles(file, "tum").changes;
  if (changes_.empty()) {
    std::error_code ignored;  // a file of an earlier run that cannot be removed stays
    std::filesystem::remove(path, ignored);
    return;
  }
  AtomicFile out(path);
  out.stream() << "after_ns,name,value\n" << rows();
  out.commit();
}

}  // namespace ratslam
