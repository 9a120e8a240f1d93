/// Detects that two streams which are merged by stamp have different clocks. Otherwise one would silently wait for the
/// other for ever, or cover another time altogether.
#pragma once

#include <ros/time.h>

#include <deque>
#include <optional>
#include <string>

#include "ratslam/common/stamp.h"

namespace ratslam {

class StampOffset {
 public:
  /// Sets the newest stamp of either stream.
  void first(Stamp stamp) { first_ = {stamp, ros::WallTime::now()}; }
  void second(Stamp stamp) { second_ = {stamp, ros::WallTime::now()}; }

  /// Lead of the second stream's newest stamp over the first's, less the time between their arrivals [s]; none if one of
  /// them is silent.
  std::optional<double> seconds() const;
  /// Time for which the second stream has gone on without the first [s]; none before both have spoken.
  std::optional<double> secondAlone() const;

  /// A warning about a lasting difference of more than a second; none if there is none or it has been reported. To be
  /// called a few times a second. A lag by lack of computing time varies, a difference of clocks does not.
  std::optional<std::string> complaint(const std::string& first_name, const std::string& second_name);

 private:
  struct Spoken {
    Stamp stamp = 0;
    ros::WallTime at;
  };

  std::optional<Spoken> first_;
  std::optional<Spoken> second_;
  std::deque<double> lately_;  ///< differences in the last seconds
  std::optional<double> told_;
};

}  // namespace ratslam
