/// Time of the ORB odometry per frame (median, 95 %), and of its stages, on one thread at 1241x376 and
/// 1280x960. Uses kitti_00 below $RATSLAM_DATA (default ../shared/data) if it is there, enlarged and cropped
/// for the larger size, else a rendered street.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <iomanip>
#include <map>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>

#include "ratslam/odometry/orb/orb_odometry.h"
#include "ratslam/vision/triangulation.h"
#include "ratslam/vision/window_adjustment.h"
#include "unit/orb_odometry/street_scene.h"

namespace ratslam {
namespace {

constexpr int kFrames = 150;
constexpr int kStageFrame = 60;  // the frame that stages are measured on

/// KITTI's camera, or one of 1280x960 with the same field of view upwards.
CameraModel cameraOf(bool large) {
  CameraModel camera;
  const double zoom = large ? 960.0 / 376.0 : 1.0;
  camera.width = large ? 1280 : 1241;
  camera.height = large ? 960 : 376;
  camera.fx = camera.fy = zoom * 718.856;
  camera.cx = large ? 639.5 : 607.1928;
  camera.cy = zoom * 185.2157;
  return camera;
}

cv::Mat loadImage(int i) {
  const char* data = std::getenv("RATSLAM_DATA");
  std::ostringstream path;
  path << (data ? data : "../shared/data") << "/kitti_00/image_0/" << std::setfill('0') << std::setw(6) << i
       << ".jpg";
  return cv::imread(path.str(), cv::IMREAD_GRAYSCALE);
}

const std::vector<cv::Mat>& images(bool large) {
  static std::map<bool, std::vector<cv::Mat>> all;
  std::vector<cv::Mat>& made = all[large];
  if (!made.empty()) return made;
  cv::setNumThreads(1);
  const CameraModel camera = cameraOf(large);
  const test::StreetScene street;
  for (int i = 0; i < kFrames; ++i) {
    cv::Mat image = loadImage(i);
    if (image.empty()) {
      image = street.render(camera, test::cameraAt(0.0, 0.8 * i));
    } else if (large) {
      cv::resize(image, image, {}, camera.height / 376.0, camera.height / 376.0, cv::INTER_CUBIC);
      image = image.colRange((image.cols - camera.width) / 2, (image.cols + camera.width) / 2).clone();
    }
    made.push_back(image);
  }
  return made;
}

OrbOdometryParams params(int threads) {
  OrbOdometryParams made;
  made.camera_height = 1.65;
  made.threads = threads;
  return made;
}

double milliseconds(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

/// Thread CPU time on one thread, wall time on more.
void wholeFrames(benchmark::State& state) {
  const bool large = state.range(0) != 0;
  const int threads = static_cast<int>(state.range(1));
  const clockid_t clock = threads == 1 ? CLOCK_THREAD_CPUTIME_ID : CLOCK_MONOTONIC;
  const auto& frames = images(large);
  std::vector<double> times;
  for (auto _ : state) {
    OrbOdometry odometry(cameraOf(large), params(threads));
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const double begin = milliseconds(clock);
      benchmark::DoNotOptimize(odometry.track(stampFromSeconds(0.1 * static_cast<double>(i)), frames[i]));
      times.push_back(milliseconds(clock) - begin);
    }
  }
  std::sort(times.begin(), times.end());
  state.counters["median_ms"] = times[times.size() / 2];
  state.counters["p95_ms"] = times[times.size() * 95 / 100];
}
BENCHMARK(wholeFrames)
    ->ArgNames({"large", "threads"})
    ->ArgsProduct({{0, 1}, {1, 2}})
    ->Unit(benchmark::kMillisecond)
    ->Iterations(1);

void pyramid(benchmark::State& state) {
  const cv::Mat& image = images(state.range(0) != 0)[kStageFrame];
  for (auto _ : state) benchmark::DoNotOptimize(ImagePyramid(image, 8, 1.2));
}

void features(benchmark::State& state) {
  const ExtractorParams extractor_params;
  const FeatureExtractor extractor(extractor_params);
  WorkerPool workers(1);
  const ImagePyramid levels(images(state.range(0) != 0)[kStageFrame], extractor_params.levels,
                            extractor_params.scale_factor);
  cv::Mat descriptors;
  for (auto _ : state) benchmark::DoNotOptimize(extractor.extract(levels, descriptors, workers));
}

/// An odometry that has come to the frame that stages are measured on.
OrbOdometry warmedUp(bool large) {
  OrbOdometry odometry(cameraOf(large), params(1));
  for (int i = 0; i < kStageFrame; ++i) {
    odometry.track(stampFromSeconds(0.1 * i), images(large)[static_cast<std::size_t>(i)]);
  }
  return odometry;
}

std::shared_ptr<Frame> nextFrame(bool large, WorkerPool& workers) {
  const ExtractorParams extractor_params;
  return std::make_shared<Frame>(makeFrame(0, images(large)[kStageFrame], cameraOf(large),
                                           FeatureExtractor(extractor_params), extractor_params, workers));
}

void trackLastFrame(benchmark::State& state) {
  const bool large = state.range(0) != 0;
  WorkerPool workers(1);
  const OrbOdometry odometry = warmedUp(large);
  LocalMap map = *odometry.map();
  const auto frame = nextFrame(large, workers);
  for (auto _ : state) {
    benchmark::DoNotOptimize(trackFrame(cameraOf(large), map, odometry.frame()->observations,
                                        odometry.frame()->T_camera_world, *frame, TrackingParams{}, workers));
  }
}

/// Both halves of what a keyframe costs; the map is put back before each.
template <class Stage>
void measureMapping(benchmark::State& state, Stage&& stage) {
  const bool large = state.range(0) != 0;
  const CameraModel camera = cameraOf(large);
  WorkerPool workers(1);
  const OrbOdometry odometry = warmedUp(large);
  LocalMap before = *odometry.map();
  const auto frame = nextFrame(large, workers);
  trackFrame(camera, before, odometry.frame()->observations, odometry.frame()->T_camera_world, *frame,
             TrackingParams{}, workers);
  before.addKeyframe(frame, camera);
  const auto observations = frame->observations;
  std::vector<RigidTransform> poses;
  for (const Keyframe& keyframe : before.keyframes()) poses.push_back(keyframe.frame->T_camera_world);
  for (auto _ : state) {
    state.PauseTiming();
    LocalMap map = before;
    for (std::size_t i = 0; i < poses.size(); ++i) map.keyframes()[i].frame->T_camera_world = poses[i];
    frame->observations = observations;
    state.ResumeTiming();
    stage(camera, map, workers);
  }
}

void newLandmarks(benchmark::State& state) {
  measureMapping(state, [](const CameraModel& camera, LocalMap& map, WorkerPool& workers) {
    benchmark::DoNotOptimize(addLandmarks(camera, map, TriangulationParams{}, workers));
  });
}

void bundleAdjustment(benchmark::State& state) {
  measureMapping(state, [](const CameraModel& camera, LocalMap& map, WorkerPool&) {
    benchmark::DoNotOptimize(adjustWindow(camera, map, WindowParams{}, RobustLoss{}));
  });
}

BENCHMARK(pyramid)->ArgName("large")->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);
BENCHMARK(features)->ArgName("large")->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);
BENCHMARK(trackLastFrame)->ArgName("large")->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);
BENCHMARK(newLandmarks)->ArgName("large")->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);
BENCHMARK(bundleAdjustment)->ArgName("large")->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ratslam

BENCHMARK_MAIN();
