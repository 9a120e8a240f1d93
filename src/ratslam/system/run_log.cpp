#include "ratslam/system/run_log.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <set>
#include <stdexcept>
#include <utility>

#include "ratslam/common/state.h"
#include "ratslam/dataset/odometry_file.h"
#include "ratslam/experience_map/map_file.h"
#include "ratslam/version.h"

namespace ratslam {
namespace {

/// All files that a run may leave.
constexpr const char* kTemplates = "templates.csv";
constexpr const char* kActions = "actions.csv";
constexpr const char* kOdometry = "odometry.csv";
constexpr const char* kOdometryTrajectory = "trajectory_odometry.tum";
constexpr const char* kOnlineTrajectory = "trajectory_online.tum";
constexpr const char* kPoseCovariance = "pose_covariance.csv";
constexpr const char* kFinalTrajectory = "trajectory_final.tum";
constexpr const char* kMap = "map.yaml";
constexpr const char* kPoseCells = "pose_cells.csv";
constexpr const char* kAllPoseCells = "pose_cells.npz";
constexpr const char* kSummary = "summary.json";
constexpr std::array<const char*, 11> kAll{
    kTemplates,       kActions, kOdometry,  kOdometryTrajectory, kOnlineTrajectory, kPoseCovariance,
    kFinalTrajectory, kMap,     kPoseCells, kAllPoseCells,       kSummary};

std::string madeFolder(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw std::runtime_error(folder + ": cannot make this folder: " + error.message());
  return folder;
}

/// Files that are put in place together.
class FileSet {
 public:
  explicit FileSet(std::string folder) : folder_(std::move(folder)) {}

  std::ostream& add(const std::string& name) {
    files_.push_back(std::make_unique<AtomicFile>(folder_ + "/" + name));
    names_.insert(name);
    return files_.back()->stream();
  }
  /// Adds a file for each stretch of time, so that the stamps of each file are ascending.
  template <class Stamped, class Write>
  void addStretches(const std::string& name, const std::vector<Stamped>& values, Write write) {
    const auto stretches = stretchesOf(values);
    for (std::size_t i = 0; i < stretches.size(); ++i) {
      write(add(stretchName(name, i)), stretches[i]);
      files_.back()->close();  // a process may have few files open at once, and there may be many stretches
    }
  }
  void adopt(const char* name, AtomicFile& file) {
    adopted_.push_back(&file);
    names_.insert(name);
  }
  /// Puts all files in place once all of them are complete, and removes those of earlier runs.
  void commit() {
    for (AtomicFile* file : all()) file->close();
    for (const char* name : kAll) {
      std::error_code ignored;  // a file that cannot be removed stays
      if (names_.count(name) == 0) std::filesystem::remove(folder_ + "/" + name, ignored);
      for (std::size_t number = 1;; ++number) {
        const std::string stretch = stretchName(name, number);
        if (names_.count(stretch) == 0 && !std::filesystem::remove(folder_ + "/" + stretch, ignored)) break;
      }
    }
    for (AtomicFile* file : all()) file->commit();
  }

 private:
  std::vector<AtomicFile*> all() const {
    std::vector<AtomicFile*> all = adopted_;
    for (const auto& file : files_) all.push_back(file.get());
    return all;
  }

  std::string folder_;
  std::vector<std::unique_ptr<AtomicFile>> files_;
  std::vector<AtomicFile*> adopted_;
  std::set<std::string> names_;
};

std::vector<StampedPose3> posesOf(const std::vector<OdometrySample>& samples) {
  std::vector<StampedPose3> poses;
  for (const OdometrySample& sample : samples) {
    if (sample.pose) poses.push_back({sample.stamp, *sample.pose});
  }
  return poses;
}

/// Writes one JSON value per call, in the order of the struct.
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
      if (static_cast<unsigned char>(c) < 0x20) {  // JSON requires this form for control characters
        char code[8];
        std::snprintf(code, sizeof code, "\\u%04x", static_cast<unsigned>(c));
        out_ << code;
        continue;
      }
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
        {stamped.stamp, Eigen::Translation3d(p.x, p.y, p.z) * Eigen::Isometry3d(stamped.attitude())});
  }
  return poses;
}

RunLog::RunLog(const std::string& folder)
    : folder_(madeFolder(folder)), templates_(folder + "/" + kTemplates), actions_(folder + "/" + kActions) {
  for (const char* name : kAll) {
    if (name != kTemplates && name != kActions) requireWritable(folder + "/" + name);
  }
  templates_.stream() << "stamp,template_id,error,relative_rad\n";
  actions_.stream() << "stamp,action,src_id,dest_id,x,y,th\n";
}

bool RunLog::writes(const std::string& name) {
  return std::find(kAll.begin(), kAll.end(), name) != kAll.end();
}

void RunLog::append(const Pipeline::Progress& progress, const ExperienceMap& map) {
  frames_ += progress.views.size();
  odometry_.insert(odometry_.end(), progress.odometry.begin(), progress.odometry.end());
  for (const ViewEvent& view : progress.views) {
    views_.push_back(view);
    write(view);
  }
  for (const PoseCellDecision& decision : progress.decisions) {
    decisions_.push_back({decision.action, decision.estimate});
    write(decisions_.back());
  }
  if (progress.decisions.empty()) return;
  if (const std::optional<Eigen::Matrix4d> covariance = map.robotCovariance()) {
    known_poses_.push_back({map.onlineTrajectory().back().stamp, map.robotPose(), *covariance});
  }
}

