// ROS messages with any contents, and bags.
#include <boost/make_shared.hpp>
#include <cmath>

#include "ratslam/system/map_stage.h"
#include "ratslam/system/pose_cell_stage.h"
#include "ratslam_ros/bag/bag_recording.h"
#include "ratslam_ros/support/camera_info.h"
#include "ratslam_ros/support/checked_stream.h"
#include "ratslam_ros/support/conversions.h"
#include "ratslam_ros/support/image_decoding.h"
#include "target.h"

namespace ratslam::fuzz {
namespace {

std::string text(Reader& reader) {
  const Bytes bytes = reader.takeBytes(reader.take<std::uint8_t>() % 24);
  return {bytes.begin(), bytes.end()};
}

void image(const Bytes& input) {
  const char* const encodings[] = {"mono8",       "mono16",       "bgr8",        "rgb8",    "bgra8", "rgba8",
                                   "bayer_rggb8", "8UC1",         "8UC3",        "16UC1",   "32FC1", "yuv422",
                                   "64FC4",       "bayer_grbg16", "yuv422_yuy2", "nonsense"};
  Reader reader(input);
  auto message = boost::make_shared<sensor_msgs::Image>();
  const auto how = reader.take<std::uint8_t>();
  message->encoding = how == 255 ? text(reader) : encodings[how % 16];
  // Mostly small sizes: others are refused at once.
  const bool large = how % 32 == 31;
  message->height = large ? reader.take<std::uint32_t>() : reader.take<std::uint8_t>();
  message->width = large ? reader.take<std::uint32_t>() : reader.take<std::uint8_t>();
  message->step = large ? reader.take<std::uint32_t>() : reader.take<std::uint16_t>();
  message->is_bigendian = reader.take<std::uint8_t>() % 2;
  message->data = reader.rest();
  if (how % 8 == 0 && !large) message->data.resize(std::size_t{message->step} * message->height);
  mayRefuse([&] {
    const cv::Mat pixels = decodeImage(sensor_msgs::ImageConstPtr(message));
    require(!pixels.empty(), "an image has pixels");
    cv::sum(pixels.reshape(1));  // reads all of them
  });
}

void compressedImage(const Bytes& input) {
  Reader reader(input);
  auto message = boost::make_shared<sensor_msgs::CompressedImage>();
  message->format = reader.take<std::uint8_t>() % 2 == 0 ? "jpeg" : "png";
  message->data = reader.rest();
  mayRefuse([&] { decodeImage(sensor_msgs::CompressedImageConstPtr(message)); });
}

void cameraInfo(const Bytes& input) {
  const char* const models[] = {"plumb_bob", "rational_polynomial", "equidistant", "", "fisheye"};
  Reader reader(input);
  sensor_msgs::CameraInfo message;
  const auto how = reader.take<std::uint8_t>();
  message.distortion_model = how < 250 ? models[how % 5] : text(reader);
  message.width = reader.take<std::uint16_t>();
  message.height = reader.take<std::uint16_t>();
  message.D.resize(reader.take<std::uint8_t>() % 16);
  const auto number = [&] {
    const auto size = reader.take<std::int8_t>();
    return size == 127 ? reader.take<double>() : 10.0 * size;
  };
  for (double& value : message.D) value = 0.001 * number();
  for (double& value : message.K) value = number();
  for (double& value : message.P) value = number();
  mayRefuse([&] {
    const CameraModel camera = cameraFromMessage(message);
    camera.validate();
    require(camera.undistort(Eigen::Vector2d(3.0, 4.0)).allFinite(), "undistorted points are finite");
  });
}

/// The messages as they come from the wire: what ROS can take apart goes the way the nodes send it.
template <class Message>
bool fromWire(const Bytes& bytes, Message& message) {
  if (bytes.empty()) return false;
  Bytes copy = bytes;
  try {
    readChecked(copy.data(), static_cast<std::uint32_t>(copy.size()), message);
    return true;
  } catch (const ros::serialization::StreamOverrunException&) {
    return false;  // the subscription drops it
  }
}

void events(const Bytes& input) {
  Reader reader(input);
  PoseCellStage pose_cells{fewPoseCells()};
  MapStage map{ExperienceMapParams{}, GeometrySource::kImages};
  ratslam_ros::OdometryQuality quality;  // of the next sample
  for (int count = 0; !reader.atEnd() && count < 100; ++count) {
    const auto kind = reader.take<std::uint8_t>();
    const Bytes bytes = reader.takeBytes(reader.take<std::uint16_t>() % 1024);
    mayRefuse([&] {
      nav_msgs::Odometry odometry;
      ratslam_ros::ViewTemplate view;
      ratslam_ros::TopologicalAction action;
      ratslam_ros::PoseCellState state;
      ratslam_ros::RecallGeometry geometry;
      if (kind >= 240) {
        ratslam_ros::OdometryQuality heard;
        if (!fromWire(bytes, heard)) return;
        requireUsable(heard);
        quality = heard;
      } else if (kind % 5 == 0 && fromWire(bytes, odometry)) {
        OdometrySample sample = odometryFromMessage(odometry);
        addQuality(quality, sample);
        pose_cells.addOdometry(sample);
        map.addOdometry(sample);
      } else if (kind % 5 == 1 && fromWire(bytes, view)) {
        pose_cells.addView(viewFromMessage(view));
      } else if (kind % 5 == 2 && fromWire(bytes, action)) {
        map.addDecision(actionFromMessage(action));
      } else if (kind % 5 == 3 && fromWire(bytes, state)) {
        map.addDecision(actionFromMessage(state));
      } else if (kind % 5 == 4 && fromWire(bytes, geometry)) {
        map.addGeometry(geometryFromMessage(geometry));
      }
    });
    mayRefuse([&] { pose_cells.drain(); });
    mayRefuse([&] { map.drain(); });
  }
  mayRefuse([&] { map.drain(Passing::kAll); });
  requireFinite(map.map());
}

void bag(const Bytes& input) {
  static const rosbag::Bag keeps_loaded;  // each loads a plugin, which the last one unloads again
  const Folder folder;
  const std::string path = folder.write("drive.bag", input);
  mayRefuse([&] {
    BagTopics topics;
    topics.with_odometry = input.size() % 2 == 1;
    BagRecording recording(path, topics);
    mayRefuse([&] { recording.camera(); });
    while (const auto item = recording.next()) {
      if (const auto* encoded = std::get_if<RecordedImage>(&*item)) mayRefuse([&] { encoded->decode(); });
    }
  });
}

}  // namespace

std::vector<Target> messageTargets() {
  return {{"image", image},
          {"compressed_image", compressedImage},
          {"camera_info", cameraInfo},
          {"events", events},
          {"bag", bag}};
}

}  // namespace ratslam::fuzz
