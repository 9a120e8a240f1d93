#include "ratslam/system/image_stage.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "ratslam/camera/equal_pixels.h"
#include "ratslam/common/state.h"
#include "ratslam/common/state_image.h"
#include "ratslam/system/image_texture.h"

namespace ratslam {
namespace {

/// A recording may begin at stamp zero. But if zero means "no stamp", the next stamp jumps to the present year.
constexpr double kLongestFirstStep = 10.0;  // [s]

/// So many images in a row of another size mean a change for good, however long the camera had the size before.
constexpr std::size_t kMostOfAnotherSize = 100;

struct EventNames {
  const char* counter;  ///< in summary.json and diagnostics
  const char* words;    ///< in a sentence
};

constexpr std::array<EventNames, kImageEvents> kNames{{
    {"corrupt_images", "unreadable"},
    {"other_size_images", "of another size"},
    {"unsuitable_images", "unsuitable"},
    {"late_images", "late"},
    {"repeated_stamp_images", "with a repeated stamp"},
    {"unstamped_images", "without a stamp"},
    {"new_beginnings", "with which time or size began anew"},
    {"frozen_images", "frozen"},
    {"blank_images", "without texture"},
    {"changes_of_bit_depth", "with which the number of bits was found"},
    {"ahead_images", "ahead of time"},
}};

std::string text(const cv::Size& size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

std::string secondsText(double seconds) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.6g s", seconds);
  return text;
}

/// Bits of the sensor that the largest value of any colour needs: 8, 10, 12, 14 or 16; 0 for a black image.
int bitsOf(const cv::Mat& image) {
  double largest = 0.0;
  cv::minMaxLoc(image.reshape(1), nullptr, &largest);
  if (largest == 0.0) return 0;
  int bits = 8;
  while (bits < 16 && largest >= static_cast<double>(1 << bits)) bits += 2;
  return bits;
}

}  // namespace

void ImageCounts::visit(const std::function<void(const std::string&, std::size_t)>& visit) const {
  visit("frames", images);
  visit("used_images", used);
  for (std::size_t i = 0; i < kImageEvents; ++i) visit(kNames[i].counter, events[i]);
}

std::string ImageCounts::text() const {
  std::string list;
  for (std::size_t i = 0; i < kImageEvents; ++i) {
    if (events[i] == 0) continue;
    list += (list.empty() ? "" : ", ") + std::to_string(events[i]) + " " + kNames[i].words;
  }
  return std::to_string(used) + " of " + std::to_string(images) + " images used" +
         (list.empty() ? "" : " (" + list + ")");
}

ImageStage::ImageStage(const ImageStageParams& params, Tell tell)
    : params_(params), tell_(std::move(tell)), bits_(params.image_bits) {
  params_.validate();
}

void ImageStage::tell(ImageEvent event, const std::string& text) {
  ++counts_.events[static_cast<std::size_t>(event)];
  if (tell_) tell_(event, text);
}

std::optional<ImageFrame> ImageStage::add(const DecodedImage& image) {
  ++counts_.images;
  handed_on_ = refused_ = false;
  if (image.image.empty()) {
    tell(ImageEvent::kUnreadable, image.name + ": image skipped: " + image.error);
    return std::nullopt;
  }
  if (!stampIsUsable(image) || !sizeIsUsable(image)) return std::nullopt;
  ImageFrame frame;
  frame.stamp = image.stamp;
  frame.begins_anew = begins_anew_;
  frame.image = withAllBits(image);
  frame.quality = qualityOf(image, frame.image);
  begins_anew_ = false;
  last_ = frame.image;
  stamp_before_ = std::exchange(last_stamp_, image.stamp);
  ++used_of_size_;
  ++counts_.used;
  handed_on_ = true;
  return frame;
}

void ImageStage::refused(const std::string& name, const std::string& why) {
  const std::string text = name + ": image skipped: " + why;
  if (refused_) {  // by another model: the image is counted already
    if (tell_) tell_(ImageEvent::kUnsuitable, text);
    return;
  }
  tell(ImageEvent::kUnsuitable, text);
  if (handed_on_) --counts_.used;
  refused_ = true;
}

void ImageStage::save(State& state) const {
  const auto number = [](std::size_t count) { return static_cast<std::uint64_t>(count); };
  std::vector<std::uint64_t> counts{number(counts_.images), number(counts_.used)};
  for (const std::size_t count : counts_.events) counts.push_back(number(count));
  state.set("counts", counts);
  state.set("last_stamp", last_stamp_);
  state.set("stamp_before", stamp_before_);
  state.set("size", std::array<int, 2>{size_.width, size_.height});
  state.set("used_of_size", number(used_of_size_));
  state.set("other_size", std::array<int, 2>{other_size_.width, other_size_.height});
  state.set("others_in_a_row", number(others_in_a_row_));
  state.set("begins_anew", begins_anew_);
  state.set("bits", bits_);
  setPhoto(state, "last", last_.clone());  // its memory may belong to the camera's driver
}

void ImageStage::load(const State& state) {
  const auto counts = state.get<std::vector<std::uint64_t>>("counts");
  if (counts.size() != kImageEvents + 2) {
    throw std::runtime_error("state " + state.path() + "/counts: there are " + std::to_string(counts.size()));
  }
  counts_.images = counts[0];
  counts_.used = counts[1];
  std::copy(counts.begin() + 2, counts.end(), counts_.events.begin());
  const auto size = state.get<std::array<int, 2>>("size");
  const auto other_size = state.get<std::array<int, 2>>("other_size");
  size_ = {size[0], size[1]};
  other_size_ = {other_size[0], other_size[1]};
  state.get("last_stamp", last_stamp_);
  state.get("stamp_before", stamp_before_);
  used_of_size_ = state.get<std::uint64_t>("used_of_size");
  others_in_a_row_ = state.get<std::uint64_t>("others_in_a_row");
  state.get("begins_anew", begins_anew_);
  state.get("bits", bits_);
  last_ = getImage(state.child("last"));
}

/// Whether the last image had jumped ahead alone: the next one is back near those before it.
bool ImageStage::lastIsAhead(Stamp next) const {
  return stamp_before_ && secondsBetween(*stamp_before_, *last_stamp_) > params_.time_reset &&
         next > *stamp_before_ && secondsBetween(*stamp_before_, next) < secondsBetween(next, *last_stamp_);
}

bool ImageStage::isContinuedBy(Stamp next) const {
  if (!last_stamp_) return false;
  const Stamp last = next < *last_stamp_ && lastIsAhead(next) ? *stamp_before_ : *last_stamp_;
  return next > last && secondsBetween(last, next) <= params_.time_reset;
}

bool ImageStage::stampIsUsable(const DecodedImage& image) {
  if (image.stamp < 0 || (image.stamp == 0 && last_stamp_ && *last_stamp_ != 0)) {
    tell(ImageEvent::kNoStamp, image.name + ": image skipped: it has no stamp");
    return false;
  }
  if (!last_stamp_ || image.stamp > *last_stamp_) {
    if (last_stamp_ && *last_stamp_ == 0 && toSeconds(image.stamp) > kLongestFirstStep) {
      tell(ImageEvent::kBeginsAnew, image.name + ": the image before had no stamp: a new beginning");
      begins_anew_ = true;
    }
    return true;
  }
  if (image.stamp == *last_stamp_) {
    tell(ImageEvent::kRepeatedStamp,
         image.name + ": image skipped: it repeats the stamp of the image before" +
             (image.stamp == 0 ? ", which is zero: whoever made the images has set no stamps" : ""));
    return false;
  }
  const double back = secondsBetween(image.stamp, *last_stamp_);
  if (back < params_.time_reset) {
    tell(ImageEvent::kLate, image.name + ": image skipped: it is late, its stamp lies " + secondsText(back) +
                                " before that of the image before");
    return false;
  }
  // Only a used image sets the clock, and sizeIsUsable may still leave this one out.
  if (!sizeIsUsable(image)) return false;
  // In either case an odometry from the images has measured a wrong step, and starts anew.
  begins_anew_ = true;
  if (lastIsAhead(image.stamp)) {
    last_stamp_ = stamp_before_;
    tell(ImageEvent::kAhead, image.name + ": the stamp of the image before it lies ahead of time, by " +
                                 secondsText(back) + " more than this one's");
    return true;
  }
  tell(ImageEvent::kBeginsAnew,
       image.name + ": time went back by " + secondsText(back) + ": a new beginning");
  return true;
}

bool ImageStage::sizeIsUsable(const DecodedImage& image) {
  const cv::Size size = image.image.size();
  if (size_.empty()) size_ = size;
  if (size == size_) {
    others_in_a_row_ = 0;
    return true;
  }
  others_in_a_row_ = size == other_size_ ? others_in_a_row_ + 1 : 1;
  other_size_ = size;
  const std::string change = "its size changed from " + text(size_) + " to " + text(size);
  if (others_in_a_row_ <= std::min(used_of_size_, kMostOfAnotherSize)) {
    tell(ImageEvent::kOtherSize, image.name + ": image skipped: " + change);
    return false;
  }
  tell(ImageEvent::kBeginsAnew, image.name + ": " + change + " for good: a new beginning");
  size_ = size;
  used_of_size_ = others_in_a_row_ = 0;
  begins_anew_ = true;
  return true;
}

cv::Mat ImageStage::withAllBits(const DecodedImage& image) {
  if (image.image.depth() != CV_16U) return image.image;
  const int needed = bitsOf(image.image);
  if (needed > bits_) {
    bits_ = needed;
    if (bits_ < 16) {
      tell(ImageEvent::kFewBits, image.name + ": 16-bit images use " + std::to_string(bits_) +
                                     " bits: they are scaled up (image_bits=16 leaves them as they are)");
    }
  }
  const double scale = bits_ == 0 ? 1.0 : static_cast<double>(1 << (16 - bits_));
  cv::Mat scaled;
  if (image.image.channels() > 1) {
    image.image.convertTo(scaled, CV_8U, scale * 255.0 / 65535.0);  // the models take colours of 8 bits
    return scaled;
  }
  if (scale == 1.0) return image.image;
  image.image.convertTo(scaled, CV_16U, scale);
  return scaled;
}

ImageQuality ImageStage::qualityOf(const DecodedImage& image, const cv::Mat& pixels) {
  if (!begins_anew_ && equalPixels(pixels, last_)) {
    tell(ImageEvent::kFrozen,
         image.name + ": exactly the pixels of the image before: nothing is learned, recalled or measured");
    return ImageQuality::kFrozen;
  }
  if (!hasTexture(pixels)) {
    tell(ImageEvent::kBlank, image.name + ": no texture: nothing is learned, recalled or measured");
    return ImageQuality::kBlank;
  }
  return ImageQuality::kUsable;
}

}  // namespace ratslam
