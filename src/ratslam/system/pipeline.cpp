#include "ratslam/system/pipeline.h"

#include <chrono>
#include <stdexcept>

#include "ratslam/common/state.h"
#include "ratslam/odometry/possible.h"
#include "ratslam/odometry/uncertainty.h"

namespace ratslam {
namespace {

constexpr std::uint32_t kCountsVersion = 1;

/// Adds the time from its construction to its destruction to a sum.
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
  map.read(params.odometry);
  map.read(params.camera);
  map.read(params.recall_geometry);
  map.read(params.images);
  map.read(params.odometry_stream);
  return params;
}

std::set<std::string> PipelineParams::knownKeys() {
  std::set<std::string> keys;
  PipelineParams params;
  params.visitFields(
      [&keys](const std::string& key, auto&, const Bounds&, const char*) { keys.insert(key); });
  return keys;
}

Pipeline::Pipeline(const PipelineParams& params, std::unique_ptr<OdometrySource> odometry,
                   const std::optional<CameraModel>& camera)
    : odometry_(std::move(odometry)),
      local_view_(params.local_view, params.recall_geometry, params.odometry_stream),
      pose_cells_(params.pose_cells, params.odometry_stream),
      map_(params.experience_map, geometrySource(params.local_view.recall, params.recall_geometry),
           params.odometry_stream) {
  if (!local_view_.needsCamera()) return;
  if (!camera) throwBadValue("vt_verify", params.recall_geometry.verify, "it needs the camera's calibration");
  local_view_.setCamera(*camera);
}

Pipeline::Progress Pipeline::expectImage(Stamp stamp) {
  Progress progress;
  local_view_.expect(stamp);
  pose_cells_.expect(stamp);
  map_.expect(stamp);
  drain(progress);
  return progress;
}

Pipeline::Progress Pipeline::addImage(const ImageFrame& frame) {
  Progress progress;
  if (odometry_) track(frame, progress);
  observe(frame, progress);
  drain(progress);
  return progress;
}

void Pipeline::track(const ImageFrame& frame, Progress& progress) {
  try {
    const Stopwatch watch(times_.odometry);
    progress.odometry.push_back(asTransmitted(odometry_->track(frame)));
  } catch (const std::invalid_argument& e) {
    progress.refusals.emplace_back(e.what());
    return;
  }
  feedOdometry(progress.odometry.back());
}

void Pipeline::observe(const ImageFrame& frame, Progress& progress) {
  try {
    const Stopwatch watch(times_.local_view);
    if (local_view_.addFrame(frame) == EventVerdict::kLate) ++late_views_;
  } catch (const std::invalid_argument& e) {
    progress.refusals.emplace_back(e.what());
  }
}

Pipeline::Progress Pipeline::addOdometry(const OdometrySample& sample) {
  Progress progress;
  progress.odometry = feedOdometry(sample);
  drain(progress);
  return progress;
}

Pipeline::Progress Pipeline::endOdometry() {
  Progress progress;
  local_view_.endOdometry();
  pose_cells_.endOdometry();
  map_.endOdometry();
  drain(progress);
  return progress;
}

std::vector<OdometrySample> Pipeline::feedOdometry(const OdometrySample& sample) {
  const SampleVerdict verdict = pose_cells_.addOdometry(sample);
  local_view_.addOdometry(sample);
  map_.addOdometry(sample);
  std::vector<OdometrySample> taken = takeDecided();
  if (verdict != SampleVerdict::kHeld && isTaken(sample, verdict)) taken.push_back(sample);
  return taken;
}

std::vector<OdometrySample> Pipeline::takeDecided() {
  std::vector<OdometrySample> taken;
  for (const DecidedSample& held : pose_cells_.takeDecided()) {
    if (isTaken(held.sample, held.verdict)) taken.push_back(held.sample);
  }
  local_view_.takeDecided();
  map_.takeDecided();
  return taken;
}

bool Pipeline::isTaken(const OdometrySample& sample, SampleVerdict verdict) {
  const std::string why = whyDropped(verdict, sample);
  const bool dropped = !why.empty();
  if (dropped && ++dropped_odometry_ == 1) first_drop_ = why;
  if (!dropped && sample.covariance) {
    const std::string absurdity = whyAbsurd(*sample.covariance);
    if (!absurdity.empty() && ++absurd_covariances_ == 1) first_absurdity_ = absurdity;
  }
  if (!dropped && !odometry_) {
    for (std::string& doubt : doubts_.add(sample)) odometry_doubts_.push_back(std::move(doubt));
  }
  return !dropped;
}

std::string Pipeline::firstDrop() const {
  const std::optional<Stamp> left_behind = pose_cells_.firstLeftBehind();
  if (!first_drop_.empty() || !left_behind) return first_drop_;
  return "its stamp " + formatStamp(*left_behind) + " is older than one that came before";
}

void Pipeline::interrupt() {
  dropped_odometry_ += pose_cells_.odometryLeftBehind();
  late_views_ = lateViews();
  unreached_views_ = unreachedViews();
  unmeasured_stretches_ = unmeasuredStretches();
  local_view_.interrupt();
  pose_cells_.interrupt();
  map_.interrupt();
}

void Pipeline::setLearning(bool learning) {
  local_view_.setLearning(learning);
  pose_cells_.setLearning(learning);
  map_.setLearning(learning);
}

void Pipeline::save(State& state) const {
  local_view_.save(state.child("local_view"));
  pose_cells_.save(state.child("pose_cells"));
  map_.save(state.child("experience_map"));
  if (odometry_) odometry_->save(state.child("odometry"));
  State& counts = state.child("pipeline");
  counts.setVersion(kCountsVersion);
  counts.set("dropped_odometry", static_cast<std::uint64_t>(dropped_odometry_));
  counts.set("late_views", static_cast<std::uint64_t>(late_views_));
  counts.set("unreached_views", static_cast<std::uint64_t>(unreached_views_));
  counts.set("absurd_covariances", static_cast<std::uint64_t>(absurd_covariances_));
  counts.set("first_absurdity", first_absurdity_);
  counts.set("unmeasured_stretches", static_cast<std::uint64_t>(unmeasured_stretches_));
  counts.set("refused_decisions", static_cast<std::uint64_t>(refused_decisions_));
  counts.set("first_refusal", first_refusal_);
}

void Pipeline::load(const State& state, bool go_on) {
  local_view_.load(state.child("local_view"));
  pose_cells_.load(state.child("pose_cells"));
  map_.load(state.child("experience_map"));
  if (odometry_ && go_on) odometry_->load(state.child("odometry"));
  if (state.hasChild("pipeline")) loadCounts(state.child("pipeline"));  // nodes keep their own counts
  if (!go_on) interrupt();
}

void Pipeline::loadCounts(const State& counts) {
  counts.requireVersion(kCountsVersion);
  dropped_odometry_ = counts.get<std::uint64_t>("dropped_odometry");
  late_views_ = counts.get<std::uint64_t>("late_views");
  unreached_views_ = counts.get<std::uint64_t>("unreached_views");
  absurd_covariances_ = counts.get<std::uint64_t>("absurd_covariances");
  counts.get("first_absurdity", first_absurdity_);
  unmeasured_stretches_ = counts.get<std::uint64_t>("unmeasured_stretches");
  refused_decisions_ = counts.get<std::uint64_t>("refused_decisions");
  counts.get("first_refusal", first_refusal_);
}

void Pipeline::drain(Progress& progress) {
  {
    const Stopwatch watch(times_.local_view);
    for (const ViewObservation& observation : local_view_.drain()) {
      progress.views.push_back(observation.view);
      if (pose_cells_.addView(observation.view) == EventVerdict::kLate) ++late_views_;
      if (observation.geometry) map_.addGeometry(*observation.geometry);
    }
  }
  {
    const Stopwatch watch(times_.pose_cells);
    progress.decisions = pose_cells_.drain();
    for (OdometrySample& sample : takeDecided()) {
      if (!odometry_) progress.odometry.push_back(std::move(sample));
    }
  }
  const Stopwatch watch(times_.experience_map);
  for (const PoseCellDecision& decision : progress.decisions) map_.addDecision(decision.action);
  progress.mapped = map_.drain();
  progress.map_refusals = map_.takeRefusals();
  if (refused_decisions_ == 0 && !progress.map_refusals.empty())
    first_refusal_ = progress.map_refusals.front();
  refused_decisions_ += progress.map_refusals.size();
}

}  // namespace ratslam
