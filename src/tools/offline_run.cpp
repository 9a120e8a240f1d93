#include "offline_run.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <sstream>

#include "configuration.h"
#include "ratslam/camera/calibration_file.h"
#include "ratslam/common/progress_bar.h"
#include "ratslam/common/stop_signal.h"
#include "ratslam/dataset/odometry_file.h"
#include "ratslam/dataset/trajectory_io.h"
#include "ratslam/odometry/orb/orb_params.h"
#include "ratslam/odometry/profile/profile_odometry.h"
#include "ratslam/odometry/registry.h"
#include "ratslam/system/map_fit.h"
#include "ratslam/version.h"
#include "ratslam_ros/support/node_params.h"

namespace ratslam {
namespace {

constexpr std::size_t kSnapshots = 6;  // number of snapshots of the pose cells if no times are given

std::string shortText(double number) {
  std::ostringstream text;
  text << number;
  return text.str();
}

void say(const std::string& text) { std::cerr << "ratslam_run: " << text << '\n'; }

/// Selects the calibration: first that of the command line, then the configuration's, then the recording's.
std::optional<CameraModel> chooseCamera(const RunOptions& options, const PipelineParams& params,
                                        const Recording& recording) {
  if (!options.calibration.empty()) return readCalibration(options.calibration);
  return params.camera.model() ? params.camera.model() : recording.camera();
}

std::unique_ptr<Recording> openWithOdometry(const RunOptions& options, const PipelineParams& params,
                                            const OdometryKind& kind) {
  RecordingOptions recording_options = options.recording;
  recording_options.limits = params.images.limits();
  recording_options.with_odometry = kind.origin == OdometryOrigin::kTopic;
  std::unique_ptr<Recording> recording = openRecording(options.input, recording_options);
  if (kind.origin != OdometryOrigin::kTopic && !options.recording.odometry_topic.empty()) {
    throwBadValue("--odometry-topic", options.recording.odometry_topic,
                  "it is for --odometry topic, not " + options.odometry);
  }
  if (kind.origin == OdometryOrigin::kFile) {
    recording =
        std::make_unique<RecordingWithOdometry>(std::move(recording), readOdometryCsv(options.odometry));
  }
  const std::size_t all = recording->imageCount();
  if (options.from_frame > 0 && options.from_frame >= all) {
    throwBadValue("--from-frame", options.from_frame,
                  options.input + " has " + std::to_string(all) + " images, counted from 0");
  }
  for (std::size_t images = 0; images < options.from_frame;) {
    const auto item = recording->next();
    if (!item) break;
    if (std::holds_alternative<RecordedImage>(*item)) ++images;
  }
  return recording;
}

std::unique_ptr<Pipeline> makePipeline(const RunOptions& options, const PipelineParams& params,
                                       const OdometryKind& kind, const Recording& recording) {
  // If the calibration is not needed, it may be missing or malformed.
  const bool needed = kind.needs_camera || params.recall_geometry.verifies() || !options.calibration.empty();
  const auto camera = needed ? chooseCamera(options, params, recording) : std::nullopt;
  const auto doubt = camera ? camera->doubt() : std::nullopt;
  if (doubt) say(options.input + ": " + *doubt);
  if (kind.name == "orb") params.odometry.of<OrbOdometryParams>().requireNoCameraFrame();
  std::unique_ptr<OdometrySource> source;
  if (kind.origin == OdometryOrigin::kImages) source = params.odometry.make(kind, camera);
  return std::make_unique<Pipeline>(params, std::move(source), camera);
}

std::optional<Stamp> stampOfNextImage(Recording& recording) {
  while (const auto item = recording.next()) {
    if (const auto* image = std::get_if<RecordedImage>(&*item)) return image->stamp;
  }
  return std::nullopt;
}

SnapshotMoments chooseMoments(const RunOptions& options, std::size_t frames) {
  return options.pose_cells_at.empty() ? SnapshotMoments::evenly(kSnapshots, frames)
                                       : SnapshotMoments::fromTimes(options.pose_cells_at);
}

}  // namespace

OfflineRun::OfflineRun(const RunOptions& options)
    : options_(options),
      parameters_(readConfiguration("ratslam_run", options.config, options.assignments)),
      params_(PipelineParams::fromMap(parameters_)),
      images_(params_.images,
              [this](ImageEvent event, const std::string& text) {
                bool& said = said_[static_cast<std::size_t>(event)];
                if (!said) say(text);
                said = true;
              }),
      snapshots_(SnapshotMoments{}) {
  requireOutputsApart(options);
  const OdometryRegistry odometries = standardOdometry();
  const OdometryKind& kind = odometries.find(options.odometry);
  recording_ = openWithOdometry(options, params_, kind);
  for (const std::string& remark : recording_->remarks()) say(remark);
  pipeline_ = makePipeline(options, params_, kind, *recording_);
  sayWhatIsForNodes();
  if (!options.changes.empty()) {
    changes_ = readParameterChanges(options.changes);
    addChanges(changes_, parameters_, *pipeline_);
  }
  // A run in several parts takes the snapshots that one run over the whole recording would take.
  const bool in_parts = !options.save_map.empty() || !options.load_map.empty();
  snapshots_ = PoseCellSnapshots(chooseMoments(options, in_parts ? recording_->imageCount() : totalFrames()));
  if (options.pose_cells_every > 0) cells_.emplace(options.pose_cells_every);
  map_parameters_ = parameterTexts(params_);
  map_parameters_["odometry"] = kind.name;
  log_ = std::make_unique<RunLog>(options.out);
  if (!options.load_map.empty()) loadMap(kind);
  pipeline_->setLearning(!options.localise_only);
  if (!options.video.empty()) {
    video_ =
        std::make_unique<RunVideo>(options.video, params_.odometry.of<ProfileOdometryParams>().camera_hz);
  }
  if (!options.save_map
           .empty()) {  // the last step, because an error before it must not leave an empty map file
    map_is_new_ = !std::filesystem::exists(options.save_map);
    map_lock_ = std::make_unique<MapLock>(options.save_map);
    map_writer_ = std::make_unique<MapWriter>(options.save_map);
  }
}

void OfflineRun::loadMap(const OdometryKind& kind) {
  const MapCheckpoint map = loadMapFile(options_.load_map);
  requireAllParts(options_.load_map, map.state);
  requireParameters(options_.load_map, map, map_parameters_);
  const std::optional<Stamp> next = stampOfNextImage(*openWithOdometry(options_, params_, kind));
  const bool has_run = map.state.hasChild("run");  // a pruned map has none
  ImageStage saved_images(params_.images, nullptr);
  if (has_run) saved_images.load(map.state.child("run").child("images"));
  const bool go_on = next && saved_images.isContinuedBy(*next);
  try {
    pipeline_->load(map.state, go_on);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(options_.load_map + ": " + error.what());
  }
  sessions_ = map.sessions;
  last_stamp_ = map.stamp;
  if (has_run) log_->load(map.state.child("run").child("log"));
  if (go_on) {
    const State& run = map.state.child("run");
    images_.load(run.child("images"));
    snapshots_.load(run.child("snapshots"), pipeline_->poseCells().cells());
    run.get("span", span_);
  } else {
    say(options_.load_map + ": this recording does not follow it: a new stretch begins in its map");
  }
}

void OfflineRun::sayWhatIsForNodes() const {
  NodeParams nodes;
  parameters_.read(nodes);
  const auto remark = [](const std::string& key, const std::string& value, const std::string& instead) {
    say(key + ": value " + value + " is for nodes and has no effect here; " + instead);
  };
  if (nodes.stamp_source == "arrival")
    remark("stamp_source", nodes.stamp_source, "a recording has the stamps of its images");
  if (nodes.localise_only) remark("localise_only", "true", "the option is --localise-only");
  if (!nodes.map_dir.empty()) remark("map_dir", nodes.map_dir, "the options are --load-map and --save-map");
  if (!nodes.trajectory_file.empty())
    remark("trajectory_file", nodes.trajectory_file, "trajectories lie in the folder of --out");
  if (nodes.trajectory_format != NodeParams().trajectory_format)
    remark("trajectory_format", nodes.trajectory_format, "scripts/trajectory_convert writes it");
}

bool OfflineRun::saveMap() const {
  if (!map_writer_ || !last_stamp_) return true;
  MapCheckpoint map;
  map.stamp = *last_stamp_;
  map.parameters = map_parameters_;
  map.sessions = sessions_;
  map.sessions.push_back({version(), first_stamp_.value_or(map.stamp), map.stamp});
  try {
    pipeline_->save(map.state);
    State& run = map.state.child("run");
    log_->save(run.child("log"));
    images_.save(run.child("images"));
    snapshots_.save(run.child("snapshots"));
    run.set("span", span_);
    map_writer_->save(map);
    return true;
  } catch (const std::exception& e) {  // the results are still written
    say(std::string("the map is not saved: ") + e.what());
    return false;
  }
}

std::string OfflineRun::withoutMap() {
  map_writer_.reset();
  if (!map_is_new_) return options_.save_map + " stays as it was";
  std::error_code ignored;  // an empty map file that cannot be removed stays
  std::filesystem::remove(options_.save_map, ignored);
  return options_.save_map + " is not written";
}

std::size_t OfflineRun::totalFrames() const {
  const std::size_t all = recording_->imageCount() - std::min(options_.from_frame, recording_->imageCount());
  return options_.max_frames == 0 ? all : std::min(options_.max_frames, all);
}

bool OfflineRun::wanted() const {
  return !stopRequested() && (options_.max_frames == 0 || taken_ < options_.max_frames);
}

bool OfflineRun::run() {
  std::string failure;
  double decoding_seconds = 0.0;
  {
    ProgressBar bar(std::cerr, totalFrames(), "frames", isatty(STDERR_FILENO) != 0);
    DecodeAhead items(*recording_, options_.decode_threads);
    try {
      while (wanted()) {
        const auto item = items.next();
        if (!item) break;
        if (const auto* sample = std::get_if<OdometrySample>(&*item)) {
          follow(pipeline_->addOdometry(*sample));
        } else {
          addImage(std::get<DecodedImage>(*item));
          bar.update(++taken_);
        }
      }
    } catch (const std::exception& e) {
      failure = e.what();
    }
    decoding_seconds = items.decodingSeconds();
  }
  if (!failure.empty()) say("ended in the middle: " + failure);
  if (nothingCameOfIt()) follow(pipeline_->endOdometry());
  const std::optional<std::string> nothing = nothingCameOfIt();
  const bool kept =
      nothing ? map_writer_ == nullptr : saveMap();  // a good map is not replaced by an empty one
  // Only after saving, because a later run may still decide whether the last sample is ahead of time.
  follow(pipeline_->endOdometry());
  finish(decoding_seconds);
  sayWhatWasLeft();
  if (nothing) say(*nothing + (kept ? "" : "; " + withoutMap()));
  return failure.empty() && !nothing && kept && !snapshotsAreMissing();
}

void OfflineRun::addImage(const DecodedImage& image) {
  const std::optional<ImageFrame> frame = images_.add(image);
  if (!frame) return;
  last_stamp_ = frame->stamp;
  if (!first_stamp_) first_stamp_ = frame->stamp;
  follow(pipeline_->expectImage(frame->stamp));
  const Pipeline::Progress progress = pipeline_->addImage(*frame);
  for (const std::string& why : progress.refusals) images_.refused(image.name, why);
  follow(progress);
  if (video_ && !progress.views.empty()) video_->add(*pipeline_, frame->image);
}

void OfflineRun::follow(const Pipeline::Progress& progress) {
  for (const OdometrySample& sample : progress.odometry) span_.addOdometry(sample.stamp);
  for (const ViewEvent& view : progress.views) span_.addView(view.stamp);
  log_->append(progress, pipeline_->map());
  snapshots_.follow(progress, pipeline_->poseCells().cells());
  if (cells_) {
    for (const PoseCellDecision& decision : progress.decisions) {
      cells_->add(decision.view.stamp, pipeline_->poseCells().cells().activity());
    }
  }
  if (video_) video_->follow(progress);
}

void OfflineRun::finish(double decoding_seconds) {
  pipeline_->settle();
  std::map<std::string, double> counts;
  images_.counts().visit(
      [&counts](const std::string& name, std::size_t number) { counts[name] = static_cast<double>(number); });
  span_.end(pipeline_->waitingImages(), pipeline_->waitingViews(), pipeline_->unreachedViews());
  counts["images_outside_odometry"] = static_cast<double>(span_.viewsOutside());
  log_->finish(*pipeline_, params_, counts, decoding_seconds, &snapshots_, cells_ ? &*cells_ : nullptr);
  if (video_) video_->finish();
}

void OfflineRun::sayWhatWasLeft() const {
  std::cout << images_.counts().text() << ", " << pipeline_->localView().size() << " templates, "
            << pipeline_->map().graph().experiences().size() << " experiences, "
            << pipeline_->map().graph().links().size() << " links -> " << options_.out << '\n';
  const std::size_t stretches = stretchesOf(pipeline_->map().onlineTrajectory()).size();
  if (stretches > 1) {
    say("time went back: the " + std::to_string(stretches) +
        " stretches of each trajectory lie in files of their own, " + stretchName("trajectory_final.tum", 1) +
        " after trajectory_final.tum");
  }
  if (stopRequested()) std::cout << "interrupted: the results hold what was mapped so far\n";
  if (const auto complaint = span_.complaint()) say(*complaint);
  if (const auto starts = pipeline_->poseCells().cells().reseeds(); starts > 0) {
    say("all activity of the pose cells died " + std::to_string(starts) +
        " times; each time they started again at the last best estimate");
  }
  if (const auto refused = pipeline_->refusedDecisions(); refused > 0) {
    say(std::to_string(refused) + " decisions cannot be mapped, the first: " + pipeline_->firstRefusal());
  }
  sayWhatOdometryLacks();
  if (cells_ && cells_->leftOut() > 0) {
    say("pose_cells.npz: full with " + std::to_string(cells_->size()) +
        " snapshots, since it may have 4 GB: the last " + std::to_string(cells_->leftOut()) +
        " are left out; take fewer with --pose-cells-every");
  }
  // If the map is saved, a later run may reach the later changes.
  const auto unreached =
      last_stamp_ && options_.save_map.empty() ? changesNeverReached(changes_, *last_stamp_) : std::nullopt;
  if (unreached) say(*unreached);
}

void OfflineRun::sayWhatOdometryLacks() const {
  const std::vector<StampedPose>& poses = pipeline_->map().onlineTrajectory();
  const auto at_start = [&poses](const StampedPose& pose) {
    const MapPose& first = poses.front().pose;
    return pose.pose.x == first.x && pose.pose.y == first.y && pose.pose.z == first.z;
  };
  if (poses.size() > 1 && std::all_of(poses.begin(), poses.end(), at_start)) {
    say("the odometry never moves: all " + std::to_string(poses.size()) + " poses lie at one place");
  }
  const auto count = [](std::size_t number, const char* of_what) { return std::to_string(number) + of_what; };
  if (pipeline_->absurdCovariances() > 0) {
    say(count(pipeline_->absurdCovariances(),
              " covariances of the odometry cannot be used, the defaults apply: ") +
        pipeline_->firstAbsurdity());
  }
  for (const std::string& doubt : pipeline_->odometryDoubts()) say("odometry: " + doubt);
  if (pipeline_->droppedOdometry() > 0) {
    say(count(pipeline_->droppedOdometry(), " samples of odometry dropped") +
        (pipeline_->firstDrop().empty() ? "" : ", the first since " + pipeline_->firstDrop()));
  }
  if (pipeline_->unmeasuredStretches() > 0) {
    say(count(
            pipeline_->unmeasuredStretches(),
            " stretches between samples of odometry are not measured: they last longer than odometry_gap (") +
        shortText(params_.odometry_stream.odometry_gap) +
        " s), the pose jumps, or the odometry predicts them and states no covariance");
  }
}

std::optional<std::string> OfflineRun::nothingCameOfIt() const {
  if (images_.counts().used == 0) {
    return options_.input + ": none of its images could be used: " + images_.counts().text();
  }
  const OdometrySource* source = pipeline_->odometry();
  if (const auto failure = source != nullptr ? source->failure() : std::nullopt) {
    return options_.input + ": " + *failure;
  }
  if (pipeline_->map().graph().experiences().empty()) {
    return options_.input + ": nothing was mapped: " + images_.counts().text();
  }
  return std::nullopt;
}

bool OfflineRun::snapshotsAreMissing() const {
  // If the map is saved, a later run may reach the later times.
  if (stopRequested() || !options_.save_map.empty()) return false;
  const auto complaint = snapshots_.complaint();
  if (complaint) say(*complaint);
  return complaint.has_value();
}

}  // namespace ratslam
