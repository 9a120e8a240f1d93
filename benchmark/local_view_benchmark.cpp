// The search for a view among learned templates, beside the plain exhaustive one, and what surrounds it.
//
// Counters: `ours_ms` is the median time of a search, `oracle_ms` that of the exhaustive one on the same data
// in the same run, `ratio` theirs; `bytes` the memory held for one template.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <vector>

#include "oracle/local_view_oracle.h"
#include "ratslam/local_view/block_sad/template_matcher.h"
#include "ratslam/local_view/block_sad/view_template.h"

namespace ratslam {
namespace {

constexpr int kColumns = 60;
constexpr int kRows = 10;
constexpr std::size_t kSearches = 5;  // different views a measurement

double threadSeconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// 60 x 10 templates, 11 shifts.
LocalViewParams searchParams() {
  LocalViewParams params;
  params.view_template.x_size = kColumns;
  params.view_template.y_size = kRows;
  params.match_threshold = 0.085;
  params.shift_match = 5;
  params.step_match = 1;
  return params;
}

cv::Mat randomImage(std::mt19937& random) {
  std::uniform_int_distribution<int> value(0, 255);
  cv::Mat image(kRows, kColumns, CV_8UC1);
  for (auto it = image.begin<std::uint8_t>(); it != image.end<std::uint8_t>(); ++it) {
    *it = static_cast<std::uint8_t>(value(random));
  }
  return image;
}

/// The same place seen again: some sensor noise.
cv::Mat seenAgain(std::mt19937& random, const cv::Mat& image) {
  std::normal_distribution<double> noise(0.0, 4.0);
  cv::Mat again = image.clone();
  for (auto it = again.begin<std::uint8_t>(); it != again.end<std::uint8_t>(); ++it) {
    *it = cv::saturate_cast<std::uint8_t>(*it + noise(random));
  }
  return again;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values.empty() ? 0.0 : values[values.size() / 2];
}

/// Searches for the views in turn, one an iteration. @return median time of a search [s].
double measureSearch(benchmark::State& state, TemplateMatcher& search,
                     const std::vector<ViewTemplate>& views) {
  std::vector<double> seconds;
  for (auto _ : state) {
    const double begin = threadSeconds();
    benchmark::DoNotOptimize(search.findBest(views[seconds.size() % views.size()]));
    seconds.push_back(threadSeconds() - begin);
    state.SetIterationTime(seconds.back());
  }
  const double templates = static_cast<double>(search.size());
  state.counters["ours_ms"] = 1e3 * median(seconds);
  state.counters["bytes"] = static_cast<double>(search.memoryBytes()) / templates;
  return median(seconds);
}

void randomTemplates(benchmark::State& state, bool revisited) {
  const LocalViewParams params = searchParams();
  std::mt19937 random(1);
  std::vector<cv::Mat> images;
  oracle::Matcher exhaustive(params);
  TemplateMatcher search(params);
  for (int i = 0; i < state.range(0); ++i) {
    images.push_back(randomImage(random));
    exhaustive.add(oracle::makeTemplate(images.back(), params.view_template));
    search.add(makeViewTemplate(images.back(), params.view_template));
  }
  std::vector<ViewTemplate> views;
  std::vector<double> oracle_seconds;
  for (std::size_t i = 0; i < kSearches; ++i) {
    const cv::Mat& place = images[images.size() * (2 * i + 1) / (2 * kSearches)];
    const cv::Mat view = revisited ? seenAgain(random, place) : randomImage(random);
    views.push_back(makeViewTemplate(view, params.view_template));
    const double begin = threadSeconds();
    benchmark::DoNotOptimize(exhaustive.best(views.back().values));
    oracle_seconds.push_back(threadSeconds() - begin);
  }
  const double seconds = measureSearch(state, search, views);
  state.counters["oracle_ms"] = 1e3 * median(oracle_seconds);
  state.counters["ratio"] = median(oracle_seconds) / seconds;
}

void newViewAmongRandomTemplates(benchmark::State& state) { randomTemplates(state, false); }
void revisitedViewAmongRandomTemplates(benchmark::State& state) { randomTemplates(state, true); }
BENCHMARK(newViewAmongRandomTemplates)->Arg(1000)->Arg(5000)->Arg(20000)->UseManualTime();
BENCHMARK(revisitedViewAmongRandomTemplates)->Arg(1000)->Arg(5000)->Arg(20000)->UseManualTime();

std::filesystem::path dataFolder() {
  const char* configured = std::getenv("RATSLAM_DATA");
  return configured != nullptr ? configured : "../shared/data";
}

/// Up to `count` images of a folder in the order of their names, evenly spread, reduced to 120 x 20 pixels.
void appendImages(const std::filesystem::path& folder, std::size_t count, const cv::Range& band,
                  std::vector<cv::Mat>& images) {
  if (!std::filesystem::is_directory(folder)) return;
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  for (std::size_t i = 0; i < std::min(count, files.size()); ++i) {
    const cv::Mat image = cv::imread(files[i * files.size() / count].string(), cv::IMREAD_GRAYSCALE);
    cv::Mat reduced;
    cv::resize(band == cv::Range::all() ? image : image.rowRange(band), reduced, {2 * kColumns, 2 * kRows}, 0,
               0, cv::INTER_AREA);
    images.push_back(reduced);
  }
}

/// Real places where the data are present; otherwise fields whose power falls with frequency as that of
/// photographs.
std::vector<cv::Mat> realisticPlaces() {
  std::vector<cv::Mat> images;
  appendImages(dataFolder() / "kitti_00/image_0", 800, cv::Range(60, 300), images);
  appendImages(dataFolder() / "nordland/summer", 800, cv::Range::all(), images);
  appendImages(dataFolder() / "nordland/winter", 800, cv::Range::all(), images);
  if (!images.empty()) return images;
  std::mt19937 random(6);
  std::normal_distribution<float> normal(0.0F, 1.0F);
  for (int i = 0; i < 2400; ++i) {
    cv::Mat field(2 * kRows, 2 * kColumns, CV_32FC1, cv::Scalar(128));
    for (int cells = 1; cells <= kRows; cells *= 2) {
      cv::Mat octave(cells + 1, 6 * cells, CV_32FC1);
      for (auto it = octave.begin<float>(); it != octave.end<float>(); ++it) *it = normal(random);
      cv::resize(octave, octave, field.size(), 0, 0, cv::INTER_CUBIC);
      field += octave * (60.0 / cells);
    }
    images.emplace_back();
    field.convertTo(images.back(), CV_8UC1);
  }
  return images;
}

/// Very many places, each two real ones mixed, the second turned round, under other light and with noise.
class PlaceMixer {
 public:
  PlaceMixer() : places_(realisticPlaces()) {
    for (int i = 0; i < 64; ++i)
      noise_.push_back(seenAgain(random_, cv::Mat(places_[0].size(), CV_8UC1, cv::Scalar(50))));
  }

