/// Time of the ORB odometry per frame (median, 95 %), and of its stages, on one thread at 1241x376.
/// Uses kitti_00 below $RATSLAM_DATA (default ../shared/data) if it is there, else a rendered street.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <iomanip>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "ratslam/orb_odometry/orb_odometry.h"
#include "unit/orb_odometry/street_scene.h"

namespace ratslam {
namespace {

constexpr int kFrames = 150;

CameraModel kittiCamera() {
  CameraModel camera;
  camera.width = 1241;
  camera.height = 376;
  camera.fx = camera.fy = 718.856;
  camera.cx = 607.1928;
  camera.cy = 185.2157;
  return camera;
}

const std::vector<cv::Mat>& images() {
  static const std::vector<cv::Mat> all = [] {
    cv::setNumThreads(1);
    const char* data = std::getenv("RATSLAM_DATA");
    const test::StreetScene street;
    std::vector<cv::Mat> made;
    for (int i = 0; i < kFrames; ++i) {
      std::ostringstream path;
      path << (data ? data : "../shared/data") << "/kitti_00/image_0/" << std::setfill('0') << std::setw(6)
           << i << ".jpg";
      cv::Mat image = cv::imread(path.str(), cv::IMREAD_GRAYSCALE);
      if (image.empty()) image = street.render(kittiCamera(), test::cameraAt(0.0, 0.8 * i));
      made.push_back(image);
    }
    return made;
  }();
  return all;
}

double threadMilliseconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

void wholeFrames(benchmark::State& state) {
  OrbOdometryParams params;
  params.camera_height = 1.65;
  std::vector<double> milliseconds;
  for (auto _ : state) {
    OrbOdometry odometry(kittiCamera(), params);
    for (std::size_t i = 0; i < images().size(); ++i) {
      const double begin = threadMilliseconds();
      benchmark::DoNotOptimize(odometry.track(stampFromSeconds(0.1 * static_cast<double>(i)), images()[i]));
      milliseconds.push_back(threadMilliseconds() - begin);
    }
  }
  std::sort(milliseconds.begin(), milliseconds.end());
  state.counters["median_ms"] = milliseconds[milliseconds.size() / 2];
  state.counters["p95_ms"] = milliseconds[milliseconds.size() * 95 / 100];
}
BENCHMARK(wholeFrames)->Unit(benchmark::kMillisecond)->Iterations(1);

void pyramid(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(ImagePyramid(images()[100], 8, 1.2));
}
BENCHMARK(pyramid)->Unit(benchmark::kMillisecond);

void features(benchmark::State& state) {
  const ExtractorParams params;
  const FeatureExtractor extractor(params);
  const ImagePyramid levels(images()[100], params.levels, params.scale_factor);
  cv::Mat descriptors;
  for (auto _ : state) benchmark::DoNotOptimize(extractor.extract(levels, descriptors));
}
BENCHMARK(features)->Unit(benchmark::kMillisecond);

/// Against a map of the frames before: what tracking costs without features and without mapping.
void trackLastFrame(benchmark::State& state) {
  OrbOdometryParams params;
  OrbOdometry odometry(kittiCamera(), params);
  for (std::size_t i = 0; i < 60; ++i) {
    odometry.track(stampFromSeconds(0.1 * static_cast<double>(i)), images()[i]);
  }
  if (!odometry.map()) {
    state.SkipWithError("no map after 60 frames");
    return;
  }
  LocalMap map = *odometry.map();
  const ExtractorParams extractor_params;
  Frame frame =
      makeFrame(0, images()[60], kittiCamera(), FeatureExtractor(extractor_params), extractor_params);
  for (auto _ : state) {
    benchmark::DoNotOptimize(trackFrame(kittiCamera(), map, odometry.frame()->observations,
                                        odometry.frame()->T_camera_world, frame, TrackingParams{}));
  }
}
BENCHMARK(trackLastFrame)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ratslam

BENCHMARK_MAIN();
