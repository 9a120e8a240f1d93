/// Looks at the lengths and places in a bag's records before rosbag does, which believes them: it allocates what
/// a length says and reads where an index points.
#pragma once

#include <string>

namespace ratslam {

/// Records lie one behind the other within the file, indexes point at messages within their chunk, and no chunk
/// claims to unpack to far more than it is. What a compressed chunk holds is not looked at.
/// @throws std::runtime_error naming the file and the byte at which it is damaged
void checkBagRecords(const std::string& path);

}  // namespace ratslam
