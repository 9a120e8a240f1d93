/// Checks a stream of images. The nodes and the offline runner share these checks and their messages.
///
/// The stage takes the images in order. It hands each one on as an ImageFrame or leaves it out. Each fault is
/// counted and reported:
///   - Bytes that give no image (image_decoding.h) and images that a model refuses are left out.
///   - An image of another size than those before is left out. If more images in a row have the new size than had the
///     old one, or more than 100, the stream begins anew. (So one image of a wrong size at the start costs two images.)
///   - A stamp that steps back by less than time_reset is late: the image is left out. If it steps back by more, time
///     begins anew, unless only the image before had jumped ahead. An image with a repeated stamp, or with a stamp of
///     zero among others, is left out.
///   - An image with exactly the pixels of the one before is handed on as frozen, one without texture as blank.
///   - 16-bit images that use fewer bits (12-bit sensors) are scaled up to 16. Colours are then converted to 8 bits.
/// The result depends only on the images so far.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "ratslam/camera/image_decoding.h"
#include "ratslam/camera/image_frame.h"
#include "ratslam/common/params.h"
#include "ratslam/dataset/recording.h"

namespace ratslam {

class State;

struct ImageStageParams {
  double time_reset = 1.0;
  int image_max_pixels = 50000000;
  int image_bits = 0;

  template <class Visitor>
  void visitFields(Visitor&& visit) {
    visit("time_reset", time_reset, Bounds{0.0, 1e6},
          "a stamp of an image that steps back by less is late and left out; by more, time begins anew [s]");
    visit("image_max_pixels", image_max_pixels, Bounds{1, 1e9},
          "images of more pixels are left out before they are decoded");
    visit("image_bits", image_bits, Bounds{0, 16},
          "significant bits of 16-bit images; 0: found from the images' values");
  }
  /// @throws std::invalid_argument naming key, value and bound
  void validate() const { checkBounds(*this); }

  ImageLimits limits() const { return {image_max_pixels}; }
};

/// Faults that the stage counts and reports.
enum class ImageEvent : std::uint8_t {
  kUnreadable = 0,
  kOtherSize,
  kUnsuitable,  ///< refused by a model: the crop, the calibration
  kLate,
  kRepeatedStamp,
  kNoStamp,
  kBeginsAnew,
  kFrozen,
  kBlank,
  kFewBits,
  kAhead,
};
constexpr std::size_t kImageEvents = 11;

/// Numbers of images that arrived, that were used, and of each fault.
struct ImageCounts {
  std::size_t images = 0;
  std::size_t used = 0;
  std::array<std::size_t, kImageEvents> events{};

  std::size_t of(ImageEvent event) const { return events[static_cast<std::size_t>(event)]; }
  /// Calls visit(name, number) for each.
  void visit(const std::function<void(const std::string&, std::size_t)>& visit) const;
  /// "58 of 60 images used (1 late, 1 unreadable)"
  std::string text() const;
};

class ImageStage {
 public:
  /// Receives one line about an image. The same event may be reported for every image.
  using Tell = std::function<void(ImageEvent, const std::string&)>;

  /// @throws std::invalid_argument for bad parameters
  ImageStage(const ImageStageParams& params, Tell tell);

  /// Takes the next image. @return none if it is left out
  std::optional<ImageFrame> add(const DecodedImage& image);

  /// To be called if a model refuses the frame that was handed on last. The image then counts as not used, and once
  /// as unsuitable, however many models refuse it.
  void refused(const std::string& name, const std::string& why);

  /// Whether a recording whose first image has this stamp continues the images so far: it follows the last one within
  /// time_reset, or the one before if the last one alone has jumped ahead.
  bool isContinuedBy(Stamp next) const;

  const ImageCounts& counts() const { return counts_; }

  void save(State& state) const;
  /// @throws std::runtime_error naming what is missing or does not fit the parameters
  void load(const State& state);

 private:
  void tell(ImageEvent event, const std::string& text);
  bool lastIsAhead(Stamp next) const;
  bool stampIsUsable(const DecodedImage& image);
  bool sizeIsUsable(const DecodedImage& image);
  cv::Mat withAllBits(const DecodedImage& image);
  ImageQuality qualityOf(const DecodedImage& image, const cv::Mat& pixels);

  ImageStageParams params_;
  Tell tell_;
  ImageCounts counts_;
  std::optional<Stamp> last_stamp_;
  std::optional<Stamp> stamp_before_;  ///< of the image before the last
  bool handed_on_ = false;  ///< whether the last image was handed on; valid until the next image, not saved
  bool refused_ = false;    ///< whether a model refused the last image; valid as long
  cv::Size size_;           ///< of the images handed on, empty before the first
  std::size_t used_of_size_ = 0;  ///< images handed on since the size was set
  cv::Size other_size_;           ///< of the images just left out
  std::size_t others_in_a_row_ = 0;
  bool begins_anew_ = false;  ///< the next frame handed on begins the stream anew
  cv::Mat last_;              ///< pixels of the last frame
  int bits_ = 0;              ///< significant ones of 16-bit images, 0 before one is known
};

}  // namespace ratslam
