/// What the headers of JPEG (ITU-T T.81) and PNG (ISO/IEC 15948) files say, read before any decoder sees them.
#pragma once

#include <cstddef>
#include <cstdint>

namespace ratslam {

struct CompressedHeader {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
};

/// @throws BadImage where the bytes are neither a JPEG nor a PNG, or end before the size is told
CompressedHeader readCompressedHeader(const std::uint8_t* data, std::size_t size);

/// Decoders fill up what a truncated file lacks and report success.
/// @throws BadImage where the data ends before the image does
void requireWholeCompressed(const std::uint8_t* data, std::size_t size);

}  // namespace ratslam
