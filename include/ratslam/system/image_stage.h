/// Everything that can be wrong with a stream of images, in one place for the nodes and the offline runner.
///
/// In order of their coming, each image is either handed on as an ImageFrame or left out, and what was wrong
/// is counted and told in one wording:
///   - bytes that give no image (image_decoding.h), and images the models cannot use, are left out;
///   - an image of another size than those before is left out, unless more images in a row have the new size
///     than were used before: then the stream begins anew with it (so one odd image at the start costs two);
///   - a stamp that lies back by less than time_reset is a late image and left out; further back, time begins
///     anew; the stamp of the image before, or a stamp of zero among others, are no stamps: left out;
///   - an image with exactly the pixels of the one before is handed on as frozen, one without texture as
///     blank;
///   - 16-bit images that use fewer bits (12-bit sensors) are scaled up to 16.
/// What is handed on depends on the images so far alone.
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
          "an image whose stamp lies back by less is late and left out; further back, time begins anew [s]");
    visit("image_max_pixels", image_max_pixels, Bounds{1, 1e9},
          "images of more pixels are left out before they are decoded");
    visit("image_bits", image_bits, Bounds{0, 16},
          "significant bits of 16-bit images; 0: told by the images themselves");
  }
  /// @throws std::invalid_argument naming key, value and bound
  void validate() const { checkBounds(*this); }

  ImageLimits limits() const { return {image_max_pixels}; }
};

/// What may be said about an image.
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
};
constexpr std::size_t kImageEvents = 10;

/// How many images came, were handed on, and what was said about how many.
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
  /// Gets one line about an image; the same event may come with every image.
  using Tell = std::function<void(ImageEvent, const std::string&)>;

  /// @throws std::invalid_argument for bad parameters
  ImageStage(const ImageStageParams& params, Tell tell);

  /// The next image. @return none where it is left out
  std::optional<ImageFrame> add(const DecodedImage& image);

  /// To be called where a model cannot use a frame that was handed on.
  void refused(const std::string& name, const std::string& why);

  const ImageCounts& counts() const { return counts_; }

  void save(State& state) const;
  /// @throws std::runtime_error naming what is missing or does not fit the parameters
  void load(const State& state);

 private:
  void tell(ImageEvent event, const std::string& text);
  bool stampIsUsable(const DecodedImage& image);
  bool sizeIsUsable(const DecodedImage& image);
  cv::Mat withAllBits(const DecodedImage& image);
  ImageQuality qualityOf(const DecodedImage& image, const cv::Mat& pixels);

  ImageStageParams params_;
  Tell tell_;
  ImageCounts counts_;
  std::optional<Stamp> last_stamp_;
  cv::Size size_;                 ///< of the images handed on, empty before the first
  std::size_t used_of_size_ = 0;  ///< images handed on since the size was set
  cv::Size other_size_;           ///< of the images just left out
  std::size_t others_in_a_row_ = 0;
  bool begins_anew_ = false;  ///< the next frame handed on does
  cv::Mat last_;              ///< pixels of the last frame
  int bits_ = 0;              ///< significant ones of 16-bit images, 0 before one is known
};

}  // namespace ratslam
