// Drives the pose cells and the map for very long, with odometry that drifts and views that are recalled. Prints memory
// and processor time over the frames. The path as the map has it in the end goes to FOLDER/final.tum, the true one to
// FOLDER/truth.tum.
// Usage: soak [FRAMES [streets|patrol|phases|network|day [EXP_DENSITY [FOLDER]]]] > soak.csv
//   streets  (1,000,000 frames) one loop of 2 km for eight tenths of them, then new streets, then the loop again
//   patrol   (500,000 frames) one loop of 500 m, a row a lap
//   phases   (500,000 frames) the same, 0.37 m longer, so that the frames of a lap lie between those of other laps, and with
//            cells of 4 m; a view reaches from 2 to 6 m
//   network  (10,000,000 frames: a month at four a second) a grid of 24 streets, turned into at random at each crossing
//   day      (8,640,000 frames: 24 hours of odometry at 100 Hz, a view with each tenth) one loop of 2 km for an hour at a time,
//            each followed by five hours at one place; from the 12th to the 18th hour the camera is silent
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "ratslam/dataset/trajectory_io.h"
#include "ratslam/system/map_stage.h"
#include "ratslam/system/pose_cell_stage.h"

namespace {

using namespace ratslam;

constexpr double kPi2 = 2.0 * 3.14159265358979323846;
constexpr double kSpeed = 10.0;            // [m/s]
constexpr Stamp kTenth = 100'000'000;      // between frames: 1 m. During a day they are shorter
constexpr std::size_t kFramesPerView = 4;  // a new view every so many metres

double residentMegabytes() {
  std::ifstream file("/proc/self/statm");
  std::size_t pages = 0;
  file >> pages >> pages;
  return static_cast<double>(pages) * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1048576.0;
}

/// Of this thread, so that other programs do not count.
double processorMilliseconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

/// Where the next frame lies: what turns the robot on the way to it, and a number of what is seen there.
struct Step {
  double yaw_rate = 0.0;  ///< [rad/s]
  std::uint64_t place = 0;
  double speed = kSpeed;  ///< [m/s]
  bool seen = true;       ///< whether there is an image
};

class Road {
 public:
  virtual ~Road() = default;
  virtual Step next() = 0;
  virtual Stamp period() const { return kTenth; }
};

class Loop : public Road {
 public:
  /// @param reaches  how far views reach along the loop, again and again [m]
  explicit Loop(double length, std::vector<double> reaches = {kFramesPerView}) : length_(length) {
    for (double end = 0.0; end < length; ends_.push_back(end)) end += reaches[ends_.size() % reaches.size()];
  }
  Step next() override {
    const double at = std::fmod(static_cast<double>(frame_++), length_);
    const auto place = std::upper_bound(ends_.begin(), ends_.end(), at) - ends_.begin();
    return {kPi2 * kSpeed / length_, static_cast<std::uint64_t>(place)};
  }

 private:
  double length_;  ///< [m], one a frame
  std::vector<double> ends_;
  std::size_t frame_ = 0;
};

/// Views reach from 2 to 6 m. If all reached equally far, all would get their next experience in the same lap.
std::vector<double> variedReaches() {
  std::mt19937 random(11);
  std::vector<double> reaches(125);
  for (double& reach : reaches) reach = 2.0 + 4.0 * static_cast<double>(random()) / 4294967296.0;
  return reaches;
}

/// The loop, then a straight road that nobody has seen, then the loop again.
class LoopAndStreets : public Road {
 public:
  explicit LoopAndStreets(std::size_t frames) : frames_(frames) {}
  Step next() override {
    const std::size_t frame = frame_++;
    if (frame < frames_ / 10 * 8 || frame >= frames_ / 10 * 9) return loop_.next();
    return {0.0, kNew + frame / kFramesPerView};
  }

 private:
  static constexpr std::uint64_t kNew = 1'000'000;
  std::size_t frames_;
  std::size_t frame_ = 0;
  Loop loop_{2000};
};

/// Crossings 100 m apart, 4 x 4 of them, in arcs of 10 m where the robot turns.
class Network : public Road {
 public:
  Step next() override {
    if (at_ == kStreet + kCrossing) enterStreet();
    const bool turns = at_ >= kStreet && turn_ != 0;
    const Step step{turns ? turn_ * kPi2 / 4.0 / (0.1 * kCrossing) : 0.0, place()};
    if (++at_ == kStreet) chooseTurn();
    return step;
  }

 private:
  static constexpr int kSide = 4;
  static constexpr int kStreet = 88;  // frames between crossings, and through one
  static constexpr int kCrossing = 10;

  static int dx(int direction) { return direction == 0 ? 1 : direction == 2 ? -1 : 0; }
  static int dy(int direction) { return direction == 1 ? 1 : direction == 3 ? -1 : 0; }
  bool leadsOn(int direction) const {
    const int x = x_ + dx(direction);
    const int y = y_ + dy(direction);
    return x >= 0 && y >= 0 && x < kSide && y < kSide;
  }
  /// The street that ends at crossing (x_, y_), or the way through that crossing.
  std::uint64_t place() const {
    const std::uint64_t crossing =
        static_cast<std::uint64_t>((x_ * kSide + y_) * 4 + direction_) * 3 + static_cast<unsigned>(turn_ + 1);
    const auto part = static_cast<std::uint64_t>(at_) / kFramesPerView;
    return at_ < kStreet ? (crossing - static_cast<unsigned>(turn_ + 1)) * 100 + part
                         : crossing * 100 + 50 + part;
  }
  void chooseTurn() {
    do {
      turn_ = std::uniform_int_distribution<int>(-1, 1)(random_);
    } while (!leadsOn((direction_ + turn_ + 4) % 4));
  }
  void enterStreet() {
    direction_ = (direction_ + turn_ + 4) % 4;
    x_ += dx(direction_);
    y_ += dy(direction_);
    at_ = 0;
    turn_ = 0;
  }

