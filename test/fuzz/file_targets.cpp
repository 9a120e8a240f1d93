// Files that the core reads: configurations, calibrations, recordings, odometry and poses.
#include <algorithm>
#include <cmath>

#include "ratslam/camera/calibration_file.h"
#include "ratslam/common/parameter_map.h"
#include "ratslam/common/state.h"
#include "ratslam/dataset/kitti_folder.h"
#include "ratslam/dataset/odometry_file.h"
#include "ratslam/dataset/recorder_folder.h"
#include "ratslam/dataset/trajectory_io.h"
#include "ratslam/system/map_store.h"
#include "ratslam/system/pipeline.h"
#include "target.h"

namespace ratslam::fuzz {
namespace {

// A grey PNG of one pixel.
const Bytes kPng{0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48,
                 0x44, 0x52, 0x00, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x01, 0x08, 0x00, 0x00, 0x00,
                 0x00, 0x3a, 0x7e, 0x9b, 0x55, 0x00, 0x00, 0x00, 0x0a, 0x49, 0x44, 0x41, 0x54, 0x78,
                 0x9c, 0x63, 0x68, 0x00, 0x00, 0x00, 0x82, 0x00, 0x81, 0x77, 0xcd, 0x72, 0xb6, 0x00,
                 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};

/// Everything a recording has; at most a few items, all of an input's own making.
void readAll(Recording& recording) {
  while (const auto item = recording.next()) {
    if (const auto* sample = std::get_if<OdometrySample>(&*item)) {
      require(std::isfinite(sample->speed) && std::isfinite(sample->yaw_rate), "odometry is finite");
    } else {
      std::get<RecordedImage>(*item).decode();
    }
  }
  recording.camera();
}

void parameters(const ParameterMap& map) {
  map.rejectUnknown(PipelineParams::knownKeys());
  PipelineParams::fromMap(map);
}

void ini(const Bytes& input) {
  const Folder folder;
  mayRefuse([&] { parameters(ParameterMap::fromFile(folder.write("config.txt", input))); });
}

void yaml(const Bytes& input) {
  const Folder folder;
  mayRefuse([&] { parameters(ParameterMap::fromFile(folder.write("config.yaml", input))); });
}

void kittiTimes(const Bytes& input) {
  const Folder folder;
  for (const char* name : {"image_0/000000.png", "image_0/000001.png"}) folder.write(name, kPng);
  folder.write("times.txt", input);
  mayRefuse([&] {
    KittiFolder kitti(folder.path());
    readAll(kitti);
  });
}

void kittiCalib(const Bytes& input) {
  const Folder folder;
  folder.write("image_0/000000.png", kPng);
  folder.write("times.txt", Bytes{'0', '\n'});
  folder.write("calib.txt", input);
  mayRefuse([&] {
    const KittiFolder kitti(folder.path());
    if (const auto camera = kitti.camera()) camera->validate();
  });
}

void kittiPoses(const Bytes& input) {
  const Folder folder;
  mayRefuse([&] {
    for (const Eigen::Isometry3d& pose : readKittiPoses(folder.write("poses.txt", input))) {
      require(pose.matrix().allFinite(), "poses are finite");
    }
  });
}

void odometryCsv(const Bytes& input) {
  const Folder folder;
  mayRefuse([&] {
    for (const OdometrySample& sample : readOdometryCsv(folder.write("odometry.csv", input))) {
      require(std::isfinite(sample.speed) && std::isfinite(sample.yaw_rate), "odometry is finite");
    }
  });
}

void recorder(const Bytes& input) {
  const Folder folder;
  folder.write("images/1000.jpeg", kPng);
  folder.write("images/2000.jpeg", kPng);
  folder.write("data_image.txt", input);
  mayRefuse([&] {
    RecorderFolder recording(folder.path());
    readAll(recording);
  });
}

void calibration(const Bytes& input) {
  const Folder folder;
  mayRefuse([&] { readCalibration(folder.write("calibration.yaml", input)).validate(); });
}

void state(const Bytes& input) {
  mayRefuse([&] {
    const Bytes written = State::fromBytes(input).toBytes();
    require(State::fromBytes(written).toBytes() == written, "a state that is written is read again");
  });
}

void mapFile(const Bytes& input) {
  const Folder folder;
  mayRefuse([&] { loadMapFile(folder.write("drive.map", input)); });
}

void stamp(const Bytes& input) {
  const std::string text(input.begin(), input.end());
  if (const auto stamp = parseStamp(text)) {
    require(parseStamp(formatStamp(*stamp)) == stamp, "a stamp that is written is read again");
  }
}

}  // namespace

std::vector<Target> fileTargets() {
  return {{"ini", ini},
          {"yaml", yaml},
          {"kitti_times", kittiTimes},
          {"kitti_calib", kittiCalib},
          {"kitti_poses", kittiPoses},
          {"odometry_csv", odometryCsv},
          {"recorder", recorder},
          {"calibration", calibration},
          {"state", state},
          {"map_file", mapFile},
          {"stamp", stamp}};
}

}  // namespace ratslam::fuzz
