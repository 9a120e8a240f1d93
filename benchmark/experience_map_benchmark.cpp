/// Speed of the experience map on drives through a city in which about 12% of the links are made by recalls.
///
/// Times are thread CPU time. Each benchmark measures the plain implementation (test/oracle) on the same
/// graph in the same run; `oracle_ms` is its 20 sweeps with the C library's sine and cosine, `ratio` how many
/// times faster an update of the map is on average (`ours_ms`).
#include <benchmark/benchmark.h>

#include <algorithm>
#include <ctime>
#include <utility>

#include "oracle/driven_pose_graph.h"
#include "oracle/experience_map_oracle.h"
#include "ratslam/experience_map/solver/rejoin.h"
#include "ratslam/experience_map/solver/relaxation.h"

namespace ratslam {
namespace {

constexpr int kSweeps = 20;
constexpr double kCorrection = 0.5;

double threadMilliseconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

template <class Work>
double millisecondsOf(Work&& work) {
  const double start = threadMilliseconds();
  work();
  return threadMilliseconds() - start;
}

/// Streets of 40 m, as many as make about every second metre a revisited one.
/// @param recall_share of the revisited places that are recognised.
std::vector<DriveStep> cityDrive(std::uint32_t experiences, double recall_share = 0.34) {
  CityDrive city;
  city.experiences = experiences;
  city.blocks = std::max(2, static_cast<int>(std::sqrt(experiences / 160.0)));
  city.recall_share = recall_share;
  city.length_noise = 0.01;
  city.yaw_noise = 0.0005;
  return simulate(city);
}

double plainSweepsMilliseconds(const ExperienceGraph& graph) {
  OracleRelaxation plain(graph);
  plain.sweep(kSweeps, kCorrection, LibrarySineCosine());
  return millisecondsOf([&] { plain.sweep(kSweeps, kCorrection, LibrarySineCosine()); });
}

/// The reference arithmetic: 20 sweeps over a map of so many experiences.
void sweep(benchmark::State& state, double recall_share) {
  ExperienceMapParams params;
  params.exp_solver = "relaxation";
  params.exp_loops = 0;
  ExperienceMap map(params);
  run(map, cityDrive(static_cast<std::uint32_t>(state.range(0)), recall_share));
  ExperienceGraph graph = map.graph();
  const double plain_ms = plainSweepsMilliseconds(graph);
  Relaxation relaxation(kSweeps, kCorrection);
  RobotPlace robot;
  relaxation.update(graph, robot);
  double total_ms = 0.0;
  for (auto _ : state) total_ms += millisecondsOf([&] { relaxation.update(graph, robot); });
  const double ours_ms = total_ms / static_cast<double>(state.iterations());
  state.counters["oracle_ms"] = plain_ms;
  state.counters["ours_ms"] = ours_ms;
  state.counters["ratio"] = plain_ms / ours_ms;
}

void referenceUpdate(benchmark::State& state) { sweep(state, 0.34); }
/// Before the first loop is closed every link is where it wants to be.
void referenceUpdateAtRest(benchmark::State& state) { sweep(state, 0.0); }

/// The default map on its way through a drive.
struct DrivenMap {
  explicit DrivenMap(std::vector<DriveStep> steps) : drive(std::move(steps)) { map.start(0); }

  void advance() {
    map.integrate(drive[next].end, drive[next].motion);
    map.apply(drive[next].action);
    ++next;
  }

