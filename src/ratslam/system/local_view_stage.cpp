#include "ratslam/system/local_view_stage.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "ratslam/common/state.h"

namespace ratslam {
namespace {

/// Bound on those that wait for a view. Beyond it the oldest are joined, because the camera is dead.
constexpr std::size_t kMostCertainties = 20000;

}  // namespace

GeometrySource geometrySource(const ViewRecallParams& recall, const RecallGeometryParams& geometry) {
  if (geometry.verifies()) return GeometrySource::kImages;
  return recall.believes() ? GeometrySource::kLikeness : GeometrySource::kNone;
}

template <class Fields>
void LocalViewStage::WaitingView::stateFields(Fields&& fields) {
  std::vector<int> form{image.rows, image.cols, image.type()};
  std::vector<std::uint8_t> pixels;
  if (!image.empty()) pixels.assign(image.datastart, image.dataend);
  fields("stamp", stamp);
  view.stateFields(fields);
  fields("image", form);
  fields("pixels", pixels);
  if (pixels.empty() || !image.empty()) return;
  if (form.size() != 3 || form[0] < 1 || form[1] < 1 || (form[2] & CV_MAT_TYPE_MASK) != form[2] ||
      static_cast<std::uint64_t>(form[0]) * static_cast<std::uint64_t>(form[1]) * CV_ELEM_SIZE(form[2]) !=
          pixels.size()) {
    throw std::runtime_error("state: the pixels of a waiting image do not fit its size");
  }
  image.create(form[0], form[1], form[2]);
  std::copy(pixels.begin(), pixels.end(), image.data);
}

LocalViewStage::LocalViewStage(const LocalViewParams& params, const RecallGeometryParams& recall_params,
                               const OdometryStreamParams& stream)
    : recall_params_(recall_params), stream_(stream), cells_(params), gate_(false, stream) {}

void LocalViewStage::setCamera(const CameraModel& camera) {
  if (recall_params_.verifies()) recall_check_ = std::make_unique<RecallCheck>(recall_params_, camera);
}

SampleVerdict LocalViewStage::addOdometry(const OdometrySample& sample) {
  if (!needsOdometry()) return SampleVerdict::kAccepted;
  followDecided();  // those that an event has decided
  const std::uint64_t unmeasured = gate_.odometry().unmeasured();
  const SampleVerdict verdict = gate_.addOdometry(sample);
  std::uint64_t before = 0;
  for (const DecidedSample& held : followDecided()) before += held.unmeasured ? 1U : 0U;
  follow(
      {sample, verdict, gate_.odometry().unmeasured() > unmeasured + before, gate_.isPutAside(sample.stamp)});
  return verdict;
}

std::vector<DecidedSample> LocalViewStage::followDecided() {
  std::vector<DecidedSample> decided = gate_.takeDecided();
  for (const DecidedSample& held : decided) follow(held);
  decided_.insert(decided_.end(), decided.begin(), decided.end());
  return decided;
}

std::vector<DecidedSample> LocalViewStage::takeDecided() {
  followDecided();
  return std::exchange(decided_, {});
}

void LocalViewStage::endOdometry() {
  gate_.acceptHeld();
  followDecided();
}

void LocalViewStage::follow(const DecidedSample& decided) {
  if (decided.verdict != SampleVerdict::kAccepted && decided.verdict != SampleVerdict::kTimeWentBack) return;
  settleAside();
  if (decided.put_aside) {
    aside_.push_back(decided.sample);
    if (aside_.size() > EventGate<WaitingView>::kMostEarlier) aside_.pop_front();  // as the gate does
    return;
  }
  follow(decided.sample, decided.verdict == SampleVerdict::kTimeWentBack, decided.unmeasured);
}

/// Once the time has begun to which the samples put aside belong, their certainties are those that count. If the old
/// time has gone on instead, they were another source's.
void LocalViewStage::settleAside() {
  if (aside_.empty() || gate_.putsAside()) return;
  const std::deque<OdometrySample> samples = std::exchange(aside_, {});
  if (gate_.clockStart() != samples.front().stamp) return;
  for (const OdometrySample& sample : samples) follow(sample, &sample == &samples.front(), false);
}

void LocalViewStage::follow(const OdometrySample& sample, bool back, bool broken) {
  if (back) certainties_.clear();
  const bool anew = last_sample_ && sample.epoch != source_epoch_;
  if (broken || anew) ++epoch_;
  Certainty certainty;
  certainty.stamp = sample.stamp;
  certainty.epoch = epoch_;
  if (sample.covariance && last_sample_ && !back && !broken) {
    const double dt = secondsBetween(*last_sample_, sample.stamp);
    certainty.forward_variance = (*sample.covariance)(0, 0) * dt * dt;
    certainty.yaw_variance = (*sample.covariance)(5, 5) * dt * dt;
  }
  if (broken || (anew && !back)) certainty.unmeasured_s = secondsBetween(*last_sample_, sample.stamp);
  if (broken) ++epoch_;  // places before and after the break cannot be compared by dead reckoning
  certainties_.push_back(certainty);
  if (certainties_.size() > kMostCertainties) joinOldest();
  last_sample_ = sample.stamp;
  source_epoch_ = sample.epoch;
}

void LocalViewStage::joinOldest() {
  const Certainty oldest = certainties_.front();
  certainties_.pop_front();
  const auto add = [](std::optional<double>& to, const std::optional<double>& variance) {
    to = to && variance ? std::optional<double>(*to + *variance) : std::nullopt;
  };
  add(certainties_.front().forward_variance, oldest.forward_variance);
  add(certainties_.front().yaw_variance, oldest.yaw_variance);
}

EventVerdict LocalViewStage::addFrame(const ImageFrame& frame) {
  if (needsCamera()) throw std::logic_error("recalls are to be verified before the camera is known");
  if (recall_check_) recall_check_->requireSize(frame.image);
  if (frame.begins_anew) cells_.acceptAnotherSize();
  WaitingView waiting;
  waiting.stamp = frame.stamp;
  waiting.view.textured = false;
  if (frame.usable()) waiting.view = cells_.describe(frame.image);
  // The pixels may belong to a message that does not live until the view is decided.
  if (recall_check_) waiting.image = needsOdometry() ? frame.image.clone() : frame.image;
  const EventVerdict verdict = gate_.addEvent(waiting);
  followDecided();  // an image may decide about a held sample, of which a checkpoint must know
  return verdict;
}

std::vector<ViewObservation> LocalViewStage::drain(Passing which) {
  std::vector<ViewObservation> seen;
  if (which == Passing::kAll && needsOdometry()) endOdometry();
  gate_.pass(needsOdometry() ? which : Passing::kAll, [&](const WaitingView& waiting) {
    seen.push_back(process(waiting));
    return true;
  });
  return seen;
}

ViewMotion LocalViewStage::motionUntil(Stamp stamp) {
  ViewMotion motion;
  const auto steps = gate_.motionUntil(stamp);
  motion.assumed = steps.empty();
  motion.epoch = epoch_;
  auto certainty = certainties_.begin();
  for (const TimedStep& timed : steps) {
    motion.forward += timed.step.forward;
    motion.rotation += timed.step.rotation;
    while (certainty != certainties_.end() && certainty->stamp < timed.end) ++certainty;
    const double unmeasured_s = certainty != certainties_.end() ? certainty->unmeasured_s : 0.0;
    if (unmeasured_s > 0.0 && timed.step.bridged && timed.step.covariance) {
      // The covariance of a part of a step is that of a random walk. But an unknown speed is constant over the stretch.
      motion.unmeasured += std::sqrt((*timed.step.covariance)(0, 0) * timed.step.dt / unmeasured_s);
    }
  }
  double forward_variance = 0.0;
  double yaw_variance = 0.0;
  bool said = !certainties_.empty();
  // A sample beyond the stamp belongs to the next view.
  while (!certainties_.empty() && certainties_.front().stamp <= stamp) {
    const Certainty& passed = certainties_.front();
    said = said && passed.forward_variance.has_value();
    forward_variance += passed.forward_variance.value_or(0.0);
    yaw_variance += passed.yaw_variance.value_or(0.0);
    motion.epoch = passed.epoch;
    certainties_.pop_front();
  }
  if (!certainties_.empty()) motion.epoch = certainties_.front().epoch;
  motion.epoch += static_cast<std::uint32_t>(gate_.beginnings());
  if (said) {
    motion.forward_variance = forward_variance;
    motion.yaw_variance = yaw_variance;
  }
  return motion;
}

ViewObservation LocalViewStage::process(const WaitingView& waiting) {
  changes_.applyBefore(waiting.stamp, cells_);
  followDecided();
  settleAside();
  if (std::exchange(beginnings_, gate_.beginnings()) != gate_.beginnings()) cells_.wakeUp();
  const ViewMotion motion = needsOdometry() ? motionUntil(waiting.stamp) : ViewMotion{};
  ViewObservation observation;
  const bool checked = recall_check_ && waiting.view.textured;
  observation.view = checked
                         ? recall_check_->observe(cells_, waiting.stamp, waiting.view, waiting.image, motion)
                         : cells_.observe(waiting.stamp, waiting.view, waiting.image, motion);
  if (geometrySource() == GeometrySource::kNone) return observation;
  RecallGeometry geometry;
  if (waiting.view.textured) geometry = cells_.recallGeometry().value_or(geometry);
  geometry.stamp = waiting.stamp;
  geometry.view_id = observation.view.id;
  observation.geometry = geometry;
  return observation;
}

void LocalViewStage::interrupt() {
  epoch_ = epoch() + 1;  // another one than that of any view so far
  gate_ = EventGate<WaitingView>(false, stream_);
  certainties_.clear();
  last_sample_.reset();
  aside_.clear();
  beginnings_ = 0;
  cells_.wakeUp();
}

void LocalViewStage::save(State& state) const {
  cells_.save(state);
  if (recall_check_) recall_check_->save(state.child("recall_check"));
  State& streams = state.child("streams");
  streams.set("views", gate_);
  streams.set("certainties", certainties_);
  streams.set("last_sample", last_sample_);
  streams.set("aside", aside_);
  streams.set("source_epoch", source_epoch_);
  streams.set("epoch", epoch_);
  streams.set("beginnings", beginnings_);
}

void LocalViewStage::load(const State& state) {
  cells_.load(state);
  if (recall_check_) recall_check_->load(state.child("recall_check"));
  const State& streams = state.child("streams");
  streams.get("views", gate_);
  streams.get("certainties", certainties_);
  streams.get("last_sample", last_sample_);
  streams.get("aside", aside_);
  streams.get("source_epoch", source_epoch_);
  streams.get("epoch", epoch_);
  streams.get("beginnings", beginnings_);
}

}  // namespace ratslam
