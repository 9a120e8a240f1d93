// Drives the pose cells and the map for very long: one loop patrolled, then new streets, then the loop again, with
// odometry that drifts and views that are recalled. Prints memory and time over the frames.
// Usage: soak [FRAMES] > soak.csv     (1,000,000 frames where none are given)
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <random>
#include <string>

#include "ratslam/system/map_stage.h"
#include "ratslam/system/pose_cell_stage.h"

namespace {

using namespace ratslam;

constexpr std::size_t kLoopFrames = 2000;  // 10 frames a second, 1 m a frame
constexpr std::size_t kFramesPerView = 4;  // a new view every so many metres
constexpr double kYawRate =
    2.0 * 3.14159265358979323846 / (0.1 * kLoopFrames);  // [rad/s] once round the loop

double residentMegabytes() {
  std::ifstream file("/proc/self/statm");
  std::size_t pages = 0;
  file >> pages >> pages;
  return static_cast<double>(pages) * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1048576.0;
}

/// Four fifths of the time on the loop, a tenth in new streets, a tenth on the loop again.
bool onLoop(std::size_t frame, std::size_t frames) {
  return frame < frames / 10 * 8 || frame >= frames / 10 * 9;
}

}  // namespace

int main(int argc, char** argv) {
  const std::size_t frames = argc > 1 ? std::strtoul(argv[1], nullptr, 10) : 1'000'000;
  const std::size_t window = std::max<std::size_t>(frames / 100, 1);
  PoseCellParams cells;
  cells.cell_size = 10.0;
  ExperienceMapParams map_params;
  PoseCellStage pose_cells(cells);
  MapStage map(map_params, false);
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0.0, 1.0);
  std::uint32_t learned = 0;
  const std::uint32_t views_of_loop = kLoopFrames / kFramesPerView;
  double worst_ms = 0.0;
  double sum_ms = 0.0;
  std::cout << "frames,experiences,links,graph_nodes,memory_mb,mean_ms,worst_ms\n";
  for (std::size_t frame = 0; frame < frames; ++frame) {
    const bool loop = onLoop(frame, frames);
    OdometrySample sample;
    sample.stamp = static_cast<Stamp>(frame + 1) * 100'000'000;
    sample.speed = 10.0 * (1.0 + 0.02 * noise(random));
    sample.yaw_rate = (loop ? kYawRate : 0.0) + 0.002 * noise(random);
    const auto place = static_cast<std::uint32_t>(frame % kLoopFrames / kFramesPerView);
    ViewEvent view;
    view.stamp = sample.stamp;
    view.learned = loop ? place >= learned : frame % kFramesPerView == 0;
    view.id = loop ? place : (view.learned ? std::max(learned, views_of_loop) : learned - 1);
    if (view.learned) learned = view.id + 1;

    const auto begin = std::chrono::steady_clock::now();
    pose_cells.addOdometry(sample);
    map.addOdometry(sample);
    pose_cells.addView(view);
    for (const PoseCellDecision& decision : pose_cells.drain()) map.addDecision(decision.action);
    map.drain();
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - begin;
    worst_ms = std::max(worst_ms, took.count());
    sum_ms += took.count();
    if ((frame + 1) % window == 0) {
      const ExperienceGraph& graph = map.map().graph();
      std::cout << frame + 1 << ',' << graph.experiences().size() << ',' << graph.links().size() << ','
                << map.map().frames() << ',' << residentMegabytes() << ','
                << sum_ms / static_cast<double>(window) << ',' << worst_ms << std::endl;
      worst_ms = sum_ms = 0.0;
    }
  }
  return 0;
}