  std::mt19937 random_{7};
  int x_ = 1;
  int y_ = 0;
  int direction_ = 0;
  int turn_ = 0;
  int at_ = 0;
};

/// Most of the day the robot stands, and at times it sees nothing.
class Day : public Road {
 public:
  Step next() override {
    const std::size_t frame = frame_++;
    const std::size_t hour = frame / kHour;
    const bool stands = hour % 6 != 0;
    if (!stands && frame % kFramesPerMetre == 0) here_ = loop_.next();
    Step step = here_;
    if (stands) step.speed = step.yaw_rate = 0.0;
    step.seen = frame % kFramesPerMetre == 0 && (hour < 12 || hour >= 18);
    return step;
  }
  Stamp period() const override { return kTenth / kFramesPerMetre; }

 private:
  static constexpr std::size_t kHour = 360'000;  // frames
  static constexpr std::size_t kFramesPerMetre = 10;
  std::size_t frame_ = 0;
  Step here_;
  Loop loop_{2000};
};

std::vector<StampedPose3> inSpace(const std::vector<StampedPose>& path) {
  std::vector<StampedPose3> poses;
  for (const StampedPose& at : path) {
    poses.push_back({at.stamp, Eigen::Translation3d(at.pose.x, at.pose.y, at.pose.z) * at.attitude()});
  }
  return poses;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string kind = argc > 2 ? argv[2] : "streets";
  const std::size_t usual = kind == "patrol" || kind == "phases" ? 500'000
                            : kind == "network"                  ? 10'000'000
                            : kind == "day"                      ? 8'640'000
                                                                 : 1'000'000;
  const std::size_t frames = argc > 1 ? std::strtoul(argv[1], nullptr, 10) : usual;
  std::size_t window = std::max<std::size_t>(frames / 100, 1);
  std::unique_ptr<Road> road;
  if (kind == "streets") road = std::make_unique<LoopAndStreets>(frames);
  if (kind == "network") road = std::make_unique<Network>();
  if (kind == "day") road = std::make_unique<Day>();
  if (kind == "patrol" || kind == "phases") {
    window = 500;
    road = kind == "phases" ? std::make_unique<Loop>(500.37, variedReaches()) : std::make_unique<Loop>(500.0);
  }
  if (!road || frames == 0) {
    std::cerr << "Usage: soak [FRAMES [streets|patrol|phases|network|day [EXP_DENSITY [FOLDER]]]]\n";
    return 2;
  }
  PoseCellParams cells;
  cells.cell_size = kind == "phases" ? 4.0 : 10.0;
  const std::string folder = argc > 4 ? argv[4] : "";
  if (argc > 3) cells.experience_density = std::strtod(argv[3], nullptr);
  ExperienceMapParams map_params;
  PoseCellStage pose_cells(cells);
  MapStage map(map_params, GeometrySource::kNone);
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0.0, 1.0);
  std::map<std::uint64_t, std::uint32_t> view_of_place;
  std::vector<StampedPose> truth;
  Motion driven;
  const double seconds = 1e-9 * static_cast<double>(road->period());
  double worst_ms = 0.0;
  double sum_ms = 0.0;
  std::cout << "frames,experiences,links,graph_nodes,memory_mb,mean_ms,worst_ms\n";
  for (std::size_t frame = 0; frame < frames; ++frame) {
    const Step step = road->next();
    OdometrySample sample;
    sample.stamp = static_cast<Stamp>(frame + 1) * road->period();
    sample.speed = step.speed * (1.0 + 0.02 * noise(random));
    sample.yaw_rate = step.yaw_rate + (step.speed > 0.0 ? 0.002 * noise(random) : 0.0);
    OdometryStep exact;
    exact.rotation = frame == 0 ? 0.0 : seconds * step.yaw_rate;
    exact.forward = frame == 0 ? 0.0 : seconds * step.speed;
    driven.add(exact);
    if (!folder.empty()) truth.push_back({sample.stamp, compose(MapPose{}, driven.pose)});
    ViewEvent view;
    view.stamp = sample.stamp;
    if (step.seen) {
      const auto [seen, learned] =
          view_of_place.emplace(step.place, static_cast<std::uint32_t>(view_of_place.size()));
      view.learned = learned;
      view.id = seen->second;
    }

    const double begin = processorMilliseconds();
    pose_cells.addOdometry(sample);
    map.addOdometry(sample);
    if (step.seen) pose_cells.addView(view);
    for (const PoseCellDecision& decision : pose_cells.drain()) map.addDecision(decision.action);
    map.drain();
    const double took = processorMilliseconds() - begin;
    worst_ms = std::max(worst_ms, took);
    sum_ms += took;
    if ((frame + 1) % window == 0) {
      const ExperienceGraph& graph = map.map().graph();
      std::cout << frame + 1 << ',' << graph.experiences().size() << ',' << graph.links().size() << ','
                << map.map().frames() << ',' << residentMegabytes() << ','
                << sum_ms / static_cast<double>(window) << ',' << worst_ms << std::endl;
      worst_ms = sum_ms = 0.0;
    }
  }
  if (folder.empty()) return 0;
  writeTum(folder + "/truth.tum", inSpace(truth));
  map.map().settle();
  writeTum(folder + "/final.tum", inSpace(map.map().finalTrajectory()));
  return 0;
}
