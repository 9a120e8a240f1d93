#include "compressed_header.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <string>

#include "ratslam/camera/image_decoding.h"

namespace ratslam {
namespace {

constexpr std::array<std::uint8_t, 8> kPngSignature{0x89, 'P', 'N', 'G', 0x0D, 0x0A, 0x1A, 0x0A};

/// Reads big-endian numbers from data that may be truncated anywhere.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}

  std::size_t size() const { return size_; }
  const std::uint8_t* begin() const { return data_; }
  const std::uint8_t* end() const { return data_ + size_; }
  std::uint32_t at(std::size_t position, std::size_t bytes) const {
    if (position > size_ || bytes > size_ - position) {
      throw BadImage("corrupt compressed image: it ends after " + std::to_string(size_) + " bytes");
    }
    std::uint32_t number = 0;
    for (std::size_t i = 0; i < bytes; ++i) number = (number << 8) | data_[position + i];
    return number;
  }

 private:
  const std::uint8_t* data_;
  std::size_t size_;
};

bool isPng(const Bytes& bytes) {
  return bytes.size() >= kPngSignature.size() &&
         std::equal(kPngSignature.begin(), kPngSignature.end(), bytes.begin());
}

bool isJpeg(const Bytes& bytes) { return bytes.size() >= 3 && bytes.at(0, 3) == 0xFFD8FF; }

struct JpegParts {
  CompressedHeader header;
  std::size_t first_scan = 0;  ///< where the entropy-coded data begins
};

/// Reads the marker segments up to the first scan. Pictures inside segments (thumbnails) are skipped.
JpegParts walkJpeg(const Bytes& bytes) {
  constexpr std::uint32_t kScan = 0xDA;
  std::optional<CompressedHeader> header;
  std::size_t position = 2;
  while (true) {
    if (bytes.at(position, 1) != 0xFF) throw BadImage("corrupt compressed image: a JPEG without its markers");
    while (bytes.at(position, 1) == 0xFF) ++position;  // there may be any number of fill bytes
    const std::uint32_t marker = bytes.at(position++, 1);
    const bool alone = marker == 0x01 || (marker >= 0xD0 && marker <= 0xD8);
    if (alone) continue;
    const std::uint32_t length = bytes.at(position, 2);
    if (length < 2 || marker == 0xD9) throw BadImage("corrupt compressed image: a JPEG without an image");
    const bool frame = marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
    if (frame) header = CompressedHeader{bytes.at(position + 5, 2), bytes.at(position + 3, 2)};
    position += length;
    if (marker == kScan) break;
  }
  if (!header) throw BadImage("corrupt compressed image: a JPEG that does not tell its size");
  return {*header, position};
}

void requireWholePng(const Bytes& bytes) {
  constexpr std::uint32_t kEnd = 0x49454E44;  // IEND
  std::size_t position = kPngSignature.size();
  while (bytes.at(position + 4, 4) != kEnd) position += std::size_t{bytes.at(position, 4)} + 12;
}

void requireWholeJpeg(const Bytes& bytes) {
  // The marker that ends the image cannot occur within its entropy-coded data.
  const std::array<std::uint8_t, 2> end_of_image{0xFF, 0xD9};
  const std::size_t scan = std::min(walkJpeg(bytes).first_scan, bytes.size());
  if (std::search(bytes.begin() + scan, bytes.end(), end_of_image.begin(), end_of_image.end()) == bytes.end())
    throw BadImage("corrupt compressed image: a JPEG that was cut off after " + std::to_string(bytes.size()) +
                   " bytes");
}

}  // namespace

CompressedHeader readCompressedHeader(const std::uint8_t* data, std::size_t size) {
  const Bytes bytes(data, size);
  if (isJpeg(bytes)) return walkJpeg(bytes).header;
  if (isPng(bytes)) {
    constexpr std::uint32_t kHeader = 0x49484452;  // IHDR
    if (bytes.at(12, 4) != kHeader) throw BadImage("corrupt compressed image: a PNG without its header");
    const CompressedHeader header{bytes.at(16, 4), bytes.at(20, 4)};
    constexpr std::uint32_t kMost = 0x7FFFFFFF;  // as PNG has it
    if (header.width > kMost || header.height > kMost) {
      throw BadImage("corrupt compressed image: a PNG of " + std::to_string(header.width) + "x" +
                     std::to_string(header.height) + " pixels, which may be 2147483647 at most");
    }
    return header;
  }
  throw BadImage("corrupt compressed image: " + std::to_string(size) +
                 " bytes that are neither JPEG nor PNG");
}

void requireWholeCompressed(const std::uint8_t* data, std::size_t size) {
  const Bytes bytes(data, size);
  if (isPng(bytes)) {
    requireWholePng(bytes);
  } else {
    requireWholeJpeg(bytes);
  }
}

}  // namespace ratslam
