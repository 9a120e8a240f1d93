#include "image_pass.h"

#include <filesystem>
#include <iostream>
#include <stdexcept>
#include <utility>
#include <variant>

#include "ratslam/camera/image_decoding.h"
#include "ratslam/dataset/image_folder.h"
#include "recordings.h"

namespace ratslam {
namespace {

namespace fs = std::filesystem;

/// A folder that holds nothing but images.
class PlainFolder : public Recording {
 public:
  PlainFolder(const std::string& folder, const ImageLimits& limits)
      : files_(listImages(folder)), limits_(limits) {}

  std::optional<RecordedItem> next() override {
    if (next_ == files_.size()) return std::nullopt;
    RecordedImage image;
    image.name = files_[next_++];
    image.decode = [path = image.name, limits = limits_] { return decodeImageFile(path, limits); };
    return image;
  }
  std::size_t imageCount() const override { return files_.size(); }

 private:
  std::vector<std::string> files_;
  ImageLimits limits_;
  std::size_t next_ = 0;
};

std::unique_ptr<Recording> open(const std::string& path, const ImageLimits& limits) {
  const bool plain =
      fs::is_directory(path) && !fs::is_directory(path + "/image_0") && !fs::is_directory(path + "/images");
  if (plain) return std::make_unique<PlainFolder>(path, limits);
  RecordingOptions options;
  options.limits = limits;
  return openRecording(path, options);
}

}  // namespace

ImagePass::ImagePass(const std::string& path, const ImageStageParams& params)
    : path_(path),
      stage_(params,
             [this](ImageEvent event, const std::string& text) {
               const bool left_out = event == ImageEvent::kUnreadable || event == ImageEvent::kOtherSize;
               if (left_out && first_fault_.empty()) first_fault_ = text;
             }),
      recording_(open(path, params.limits())),
      items_(std::make_unique<DecodeAhead>(*recording_, 2)) {}

std::optional<ImagePass::Step> ImagePass::next() {
  constexpr Stamp kStep = 1000000000;
  while (auto item = items_->next()) {
    auto* image = std::get_if<DecodedImage>(&*item);
    if (image == nullptr) continue;
    image->stamp = static_cast<Stamp>(++images_) * kStep;
    return Step{stage_.add(*image)};
  }
  reportEnd();
  return std::nullopt;
}

void ImagePass::reportEnd() const {
  const ImageCounts& counts = stage_.counts();
  if (counts.used == 0) {
    throw std::runtime_error(path_ + ": no image was used" +
                             (first_fault_.empty() ? "" : "; the first: " + first_fault_));
  }
  if (counts.used < counts.images) {
    std::cerr << path_ << ": " << counts.text() << "; the first: " << first_fault_ << '\n';
  }
}

}  // namespace ratslam
