// One frame of recall by belief among very many places: the view's novelty, the belief moved by odometry, the view
// compared with all places at all its shifts, and the belief weighed.
//
// Counters: `frame_ms` is the median time of a frame, `compare_ms` that of the comparison in it; `bytes` the memory
// held for a place.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <ctime>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <random>
#include <vector>

#include "ratslam/local_view/descriptor_registry.h"
#include "ratslam/local_view/recall/place_belief.h"

namespace ratslam {
namespace {

double threadSeconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

double medianMs(std::vector<double> seconds) {
  std::sort(seconds.begin(), seconds.end());
  return seconds.empty() ? 0.0 : 1e3 * seconds[seconds.size() / 2];
}

/// The views of config/kitti_orb.yaml.
LocalViewParams orientationParams() {
  LocalViewParams params;
  params.descriptor = "orientation";
  params.recall.kind = "belief";
  params.view_template.crop_y_min = 60;
  params.view_template.crop_y_max = 300;
  params.view_template.x_size = 60;
  params.view_template.y_size = 10;
  params.shift_match = 5;
  return params;
}

/// A route of so many places, a metre apart, driven once: each looks like a real view with its values mixed anew.
struct Route {
  ViewPair pair;
  PlaceBelief belief;
  std::mt19937 random;
  View pattern;

  explicit Route(int places) : pair(DescriptorRegistry::builtIn().make(orientationParams())) {
    cv::Mat noise(376, 1241, CV_8UC1);
    for (auto it = noise.begin<std::uint8_t>(); it != noise.end<std::uint8_t>(); ++it) {
      *it = static_cast<std::uint8_t>(random() % 256);
    }
    cv::GaussianBlur(noise, noise, cv::Size(), 6.0);
    pattern = pair.descriptor->describe(noise);
    for (int k = 0; k < places; ++k) {
      belief.move(metre(), 1.0);
      belief.arrive(pair.matcher->add(placeView(k)));
    }
  }

  static ViewMotion metre() {
    ViewMotion motion;
    motion.forward = 1.0;
    return motion;
  }

  /// The view of place k, the same whenever it is asked for.
  View placeView(int k) const {
    View view = pattern;
    std::mt19937 own(static_cast<std::uint32_t>(k));
    for (ViewVariant& variant : view.variants) {
      const auto by = static_cast<std::ptrdiff_t>(own() % variant.values.size());
      std::rotate(variant.values.begin(), variant.values.begin() + by, variant.values.end());
    }
    return view;
  }
};

void frameAmongPlaces(benchmark::State& state) {
  const int places = static_cast<int>(state.range(0));
  static std::unique_ptr<Route> route;
  static int made = 0;
  if (made != places) route = std::make_unique<Route>(places);
  made = places;
  std::vector<double> frames;
  std::vector<double> comparisons;
  ViewLikeness likeness;
  int k = places / 3;
  View before = route->placeView(k);
  for (auto _ : state) {
    const View view = route->placeView(++k);
    const double begin = threadSeconds();
    route->belief.move(Route::metre(), route->pair.matcher->novelty(view, before));
    const double compared = threadSeconds();
    route->pair.matcher->compareAll(view, likeness);
    comparisons.push_back(threadSeconds() - compared);
    const auto claim = route->belief.weigh(likeness, route->belief.leftBehind(likeness));
    benchmark::DoNotOptimize(claim);
    if (claim) route->belief.arrive(claim->place);
    frames.push_back(threadSeconds() - begin);
    state.SetIterationTime(frames.back());
    before = view;
  }
  const double bytes = static_cast<double>(route->pair.matcher->memoryBytes() + route->belief.memoryBytes());
  state.counters["frame_ms"] = medianMs(frames);
  state.counters["compare_ms"] = medianMs(comparisons);
  state.counters["bytes"] = bytes / places;
}
BENCHMARK(frameAmongPlaces)
    ->ArgName("places")
    ->Arg(20000)
    ->Arg(1000000)
    ->Iterations(100)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ratslam

BENCHMARK_MAIN();
