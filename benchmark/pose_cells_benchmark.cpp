/// One step of the pose cells (excitation, inhibition, global inhibition, normalisation, path integration,
/// estimate) against the plain implementation, in thread CPU time: one packet of activity, and all cells lit.
/// Counters: `oracle_us`, median time of the plain implementation in the same run; `ratio`, that over ours.
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

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

PoseCellParams paramsOf(int n_xy) {
  PoseCellParams params;
  params.n_xy = n_xy;
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
  state.counters["oracle_us"] = 1e6 * median(oracle);
  state.counters["median_us"] = 1e6 * median(ours);
  state.counters["ratio"] = median(oracle) / median(ours);
}

/// A packet that travels through the network.
void packetStep(benchmark::State& state) {
  constexpr int kSettle = 50;
  constexpr int kBatch = 100;  // steps between two looks at the clock
  const PoseCellParams params = paramsOf(static_cast<int>(state.range(0)));
  oracle::Network plain(params);
  PoseCellNetwork network(params);
  for (int step = 0; step < kSettle; ++step) {
    plain.step(kDistance, kRotation);
    network.step(kDistance, kRotation);
  }
  std::vector<double> oracle;
  for (int step = 0; step < 101; ++step) {
    const double start = threadSeconds();
    plain.step(kDistance, kRotation);
    oracle.push_back(threadSeconds() - start);
  }
  std::vector<double> ours;
  for (auto iteration : state) {
    static_cast<void>(iteration);
    const double start = threadSeconds();
    for (int step = 0; step < kBatch; ++step) network.step(kDistance, kRotation);
    ours.push_back((threadSeconds() - start) / kBatch);
    state.SetIterationTime(ours.back());
  }
  benchmark::DoNotOptimize(network.estimate());
  report(state, oracle, ours);
}

/// Every step starts from activity in all cells. Without global inhibition, which would end most of it in one
/// step.
void allLitStep(benchmark::State& state) {
  PoseCellParams params = paramsOf(static_cast<int>(state.range(0)));
  params.global_inhibition = 0.0;
  const ActivityGrid lit = allLit(params);
  std::vector<double> oracle;
  for (int step = 0; step < 7; ++step) {
    oracle::Network plain(params);
    std::copy_n(lit.data(), plain.cells().size(), plain.cells().begin());
    const double start = threadSeconds();
    plain.step(kDistance, kRotation);
    oracle.push_back(threadSeconds() - start);
  }
  std::vector<double> ours;
  PoseCellNetwork network(params);
  for (auto iteration : state) {
    static_cast<void>(iteration);
    network.setActivity(lit);
    const double start = threadSeconds();
    network.step(kDistance, kRotation);
    ours.push_back(threadSeconds() - start);
    state.SetIterationTime(ours.back());
  }
  benchmark::DoNotOptimize(network.estimate());
  report(state, oracle, ours);
}

BENCHMARK(packetStep)->Arg(30)->Arg(61)->ArgName("n_xy")->UseManualTime()->Unit(benchmark::kMicrosecond);
BENCHMARK(allLitStep)->Arg(30)->Arg(61)->ArgName("n_xy")->UseManualTime()->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace ratslam

BENCHMARK_MAIN();
