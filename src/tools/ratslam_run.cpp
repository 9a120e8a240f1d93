// ratslam_run: the whole system over a recording, without a roscore, as fast as the machine allows.
#include <unistd.h>

#include <csignal>
#include <iostream>
#include <memory>

#include "ratslam/camera/calibration_file.h"
#include "ratslam/common/progress_bar.h"
#include "ratslam/dataset/odometry_file.h"
#include "ratslam/system/pose_cell_snapshots.h"
#include "ratslam/system/run_log.h"
#include "ratslam/view/run_video.h"
#include "recordings.h"
#include "run_options.h"

namespace {

using namespace ratslam;

constexpr std::size_t kSnapshots = 6;  // of the pose cells, where no times are given

volatile std::sig_atomic_t interrupted = 0;

/// The calibration that counts: the one named on the command line, the configuration's, the recording's own.
std::optional<CameraModel> chooseCamera(const RunOptions& options, const PipelineParams& params,
                                        const Recording& recording) {
  if (!options.calibration.empty()) return readCalibration(options.calibration);
  return params.camera.model() ? params.camera.model() : cameraOf(recording);
}

/// Where the odometry comes from; samples from a file are laid into the recording.
OdometrySource chooseOdometry(const RunOptions& options, const PipelineParams& params,
                              const std::optional<CameraModel>& camera,
                              std::unique_ptr<Recording>& recording) {
  if (options.odometry == "profile") return profileOdometry(params);
  if (options.odometry == "orb") {
    if (!camera) {
      throw std::runtime_error(options.input +
                               ": --odometry orb needs a calibration: calib.txt, camera_info in the " +
                               "bag, --calibration FILE, or camera_fx ... in the configuration");
    }
    return orbOdometry(params, *camera);
  }
  if (options.odometry != "topic") {
    recording =
        std::make_unique<RecordingWithOdometry>(std::move(recording), readOdometryCsv(options.odometry));
  }
  return {};
}

/// Everything that watches a run and leaves something of it.
class Witnesses {
 public:
  Witnesses(const RunOptions& options, const PipelineParams& params, std::size_t frames)
      : log_(options.out),
        snapshots_path_(options.out + "/pose_cells.csv"),
        snapshots_(options.pose_cells_at.empty() ? SnapshotMoments::evenly(kSnapshots, frames)
                                                 : SnapshotMoments::fromTimes(options.pose_cells_at)) {
    if (!options.video.empty()) {
      video_ = std::make_unique<RunVideo>(options.video, params.profile_odometry.camera_hz);
    }
  }

  void follow(const Pipeline& pipeline, const Pipeline::Progress& progress) {
    log_.append(progress);
    snapshots_.follow(progress, pipeline.poseCells().cells());
    if (video_) video_->follow(progress);
  }
  void show(const Pipeline& pipeline, const cv::Mat& image) {
    if (video_) video_->add(pipeline, image);
  }
  void finish(const Pipeline& pipeline, const PipelineParams& params,
              const std::map<std::string, double>& counts, double decoding_seconds) {
    log_.finish(pipeline, params, counts, decoding_seconds);
    snapshots_.write(snapshots_path_);
  }

 private:
  RunLog log_;
  std::string snapshots_path_;
  PoseCellSnapshots snapshots_;
  std::unique_ptr<RunVideo> video_;
};

int run(const RunOptions& options) {
  const PipelineParams params = PipelineParams::fromMap(readParameters(options));
  std::unique_ptr<Recording> recording = openRecording(options.input, options.recording);
  const auto camera = chooseCamera(options, params, *recording);
  const OdometrySource source = chooseOdometry(options, params, camera, recording);
  Pipeline pipeline(params, source, camera);
  const std::size_t total = options.max_frames == 0 ? recording->imageCount()
                                                    : std::min(options.max_frames, recording->imageCount());
  Witnesses witnesses(options, params, total);
  DecodeAhead items(*recording, options.decode_threads);
  std::size_t frames = 0;
  std::size_t corrupt = 0;
  ProgressBar bar(std::cerr, total, "frames", isatty(STDERR_FILENO) != 0);
  while (interrupted == 0 && (options.max_frames == 0 || frames < options.max_frames)) {
    const auto item = items.next();
    if (!item) break;
    if (const auto* sample = std::get_if<OdometrySample>(&*item)) {
      witnesses.follow(pipeline, pipeline.addOdometry(*sample));
      continue;
    }
    const auto& image = std::get<DecodedImage>(*item);
    ++frames;
    bar.update(frames);
    if (image.image.empty()) {
      if (++corrupt == 1) std::cerr << "ratslam_run: " << image.name << ": " << image.error << "; skipped\n";
      continue;
    }
    witnesses.follow(pipeline, pipeline.addImage(image.stamp, image.image));
    witnesses.show(pipeline, image.image);
  }
  witnesses.finish(
      pipeline, params,
      {{"frames", static_cast<double>(frames)}, {"corrupt_images", static_cast<double>(corrupt)}},
      items.decodingSeconds());
  std::cout << frames << " frames (" << corrupt << " corrupt), " << pipeline.localView().size()
            << " templates, " << pipeline.map().graph().experiences().size() << " experiences, "
            << pipeline.map().graph().links().size() << " links -> " << options.out << '\n';
  if (interrupted != 0) std::cout << "interrupted: the results hold what was mapped so far\n";
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGINT, [](int) { interrupted = 1; });
  try {
    const auto options = parseRunOptions(argc, argv);
    return options ? run(*options) : 0;
  } catch (const std::exception& error) {
    std::cerr << "ratslam_run: " << error.what() << '\n';
    return 1;
  }
}