  cv::Mat next() {
    const double share = 0.5 + 0.5 * unit_(random_);
    const cv::Mat& second = pick(places_);
    cv::Mat mixed;
    cv::repeat(second, 1, 2, mixed);
    const int turn = static_cast<int>(unit_(random_) * (second.cols - 1));
    cv::addWeighted(pick(places_), share, mixed.colRange(turn, turn + second.cols), 1.0 - share,
                    20.0 * (unit_(random_) - 0.5) - 50.0, mixed);
    return again(mixed);
  }

  /// The same place with other noise; `place` is 50 grey levels darker than the result.
  cv::Mat again(const cv::Mat& place) { return place + pick(noise_); }

 private:
  const cv::Mat& pick(const std::vector<cv::Mat>& images) {
    return images[std::uniform_int_distribution<std::size_t>(0, images.size() - 1)(random_)];
  }

  std::mt19937 random_{3};
  std::uniform_real_distribution<double> unit_{0.0, 1.0};
  std::vector<cv::Mat> places_;
  std::vector<cv::Mat> noise_;
};

/// A million templates are made once for all that search them.
struct Million {
  LocalViewParams params = searchParams();
  TemplateMatcher search;
  std::vector<ViewTemplate> new_views;
  std::vector<ViewTemplate> revisited_views;

  Million() : search((params.view_template.normalisation = 0.4, params)) {
    PlaceMixer mixer;
    constexpr int kCount = 1000000;
    for (int i = 0; i < kCount; ++i) {
      const cv::Mat place = mixer.next();
      search.add(makeViewTemplate(place, params.view_template));
      if (i % (kCount / 10) == kCount / 20) {
        revisited_views.push_back(
            makeViewTemplate(mixer.again(place - cv::Scalar(50)), params.view_template));
        new_views.push_back(makeViewTemplate(mixer.next(), params.view_template));
      }
    }
  }
};

void millionRealisticTemplates(benchmark::State& state) {
  static Million million;
  measureSearch(state, million.search, state.range(0) == 0 ? million.new_views : million.revisited_views);
}
BENCHMARK(millionRealisticTemplates)
    ->ArgName("revisited")
    ->Arg(0)
    ->Arg(1)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

cv::Mat cameraImage() {
  cv::Mat image(376, 1241, CV_8UC1);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x)
      image.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(x * 7 + y * y);
  }
  return image;
}

void templateFromCameraImage(benchmark::State& state) {
  TemplateParams params = searchParams().view_template;
  params.crop_y_min = 60;
  params.crop_y_max = 300;
  params.normalisation = 0.4;
  const cv::Mat image = cameraImage();
  for (auto _ : state) benchmark::DoNotOptimize(makeViewTemplate(image, params));
}
BENCHMARK(templateFromCameraImage);

void addTemplate(benchmark::State& state) {
  const LocalViewParams params = searchParams();
  const ViewTemplate learned = makeViewTemplate(cameraImage(), params.view_template);
  TemplateMatcher search(params);
  for (auto _ : state) search.add(learned);
  state.counters["bytes"] = static_cast<double>(search.memoryBytes()) / static_cast<double>(search.size());
}
BENCHMARK(addTemplate)->Iterations(20000);

}  // namespace
}  // namespace ratslam

BENCHMARK_MAIN();
