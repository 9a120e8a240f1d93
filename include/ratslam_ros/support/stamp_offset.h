/// Two streams that are merged by stamp and whose stamps come from clocks that disagree: without a word one would
/// wait for the other for ever, or lie outside its time altogether.
#pragma once

#include <ros/time.h>

#include <deque>
#include <optional>
#include <string>

#include "ratslam/common/stamp.h"

namespace ratslam {

class StampOffset {
 public:
  /// Both streams have spoken.
  void first(Stamp stamp) { first_ = {stamp, ros::WallTime::now()}; }
  void second(Stamp stamp) { second_ = {stamp, ros::WallTime::now()}; }

  /// How far the second stream's newest stamp is ahead of the first's [s], while both speak.
  std::optional<double> seconds() const;

  /// A line that names a lasting difference of more than a second; none where there is none or it has been told.
  /// To be asked a few times a second. What one stream lags behind for want of computing time changes; a
  /// difference of clocks does not.
  std::optional<std::string> complaint(const std::string& first_name, const std::string& second_name);

 private:
  struct Spoken {
    Stamp stamp = 0;
    ros::WallTime at;
  };

  std::optional<Spoken> first_;
  std::optional<Spoken> second_;
  std::deque<double> lately_;  ///< differences of the last seconds
  std::optional<double> told_;
};

}  // namespace ratslam
