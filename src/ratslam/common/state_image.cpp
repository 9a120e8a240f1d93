#include "ratslam/common/state_image.h"

#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

namespace ratslam {

void setImage(State& state, const cv::Mat& image) {
  state.set("size", std::array<int, 2>{image.cols, image.rows});
  state.set("type", image.type());
  std::vector<std::uint8_t> pixels;
  const std::size_t row_bytes = static_cast<std::size_t>(image.cols) * image.elemSize();
  for (int row = 0; row < image.rows; ++row)
    pixels.insert(pixels.end(), image.ptr(row), image.ptr(row) + row_bytes);
  state.set("pixels", pixels);
}

void setPhoto(State& state, const std::string& name, const cv::Mat& image) {
  state.setLater(name, [image](State& saved) {
    if (image.empty()) {
      setImage(saved, image);
    } else {
      saved.set("png", packedPhoto(image));
    }
  });
}

std::vector<std::uint8_t> packedPhoto(const cv::Mat& image) {
  std::vector<std::uint8_t> png;
  // In camera noise deflate finds only run lengths. Stronger settings take longer and give larger files.
  const std::vector<int> how{cv::IMWRITE_PNG_COMPRESSION, 1, cv::IMWRITE_PNG_STRATEGY,
                             cv::IMWRITE_PNG_STRATEGY_RLE};
  if (!cv::imencode(".png", image, png, how)) throw std::runtime_error("an image cannot be packed as PNG");
  return png;
}

cv::Mat getImage(const State& state) {
  if (state.arrays().count("png") > 0) {
    const auto png = state.get<std::vector<std::uint8_t>>("png");
    cv::Mat image = png.empty() ? cv::Mat() : cv::imdecode(png, cv::IMREAD_UNCHANGED);
    if (image.empty()) throw std::runtime_error("state " + state.path() + "/png: it is no image");
    return image;
  }
  constexpr int kMostSide = 1 << 20;
  const auto size = state.get<std::array<int, 2>>("size");
  const auto type = state.get<int>("type");
  const auto pixels = state.get<std::vector<std::uint8_t>>("pixels");
  const bool possible = size[0] >= 0 && size[1] >= 0 && size[0] < kMostSide && size[1] < kMostSide &&
                        type >= 0 && type == CV_MAT_TYPE(type);
  const auto row_bytes =
      possible ? static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(CV_ELEM_SIZE(type)) : 0;
  if (!possible || pixels.size() != row_bytes * static_cast<std::size_t>(size[1])) {
    throw std::runtime_error("state " + state.path() + "/pixels: they do not fill the image");
  }
  if (pixels.empty()) return {};
  cv::Mat image(size[1], size[0], type);
  for (int row = 0; row < image.rows; ++row) {
    std::memcpy(image.ptr(row), pixels.data() + static_cast<std::size_t>(row) * row_bytes, row_bytes);
  }
  return image;
}

}  // namespace ratslam
