#include "ratslam/vision/frame_state.h"

#include <stdexcept>

#include "ratslam/common/state.h"
#include "ratslam/common/state_image.h"

namespace ratslam {

int FramesToSave::number(const std::shared_ptr<const Frame>& frame) {
  if (!frame) return -1;
  const auto [found, is_new] = numbers_.emplace(frame.get(), static_cast<int>(frames_.size()));
  if (is_new) frames_.push_back(frame);
  return found->second;
}

void FramesToSave::save(State& state) const {
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    const Frame& frame = *frames_[i];
    std::vector<Eigen::Vector2d> pixels;
    pixels.reserve(frame.features.size());
    for (const Feature& feature : frame.features) pixels.push_back(feature.pixel);
    // Packing takes milliseconds per frame, so it is done later. The image is never changed; the rest is copied.
    state.setLater(std::to_string(i), [stamp = frame.stamp, image = frame.pyramid.image(0), pixels,
                                       outdated = frame.features_outdated, pose = frame.T_camera_world,
                                       observations = frame.observations](State& saved) {
      saved.set("stamp", stamp);
      saved.set("png", packedPhoto(image));
      saved.set("pixels", pixels);
      saved.set("features_outdated", outdated);
      saved.set("T_camera_world", pose);
      saved.set("observations", observations);
    });
  }
  state.set("count", static_cast<std::uint32_t>(frames_.size()));
}

LoadedFrames::LoadedFrames(const State& state, const CameraModel& camera, const FeatureExtractor& extractor,
                           const ExtractorParams& params, WorkerPool& workers) {
  CameraModel pinhole = camera;  // the undistorted positions are read from the state
  pinhole.model = LensModel::kNone;
  const auto count = state.get<std::uint32_t>("count");
  for (std::uint32_t i = 0; i < count; ++i) {
    const State& saved = state.child(std::to_string(i));
    const cv::Mat image = getImage(saved);
    if (image.cols != camera.width || image.rows != camera.height || image.type() != CV_8UC1)
      throw std::runtime_error("state " + saved.path() + "/png: no grey image of the camera's size");
    auto frame = std::make_shared<Frame>(
        makeFrame(saved.get<Stamp>("stamp"), image, pinhole, extractor, params, workers));
    const auto pixels = saved.get<std::vector<Eigen::Vector2d>>("pixels");
    if (pixels.size() != frame->features.size()) {
      throw std::runtime_error("state " + saved.path() + "/pixels: " + std::to_string(pixels.size()) +
                               " places for " + std::to_string(frame->features.size()) + " features");
    }
    if (!std::all_of(pixels.begin(), pixels.end(), [](const auto& pixel) { return pixel.allFinite(); }))
      throw std::runtime_error("state " + saved.path() + "/pixels: a place is not finite");
    placeFeatures(*frame, pixels);
    saved.get("features_outdated", frame->features_outdated);
    saved.get("T_camera_world", frame->T_camera_world);
    saved.get("observations", frame->observations);
    frames_.push_back(std::move(frame));
  }
}

std::shared_ptr<Frame> LoadedFrames::frame(int number) const {
  if (number == -1) return nullptr;
  if (number < 0 || number >= static_cast<int>(frames_.size()))
    throw std::runtime_error("state of the odometry: it has no frame " + std::to_string(number));
  return frames_[static_cast<std::size_t>(number)];
}

}  // namespace ratslam
