#include "ratslam/system/pipeline.h"

#include <chrono>
#include <memory>

#include "ratslam/odometry/orb/orb_odometry.h"

namespace ratslam {
namespace {

/// Adds the time from its construction to its end.
class Stopwatch {
 public:
  explicit Stopwatch(double& total) : total_(total), begin_(Clock::now()) {}
  ~Stopwatch() { total_ += std::chrono::duration<double>(Clock::now() - begin_).count(); }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  using Clock = std::chrono::steady_clock;
  double& total_;
  Clock::time_point begin_;
};

}  // namespace

PipelineParams PipelineParams::fromMap(const ParameterMap& map) {
  PipelineParams params;
  map.read(params.local_view);
  map.read(params.pose_cells);
  map.read(params.experience_map);
  map.read(params.profile_odometry);
  map.read(params.orb_odometry);
  map.read(params.camera);
  map.read(params.recall_geometry);
  return params;
}

std::set<std::string> PipelineParams::knownKeys() {
  std::set<std::string> keys;
  PipelineParams params;
  params.visitFields(
      [&keys](const std::string& key, auto&, const Bounds&, const char*) { keys.insert(key); });
  return keys;
}

OdometrySource profileOdometry(const PipelineParams& params) {
  return [odometry = std::make_shared<ProfileOdometry>(params.profile_odometry)](
             Stamp stamp, const cv::Mat& image) { return odometry->track(stamp, image); };
}

OdometrySource orbOdometry(const PipelineParams& params, const CameraModel& camera) {
  return [odometry = std::make_shared<OrbOdometry>(camera, params.orb_odometry)](
             Stamp stamp, const cv::Mat& image) { return odometry->track(stamp, image).sample; };
}

Pipeline::Pipeline(const PipelineParams& params, OdometrySource odometry,
                   const std::optional<CameraModel>& camera)
    : odometry_(std::move(odometry)),
      local_view_(params.local_view),
      pose_cells_(params.pose_cells),
      map_(params.experience_map, params.recall_geometry.verifies()) {
  if (!params.recall_geometry.verifies()) return;
  if (!camera) throwBadValue("vt_verify", params.recall_geometry.verify, "it needs the camera's calibration");
  recall_check_ = std::make_unique<RecallCheck>(params.recall_geometry, *camera);
}

ViewEvent Pipeline::observe(Stamp stamp, const cv::Mat& image) {
  if (!recall_check_) return local_view_.observe(stamp, image);
  RecallGeometry geometry;
  const ViewEvent view = recall_check_->observe(local_view_, stamp, image, geometry);
  map_.addGeometry(geometry);
  return view;
}

Pipeline::Progress Pipeline::addImage(Stamp stamp, const cv::Mat& image) {
  Progress progress;
  if (odometry_) {
    {
      const Stopwatch watch(times_.odometry);
      progress.odometry.push_back(asTransmitted(odometry_(stamp, image)));
    }
    feedOdometry(progress.odometry.back());
  }
  {
    const Stopwatch watch(times_.local_view);
    progress.views.push_back(observe(stamp, image));
  }
  pose_cells_.addView(progress.views.back());
  drain(progress);
  return progress;
}

Pipeline::Progress Pipeline::addOdometry(const OdometrySample& sample) {
  Progress progress;
  if (feedOdometry(sample)) progress.odometry.push_back(sample);
  drain(progress);
  return progress;
}

bool Pipeline::feedOdometry(const OdometrySample& sample) {
  const SampleVerdict verdict = pose_cells_.addOdometry(sample);
  map_.addOdometry(sample);
  const bool dropped = verdict == SampleVerdict::kNotFinite || verdict == SampleVerdict::kRepeatedStamp;
  if (dropped) ++dropped_odometry_;
  return !dropped;
}

void Pipeline::drain(Progress& progress) {
  {
    const Stopwatch watch(times_.pose_cells);
    progress.decisions = pose_cells_.drain();
  }
  const Stopwatch watch(times_.experience_map);
  for (const PoseCellDecision& decision : progress.decisions) map_.addDecision(decision.action);
  progress.mapped = map_.drain();
}

}  // namespace ratslam