  std::vector<DriveStep> drive;
  ExperienceMap map{ExperienceMapParams{}};
  std::size_t next = 1;
};

/// The default map: updates from the given number of experiences on, recalls among them.
/// `error_ratio` is the graph error after them over what 20 plain sweeps of the weighted graph leave when
/// they start there.
void defaultUpdate(benchmark::State& state) {
  const auto experiences = static_cast<std::uint32_t>(state.range(0));
  DrivenMap driven_map(cityDrive(experiences + 1100));
  while (driven_map.map.graph().experiences().size() < experiences) driven_map.advance();
  std::vector<double> times;
  for (auto _ : state) {
    if (driven_map.next == driven_map.drive.size()) {
      state.SkipWithError("the drive is too short for so many iterations");
      break;
    }
    times.push_back(millisecondsOf([&] { driven_map.advance(); }));
  }
  double mean = 0.0;
  for (const double time : times) mean += time / static_cast<double>(times.size());
  std::sort(times.begin(), times.end());

  // The same drive for the graph errors.
  DrivenPoseGraph driven{ExperienceMapParams{}};
  for (std::size_t k = 1; k < driven_map.next; ++k) {
    driven.take(driven_map.drive[k]);
    driven.solver.resume(driven.graph);
    driven.solver.update(driven.graph, driven.robot);
  }
  const PoseGraph& graph = driven.solver.poseGraph();
  std::vector<MapPose> swept = graph.nodes();
  sweepPlainly(graph, swept, kSweeps, kCorrection);

  const double plain_ms = plainSweepsMilliseconds(driven_map.map.graph());
  double recalls = 0.0;
  for (const Link& link : driven_map.map.graph().links()) recalls += link.recall ? 1.0 : 0.0;
  state.counters["recall_share"] = recalls / static_cast<double>(driven_map.map.graph().links().size());
  state.counters["oracle_ms"] = plain_ms;
  state.counters["ours_ms"] = mean;
  state.counters["median_ms"] = times[times.size() / 2];
  state.counters["max_ms"] = times.back();
  state.counters["ratio"] = plain_ms / mean;
  state.counters["error_ratio"] = graph.energy(graph.nodes()) / graph.energy(swept);
}

/// Growth without closures.
void growth(benchmark::State& state) {
  CityDrive city;
  city.experiences = static_cast<std::uint32_t>(state.range(0)) + 4000;
  city.recall_share = 0.0;
  city.blocks = 20;
  DrivenMap driven(simulate(city));
  while (driven.next < static_cast<std::size_t>(state.range(0))) driven.advance();
  for (auto _ : state) driven.advance();
}

/// A ring of so many experiences whose end lies beside its start by a gap of `gap_m`; the second lap closes
/// it. `max_ms` is the longest update from then on.
void closure(benchmark::State& state) {
  const auto lap = static_cast<int>(state.range(0));
  const auto drive = simulateRing(lap, 2 * lap, 1.0, -0.05);
  ExperienceMapParams params;
  params.exp_rotation_sigma = 0.01;
  for (auto _ : state) {
    ExperienceMap map(params);
    map.start(0);
    double worst = 0.0;
    double gap = 0.0;
    for (int k = 1; k <= lap + 600; ++k) {
      const DriveStep& step = drive[static_cast<std::size_t>(k)];
      const double time = millisecondsOf([&] {
        map.integrate(step.end, step.motion);
        map.apply(step.action);
      });
      if (k > lap) worst = std::max(worst, time);
      const MapPose start = map.graph().pose(0);
      if (k == lap) gap = std::hypot(map.robotPose().x - start.x, map.robotPose().y - start.y);
    }
    state.counters["max_ms"] = worst;
    state.counters["gap_m"] = gap;
  }
}

/// A chain of so many steps of which every second may be off by metres. The recall at its end fits nowhere.
void rejoining(benchmark::State& state) {
  PoseGraph graph(2.0);
  graph.addNode({});
  for (std::uint32_t node = 1; node <= static_cast<std::uint32_t>(state.range(0)); ++node) {
    graph.addNode({static_cast<double>(node), 0.0, 0.0, 0.0, 0.0});
    Constraint step;
    step.from = node - 1;
    step.to = node;
    step.measured = {1.0, 0.0, 0.0, 0.0};
    if (node % 2 == 0) step.xy_weight *= 0.1;
    graph.addConstraint(step);
  }
  Constraint recall;
  recall.to = static_cast<std::uint32_t>(state.range(0));
  recall.measured = {static_cast<double>(state.range(0)), 50.0, 0.0, 0.0};
  recall.recall = true;
  graph.addConstraint(recall);
  const std::vector<MapPose> nodes = graph.nodes();
  for (auto _ : state) {
    benchmark::DoNotOptimize(rejoin(graph, recall));
    state.PauseTiming();
    graph.nodes() = nodes;
    state.ResumeTiming();
  }
}

BENCHMARK(referenceUpdate)->Arg(1000)->Arg(5000)->Arg(20000)->Unit(benchmark::kMillisecond);
BENCHMARK(referenceUpdateAtRest)->Arg(20000)->Unit(benchmark::kMillisecond);
BENCHMARK(defaultUpdate)->Arg(1000)->Arg(5000)->Arg(20000)->Iterations(1000)->Unit(benchmark::kMillisecond);
BENCHMARK(growth)->Arg(1000)->Arg(20000)->Iterations(3000)->Unit(benchmark::kMicrosecond);
BENCHMARK(closure)->Arg(20000)->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK(rejoining)->Arg(20000)->Arg(80000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ratslam

BENCHMARK_MAIN();
