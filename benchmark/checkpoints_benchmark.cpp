// How long checkpoints keep each part of the system from its messages: the first frames of kitti_00 below $RATSLAM_DATA
// (default ../shared/data) with config/kitti_orb.yaml, a checkpoint every 5 s of its time. Each part has the files and the
// thread that its node has. Skipped where that drive is missing. Usage: checkpoints_benchmark [FRAMES [CONFIG]]
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "ratslam/common/state.h"
#include "ratslam/dataset/registry.h"
#include "ratslam/odometry/orb/orb_source.h"
#include "ratslam/system/part_checkpoints.h"
#include "ratslam/system/pipeline.h"

namespace {

using namespace ratslam;

/// Processor time of this thread: neither other programs nor the thread that writes count.
double milliseconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

class Part {
 public:
  Part(const std::string& folder, const std::string& name, PartCheckpoints::Save save)
      : name_(name), save_(std::move(save)), checkpoints_(settings(folder, name)) {}

  void before(Stamp stamp) {
    const double begin = milliseconds();
    bool taken = false;
    checkpoints_.before(stamp, [&](State& state) {
      taken = true;
      save_(state);
    });
    if (taken) took_.push_back(milliseconds() - begin);
  }
  void print() {
    if (took_.empty()) return;
    const double last = took_.back();
    std::sort(took_.begin(), took_.end());
    std::printf("%-15s %3zu checkpoints: median %.2f ms, last %.2f ms, worst %.2f ms\n", name_.c_str(),
                took_.size(), took_[took_.size() / 2], last, took_.back());
  }

 private:
  static CheckpointSettings settings(const std::string& folder, const std::string& name) {
    CheckpointSettings chosen;
    chosen.folder = folder;
    chosen.part = name;
    return chosen;
  }

  std::string name_;
  PartCheckpoints::Save save_;
  PartCheckpoints checkpoints_;
  std::vector<double> took_;
};

}  // namespace

int main(int argc, char** argv) {
  const char* data = std::getenv("RATSLAM_DATA");
  const std::string drive = std::string(data ? data : "../shared/data") + "/kitti_00";
  if (!std::filesystem::exists(drive + "/times.txt")) {
    std::printf("skipped: there is no %s\n", drive.c_str());
    return 0;
  }
  const std::size_t frames = argc > 1 ? std::strtoul(argv[1], nullptr, 10) : 1700;
  const auto params =
      PipelineParams::fromMap(ParameterMap::fromFile(argc > 2 ? argv[2] : "config/kitti_orb.yaml"));
  const std::unique_ptr<Recording> recording = folderRecordings().open(drive, {});
  const std::optional<CameraModel> camera = recording->camera();
  Pipeline pipeline(params, std::make_unique<OrbSource>(*camera, params.odometry.of<OrbOdometryParams>()),
                    camera);
  const std::string folder =
      std::filesystem::temp_directory_path() / ("checkpoints." + std::to_string(getpid()));
  {
    std::vector<std::unique_ptr<Part>> parts;
    const auto add = [&](const char* name, auto part) {
      parts.push_back(std::make_unique<Part>(folder, name, [part](State& state) { part().save(state); }));
    };
    add("odometry", [&]() -> const OdometrySource& { return *pipeline.odometry(); });
    add("local_view", [&]() -> const LocalViewCells& { return pipeline.localView(); });
    add("pose_cells", [&]() -> const PoseCellStage& { return pipeline.poseCells(); });
    add("experience_map", [&]() -> const ExperienceMap& { return pipeline.map(); });
    DecodeAhead decoded(*recording, 1);
    for (std::size_t frame = 0; frame < frames; ++frame) {
      const auto item = decoded.next();
      if (!item) break;
      const auto& image = std::get<DecodedImage>(*item);
      for (const auto& part : parts) part->before(image.stamp);
      pipeline.addImage({image.stamp, image.image});
    }
    std::printf("%zu views, %zu experiences\n", pipeline.localView().size(),
                pipeline.map().graph().experiences().size());
    for (const auto& part : parts) part->print();
  }
  std::filesystem::remove_all(folder);
  return 0;
}
