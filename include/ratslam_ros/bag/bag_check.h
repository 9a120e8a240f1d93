/// Looks at the lengths and places in a bag's records before rosbag does, which believes them: it allocates what
/// a length says and reads where an index points.
#pragma once

#include <rosbag/message_instance.h>

#include <string>

namespace ratslam {

/// Records lie one behind the other within the file, indexes point at messages within their chunk, and no chunk
/// claims to unpack to far more than it is. What a compressed chunk holds is not looked at.
/// @throws std::runtime_error naming the file and the byte at which it is damaged
void checkBagRecords(const std::string& path);

/// The lengths within a message fit into it, so that it can be deserialised without asking for more memory than
/// it takes; types other than Image, CompressedImage and CameraInfo always are.
bool lengthsFit(const rosbag::MessageInstance& message);

}  // namespace ratslam