void RunLog::write(const ViewEvent& view) {
  templates_.stream() << formatStamp(view.stamp) << ',' << (view.seen() ? std::to_string(view.id) : "-1")
                      << ',' << view.error << ',' << view.relative_rad << '\n';
}

void RunLog::write(const Decision& decision) {
  const TopologicalAction& action = decision.action;
  actions_.stream() << formatStamp(action.stamp) << ',' << static_cast<int>(action.kind) << ','
                    << action.src_id << ',' << action.dest_id << ',' << decision.estimate.x << ','
                    << decision.estimate.y << ',' << decision.estimate.th << '\n';
}

void RunLog::save(State& state) const {
  state.set("views", views_);
  state.set("decisions", decisions_);
  state.set("known_poses", known_poses_);
  State samples;
  for (std::size_t i = 0; i < odometry_.size(); ++i) samples.child(std::to_string(i)).write(odometry_[i]);
  state.set("odometry", samples.toBytes());
  state.set("samples", static_cast<std::uint64_t>(odometry_.size()));
  state.set("frames", static_cast<std::uint64_t>(frames_));
}

void RunLog::load(const State& state) {
  state.get("views", views_);
  state.get("decisions", decisions_);
  state.get("known_poses", known_poses_);
  const State samples = State::fromBytes(state.get<std::vector<std::uint8_t>>("odometry"));
  odometry_.assign(state.get<std::uint64_t>("samples"), OdometrySample{});
  for (std::size_t i = 0; i < odometry_.size(); ++i) {
    std::as_const(samples).child(std::to_string(i)).read(odometry_[i]);
  }
  frames_ = state.get<std::uint64_t>("frames");
  for (const ViewEvent& view : views_) write(view);
  for (const Decision& decision : decisions_) write(decision);
}

void RunLog::finish(const Pipeline& pipeline, PipelineParams params,
                    const std::map<std::string, double>& counts, double decoding_seconds,
                    const PoseCellSnapshots* snapshots, PoseCellRecording* cells) {
  FileSet files(folder_);
  files.adopt(kTemplates, templates_);
  files.adopt(kActions, actions_);
  files.addStretches(kOdometry, odometry_, [](auto& out, const auto& part) { writeOdometryCsv(out, part); });
  const auto write_tum = [](auto& out, const auto& part) { writeTum(out, part); };
  const std::vector<StampedPose3> odometry_poses = posesOf(odometry_);
  if (!odometry_poses.empty()) files.addStretches(kOdometryTrajectory, odometry_poses, write_tum);
  files.addStretches(kOnlineTrajectory, toPoses3(pipeline.map().onlineTrajectory()), write_tum);
  const auto write_known = [](std::ostream& out, const auto& part) {
    out << "stamp,x,y,z,yaw,xx,xy,xz,xyaw,yy,yz,yyaw,zz,zyaw,yawyaw\n";
    for (const KnownPose& known : part) {
      const MapPose& pose = known.pose;
      out << formatStamp(known.stamp) << ',' << pose.x << ',' << pose.y << ',' << pose.z << ',' << pose.yaw;
      for (int row = 0; row < 4; ++row) {
        for (int column = row; column < 4; ++column) out << ',' << known.covariance(row, column);
      }
      out << '\n';
    }
  };
  if (!known_poses_.empty()) files.addStretches(kPoseCovariance, known_poses_, write_known);
  files.addStretches(kFinalTrajectory, toPoses3(pipeline.map().finalTrajectory()), write_tum);
  writeMap(files.add(kMap), pipeline.map().graph());
  if (snapshots != nullptr) snapshots->write(files.add(kPoseCells));
  if (cells != nullptr) cells->write(files.add(kAllPoseCells));

  std::ostream& summary = files.add(kSummary);
  summary << "{\n  \"version\": \"" << version() << "\",\n  \"counts\": {";
  JsonFields count_fields(summary);
  for (const auto& [name, value] : counts) count_fields(name, value);
  count_fields("templates", static_cast<double>(pipeline.localView().size()));
  count_fields("experiences", static_cast<double>(pipeline.map().graph().experiences().size()));
  count_fields("links", static_cast<double>(pipeline.map().graph().links().size()));
  count_fields("dropped_odometry", static_cast<double>(pipeline.droppedOdometry()));
  count_fields("absurd_covariances", static_cast<double>(pipeline.absurdCovariances()));
  count_fields("unmeasured_stretches", static_cast<double>(pipeline.unmeasuredStretches()));
  count_fields("refused_decisions", static_cast<double>(pipeline.refusedDecisions()));
  count_fields("late_views", static_cast<double>(pipeline.lateViews()));
  count_fields("pose_cell_fresh_starts", static_cast<double>(pipeline.poseCells().cells().reseeds()));
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
  files.commit();
}

}  // namespace ratslam
