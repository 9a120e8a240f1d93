/// What publishing a large map holds the map node up for: making each message and serialising it, as roscpp
/// does in the caller's thread, and drawing the picture. Thread CPU time; the drive is that of
/// experience_map_benchmark.cpp.
#include <benchmark/benchmark.h>
#include <ros/serialization.h>

#include "oracle/experience_map_drive.h"
#include "ratslam/view/composite.h"
#include "ratslam/view/draw_map.h"
#include "ratslam_ros/support/map_messages.h"

namespace ratslam {
namespace {

/// A city's places where they truly are, about 12% of the links by recall.
const ExperienceGraph& cityOf(std::uint32_t experiences) {
  static std::map<std::uint32_t, ExperienceGraph> made;
  const auto [entry, is_new] = made.emplace(experiences, ExperienceGraph{});
  ExperienceGraph& graph = entry->second;
  if (!is_new) return graph;
  CityDrive city;
  city.experiences = experiences;
  city.blocks = static_cast<int>(std::sqrt(experiences / 160.0));
  city.recall_share = 0.34;
  for (const DriveStep& step : simulate(city)) {
    const bool created = step.action.kind == ActionKind::kCreateNode;
    if (created) graph.addExperience({step.truth.x, step.truth.y, 0.0, step.truth.th, 0.0});
    if (step.action.kind == ActionKind::kNone || step.action.dest_id == step.action.src_id) continue;
    Link link;
    link.from = step.action.src_id;
    link.to = step.action.dest_id;
    link.distance = step.motion.forward;
    link.duration_s = step.motion.dt;
    link.recall = !created;
    graph.addLink(link);
  }
  return graph;
}

template <class MakeMessage>
void publish(benchmark::State& state, MakeMessage&& make) {
  const ExperienceGraph& graph = cityOf(static_cast<std::uint32_t>(state.range(0)));
  std::size_t bytes = 0;
  for (auto _ : state) bytes = ros::serialization::serializeMessage(make(graph)).num_bytes;
  state.counters["megabytes"] = 1e-6 * static_cast<double>(bytes);
}

void mapMessage(benchmark::State& state) {
  publish(state, [](const ExperienceGraph& graph) { return mapToMessage(graph, std_msgs::Header{}); });
}

void markerMessage(benchmark::State& state) {
  publish(state,
          [](const ExperienceGraph& graph) { return markerToMessage(graph, std_msgs::Header{}, 0.2); });
}

void mapPicture(benchmark::State& state) {
  const ExperienceGraph& graph = cityOf(static_cast<std::uint32_t>(state.range(0)));
  for (auto _ : state) {
    benchmark::DoNotOptimize(drawMap(graph, graph.experiences().back().pose, mapPictureSize()));
  }
}

BENCHMARK(mapMessage)->Arg(1000)->Arg(100000)->Unit(benchmark::kMillisecond);
BENCHMARK(markerMessage)->Arg(1000)->Arg(100000)->Unit(benchmark::kMillisecond);
BENCHMARK(mapPicture)->Arg(1000)->Arg(100000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ratslam

BENCHMARK_MAIN();
