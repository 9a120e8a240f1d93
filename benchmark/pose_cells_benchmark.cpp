/// One step of the pose cells (excitation, inhibition, global inhibition, normalisation, path integration,
/// estimate) against the plain implementation, in thread CPU time: one packet of activity, and all cells lit.
/// Both are measured in turn. Counters: `oracle_ms` and `ours_ms`, the median times; `ratio`, of the
/// medians; `ratio_of_best`, of the shortest times, which other programs on the machine disturb least.
#include <benchmark/benchmark.h>
#include <time.h>

#include <algorithm>
#include <random>
#include <vector>

#include "oracle/pose_cells_oracle.h"
#include "ratslam/pose_cells/network.h"

namespace ratslam {
namespace {

constexpr double kDistance = 0.43;   // m, of cells of 1 m: a car at 8.6 m/s, 20 Hz
constexpr double kRotation = 0.004;  // rad

double threadSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Seconds a call takes, in thread CPU time.
template <class Call>
double timed(Call call) {
  const double start = threadSeconds();
  call();
  return threadSeconds() - start;
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

PoseCellParams paramsOf(const benchmark::State& state) {
  PoseCellParams params;
  params.n_xy = static_cast<int>(state.range(0));
  return params;
}

ActivityGrid allLit(const PoseCellParams& params) {
  ActivityGrid grid(params.n_xy, params.n_th);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> activity(0.1, 1.0);
  grid.cover({Box{Span{0, params.n_xy}, Span{0, params.n_xy}, Span{0, params.n_th}}});
  for (std::size_t c = 0; c < grid.offset(params.n_th, 0); ++c) grid.data()[c] = activity(random);
  return grid;
}

void report(benchmark::State& state, const std::vector<double>& oracle, const std::vector<double>& ours) {
  const double best_oracle = *std::min_element(oracle.begin(), oracle.end());
  const double best = *std::min_element(ours.begin(), ours.end());
  state.counters["oracle_ms"] = 1e3 * median(oracle);
  state.counters["ours_ms"] = 1e3 * median(ours);
  state.counters["ratio"] = median(oracle) / median(ours);
  state.counters["ratio_of_best"] = best_oracle / best;
}

/// A packet that travels through the network.
void packetStep(benchmark::State& state) {
  constexpr int kBatch = 50;  // steps between two looks at the clock
  const PoseCellParams params = paramsOf(state);
  oracle::Network plain(params);
  PoseCellNetwork network(params);
  for (int step = 0; step < kBatch; ++step) {  // until the packet has its lasting shape
    plain.step(kDistance, kRotation);
    network.step(kDistance, kRotation);
  }
  std::vector<double> oracle;
  std::vector<double> ours;
  for (auto iteration : state) {
    static_cast<void>(iteration);
    oracle.push_back(timed([&] { plain.step(kDistance, kRotation); }));
    ours.push_back(timed([&] {
                     for (int step = 0; step < kBatch; ++step) network.step(kDistance, kRotation);
                   }) /
                   kBatch);
    state.SetIterationTime(ours.back());
  }
  report(state, oracle, ours);
}

/// Every step starts from activity in all cells. Without global inhibition, which would end most of it in one
/// step.
void allLitStep(benchmark::State& state) {
  PoseCellParams params = paramsOf(state);
  params.global_inhibition = 0.0;
  const ActivityGrid lit = allLit(params);
  oracle::Network plain(params);
  PoseCellNetwork network(params);
  std::vector<double> oracle;
  std::vector<double> ours;
  for (auto iteration : state) {
    static_cast<void>(iteration);
    std::copy_n(lit.data(), plain.cells().size(), plain.cells().begin());
    oracle.push_back(timed([&] { plain.step(kDistance, kRotation); }));
    double seconds = 0.0;
    for (int repetition = 0; repetition < 5; ++repetition) {
      network.setActivity(lit);
      ours.push_back(timed([&] { network.step(kDistance, kRotation); }));
      seconds += ours.back() / 5;
    }
    state.SetIterationTime(seconds);
  }
  report(state, oracle, ours);
}

void eachSize(benchmark::internal::Benchmark* of) {
  of->Arg(30)->Arg(61)->ArgName("n_xy")->UseManualTime()->Unit(benchmark::kMicrosecond);
}
BENCHMARK(packetStep)->Apply(eachSize)->Iterations(300);
BENCHMARK(allLitStep)->Apply(eachSize)->Iterations(15);

}  // namespace
}  // namespace ratslam

BENCHMARK_MAIN();
