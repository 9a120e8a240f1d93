#include "ratslam/odometry/source.h"

#include <stdexcept>

namespace ratslam {

void OdometrySource::save(State&) const {
  throw std::runtime_error("this odometry cannot be saved in the middle of a drive");
}

void OdometrySource::load(const State&) {
  throw std::runtime_error("this odometry cannot be continued from a file");
}

}  // namespace ratslam
