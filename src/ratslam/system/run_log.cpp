#include "ratslam/system/run_log.h"

#include <filesystem>
#include <limits>
#include <stdexcept>

#include "ratslam/dataset/odometry_file.h"
#include "ratslam/experience_map/map_file.h"
#include "ratslam/version.h"

namespace ratslam {
namespace {

std::ofstream open(const std::string& path) {
  std::ofstream file(path);
  if (!file) throw std::runtime_error(path + ": cannot write this file");
  file.precision(std::numeric_limits<double>::max_digits10);
  return file;
}

void requireWritten(std::ofstream& file, const std::string& path) {
  file.flush();
  if (!file) throw std::runtime_error(path + ": cannot write this file");
}

std::vector<StampedPose3> posesOf(const std::vector<OdometrySample>& samples) {
  std::vector<StampedPose3> poses;
  for (const OdometrySample& sample : samples) {
    if (sample.pose) poses.push_back({sample.stamp, *sample.pose});
  }
  return poses;
}

/// Writes one JSON value a call, in the struct's order.
class JsonFields {
 public:
  explicit JsonFields(std::ostream& out) : out_(out) {}

  template <class T>
  void operator()(const std::string& key, const T& value, const Bounds& = {}, const char* = nullptr) {
    out_ << (first_ ? "\n    \"" : ",\n    \"") << key << "\": ";
    first_ = false;
    write(value);
  }

 private:
  void write(bool value) { out_ << (value ? "true" : "false"); }
  void write(int value) { out_ << value; }
  void write(double value) { out_ << value; }
  void write(const std::string& value) {
    out_ << '"';
    for (const char c : value) {
      if (c == '"' || c == '\\') out_ << '\\';
      out_ << c;
    }
    out_ << '"';
  }
  void write(const std::vector<double>& values) {
    out_ << '[';
    for (std::size_t i = 0; i < values.size(); ++i) out_ << (i == 0 ? "" : ", ") << values[i];
    out_ << ']';
  }

  std::ostream& out_;
  bool first_ = true;
};

}  // namespace

std::vector<StampedPose3> toPoses3(const std::vector<StampedPose>& trajectory) {
  std::vector<StampedPose3> poses;
  poses.reserve(trajectory.size());
  for (const StampedPose& stamped : trajectory) {
    const MapPose& p = stamped.pose;
    poses.push_back(
        {stamped.stamp, Eigen::Translation3d(p.x, p.y, p.z) *
                            Eigen::Isometry3d(Eigen::AngleAxisd(p.yaw, Eigen::Vector3d::UnitZ()))});
  }
  return poses;
}

RunLog::RunLog(const std::string& folder) : folder_(folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw std::runtime_error(folder + ": cannot make this folder: " + error.message());
  templates_ = open(folder + "/templates.csv");
  templates_ << "stamp,template_id,error,relative_rad\n";
  actions_ = open(folder + "/actions.csv");
  actions_ << "stamp,action,src_id,dest_id,x,y,th\n";
}

void RunLog::append(const Pipeline::Progress& progress) {
  frames_ += progress.views.size();
  odometry_.insert(odometry_.end(), progress.odometry.begin(), progress.odometry.end());
  for (const ViewEvent& view : progress.views) {
    templates_ << formatStamp(view.stamp) << ',' << view.id << ',' << view.error << ',' << view.relative_rad
               << '\n';
  }
  for (const PoseCellDecision& decision : progress.decisions) {
    const TopologicalAction& action = decision.action;
    actions_ << formatStamp(action.stamp) << ',' << static_cast<int>(action.kind) << ',' << action.src_id
             << ',' << action.dest_id << ',' << decision.estimate.x << ',' << decision.estimate.y << ','
             << decision.estimate.th << '\n';
  }
}

void RunLog::finish(const Pipeline& pipeline, PipelineParams params,
                    const std::map<std::string, double>& counts, double decoding_seconds) {
  requireWritten(templates_, folder_ + "/templates.csv");
  requireWritten(actions_, folder_ + "/actions.csv");
  writeOdometryCsv(folder_ + "/odometry.csv", odometry_);
  const std::vector<StampedPose3> odometry_poses = posesOf(odometry_);
  if (!odometry_poses.empty()) writeTum(folder_ + "/trajectory_odometry.tum", odometry_poses);
  writeTum(folder_ + "/trajectory_online.tum", toPoses3(pipeline.map().onlineTrajectory()));
  writeTum(folder_ + "/trajectory_final.tum", toPoses3(pipeline.map().finalTrajectory()));
  std::ofstream map = open(folder_ + "/map.yaml");
  writeMap(map, pipeline.map().graph());
  requireWritten(map, folder_ + "/map.yaml");

  const std::string path = folder_ + "/summary.json";
  std::ofstream summary = open(path);
  summary << "{\n  \"version\": \"" << version() << "\",\n  \"counts\": {";
  JsonFields count_fields(summary);
  for (const auto& [name, value] : counts) count_fields(name, value);
  count_fields("templates", static_cast<double>(pipeline.localView().size()));
  count_fields("experiences", static_cast<double>(pipeline.map().graph().experiences().size()));
  count_fields("links", static_cast<double>(pipeline.map().graph().links().size()));
  count_fields("dropped_odometry", static_cast<double>(pipeline.droppedOdometry()));
  summary << "\n  },\n  \"timing\": {";
  JsonFields time_fields(summary);
  const double ms_per_frame = frames_ == 0 ? 0.0 : 1e3 / static_cast<double>(frames_);
  time_fields("decoding", decoding_seconds * ms_per_frame);
  time_fields("odometry", pipeline.times().odometry * ms_per_frame);
  time_fields("local_view", pipeline.times().local_view * ms_per_frame);
  time_fields("pose_cells", pipeline.times().pose_cells * ms_per_frame);
  time_fields("experience_map", pipeline.times().experience_map * ms_per_frame);
  summary << "\n  },\n  \"parameters\": {";
  JsonFields parameter_fields(summary);
  params.visitFields(parameter_fields);
  summary << "\n  }\n}\n";
  requireWritten(summary, path);
}

}  // namespace ratslam
