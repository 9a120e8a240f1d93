#include "ratslam/common/stamp.h"

#include <cstdio>

namespace ratslam {

std::string formatStamp(Stamp stamp) {
  const Stamp billion = 1000000000;
  const bool negative = stamp < 0;
  const Stamp magnitude = negative ? -stamp : stamp;
  char text[40];
  std::snprintf(text, sizeof text, "%s%lld.%09lld", negative ? "-" : "",
                static_cast<long long>(magnitude / billion), static_cast<long long>(magnitude % billion));
  return text;
}

}  // namespace ratslam
