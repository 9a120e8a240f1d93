// A map file of many places: taking it from the stages, which holds a frame up, writing it, and loading it.
//
// The places lie along one way, 2 m apart, each with a view, an experience and the links between them.
#include <benchmark/benchmark.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <opencv2/core.hpp>
#include <random>

#include "ratslam/common/state.h"
#include "ratslam/local_view/local_view_cells.h"
#include "ratslam/system/map_stage.h"
#include "ratslam/system/map_store.h"
#include "ratslam/system/pose_cell_stage.h"

namespace ratslam {
namespace {

constexpr Stamp kTenth = 100'000'000;
constexpr std::array<const char*, 3> kParts{"local_view", "pose_cells", "experience_map"};

struct Stages {
  LocalViewCells views{viewParams()};
  PoseCellStage pose_cells{cellParams()};
  MapStage map{ExperienceMapParams{}, GeometrySource::kNone};

  static LocalViewParams viewParams() {
    LocalViewParams params;
    params.view_template.x_size = 60;
    params.view_template.y_size = 10;
    params.match_threshold = 0.01;
    return params;
  }
  static PoseCellParams cellParams() {
    PoseCellParams params;
    params.cell_size = 2.0;
    return params;
  }

  void drive(std::uint32_t places) {
    std::mt19937 random(1);
    cv::Mat image(10, 60, CV_8UC1);
    for (std::uint32_t place = 0; place < places; ++place) {
      for (auto it = image.begin<std::uint8_t>(); it != image.end<std::uint8_t>(); ++it)
        *it = static_cast<std::uint8_t>(random());
      OdometrySample sample;
      sample.stamp = static_cast<Stamp>(place + 1) * kTenth;
      sample.speed = 20.0;
      pose_cells.addOdometry(sample);
      map.addOdometry(sample);
      pose_cells.addView(views.observe(sample.stamp, image));
      for (const PoseCellDecision& decision : pose_cells.drain()) map.addDecision(decision.action);
      map.drain();
    }
  }
  void save(const std::string& part, State& state) const {
    if (part == "local_view") views.save(state);
    if (part == "pose_cells") pose_cells.save(state);
    if (part == "experience_map") map.save(state);
  }
  MapCheckpoint checkpoint() const {
    MapCheckpoint taken;
    taken.stamp = kTenth;
    for (const char* part : kParts) save(part, taken.state.child(part));
    return taken;
  }
  void load(const MapCheckpoint& saved) {
    views.load(saved.state.children().at("local_view"));
    pose_cells.load(saved.state.children().at("pose_cells"));
    map.load(saved.state.children().at("experience_map"));
  }
};

const Stages& driven(std::uint32_t places) {
  static std::map<std::uint32_t, std::unique_ptr<Stages>> all;
  std::unique_ptr<Stages>& stages = all[places];
  if (!stages) {
    stages = std::make_unique<Stages>();
    stages->drive(places);
  }
  return *stages;
}

class MapFile {
 public:
  MapFile()
      : path_(std::filesystem::temp_directory_path() / ("map_file." + std::to_string(getpid()) + ".db")) {
    remove();
  }
  ~MapFile() { remove(); }
  MapFile(const MapFile&) = delete;
  MapFile& operator=(const MapFile&) = delete;
  std::string path() const { return path_.string(); }
  void remove() const {
    for (const char* ending : {"", "-wal", "-shm", "-journal"}) std::filesystem::remove(path() + ending);
  }

 private:
  std::filesystem::path path_;
};

/// What a node does while its messages wait; the rest is for the thread that writes.
void takePart(benchmark::State& state) {
  const Stages& stages = driven(static_cast<std::uint32_t>(state.range(0)));
  const std::string part = kParts.at(static_cast<std::size_t>(state.range(1)));
  for (auto _ : state) {
    auto taken = std::make_unique<State>();
    stages.save(part, *taken);
    state.PauseTiming();
    taken.reset();
    state.ResumeTiming();
  }
  state.SetLabel(part);
  state.counters["experiences"] = static_cast<double>(stages.map.map().graph().experiences().size());
}

void writeMap(benchmark::State& state) {
  const MapCheckpoint taken = driven(static_cast<std::uint32_t>(state.range(0))).checkpoint();
  const MapFile file;
  for (auto _ : state) {
    state.PauseTiming();
    file.remove();
    state.ResumeTiming();
    MapWriter(file.path()).save(taken);
  }
  state.counters["bytes"] = static_cast<double>(std::filesystem::file_size(file.path()));
}

void loadMap(benchmark::State& state) {
  const MapFile file;
  MapWriter(file.path()).save(driven(static_cast<std::uint32_t>(state.range(0))).checkpoint());
  for (auto _ : state) {
    Stages stages;
    stages.load(loadMapFile(file.path()));
    benchmark::DoNotOptimize(stages.views.size());
  }
}

BENCHMARK(takePart)
    ->ArgNames({"places", "part"})
    ->ArgsProduct({{1000, 20000}, {0, 1, 2}})
    ->Unit(benchmark::kMillisecond);
BENCHMARK(writeMap)->Arg(1000)->Arg(20000)->Unit(benchmark::kMillisecond);
BENCHMARK(loadMap)->Arg(1000)->Arg(20000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ratslam

BENCHMARK_MAIN();
