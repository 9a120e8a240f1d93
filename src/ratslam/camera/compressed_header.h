/// Checks of the headers of JPEG (ITU-T T.81) and PNG (ISO/IEC 15948) files, before a decoder reads them.
#pragma once

#include <cstddef>
#include <cstdint>

namespace ratslam {

struct CompressedHeader {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
};

/// @throws BadImage if the bytes are neither a JPEG nor a PNG, or end before the size
CompressedHeader readCompressedHeader(const std::uint8_t* data, std::size_t size);

/// Checks that a file is complete, because decoders fill up truncated files and report success.
/// @throws BadImage if the data end before the image does
void requireWholeCompressed(const std::uint8_t* data, std::size_t size);

}  // namespace ratslam
