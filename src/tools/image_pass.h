// The images of one pass along a route, for the evaluation of places.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>

#include "ratslam/dataset/recording.h"
#include "ratslam/system/image_stage.h"

namespace ratslam {

/// Reads the images of a folder, of a KITTI sequence or of a bag, and checks them as ImageStage does. Stamps are
/// ignored: each image counts as one step on, one that is left out as well.
class ImagePass {
 public:
  /// @throws std::runtime_error naming a folder or file that holds no recording
  ImagePass(const std::string& path, const ImageStageParams& params);

  /// An image of the pass, or the place of one that shows nothing.
  struct Step {
    std::optional<ImageFrame> frame;  ///< none if the image is left out
    bool usable() const { return frame && frame->usable(); }
  };

  /// The next image; none at the end. Reports once on std::cerr at the end if images were left out.
  /// @throws std::runtime_error at the end if no image was used
  std::optional<Step> next();

 private:
  void reportEnd() const;

  std::string path_;
  std::string first_fault_;
  ImageStage stage_;
  std::unique_ptr<Recording> recording_;
  std::unique_ptr<DecodeAhead> items_;
  std::size_t images_ = 0;
};

}  // namespace ratslam
