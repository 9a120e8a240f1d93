/// Checks that odometry and images cover the same time. If their clocks differ, nothing is mapped; the complaint then
/// states the difference.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ratslam/common/stamp.h"

namespace ratslam {

class OdometrySpan {
 public:
  void addView(Stamp stamp) { views_.push_back(stamp); }
  void addOdometry(Stamp stamp);

  /// To be called at the end.
  /// @param images  stamps of images that still wait for odometry and have no view event yet
  /// @param views   stamps of view events that still wait for odometry; addView has been called for them
  /// @param dropped  number of images that were dropped because the odometry never reached them
  void end(const std::vector<Stamp>& images, const std::vector<Stamp>& views, std::size_t dropped);

  /// Number of views outside the time from the first to the last sample of odometry, and of those inside that never
  /// reached the map.
  std::size_t viewsOutside() const { return outside() + left_inside_; }
  /// "812 of 900 images lie outside the odometry's time: it is 3600.2 s behind", "45 of 60 images were never mapped:
  /// ..."; none if all lie inside and were mapped
  std::optional<std::string> complaint() const;

  /// For common/state.h.
  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("views", views_);
    fields("first", first_);
    fields("last", last_);
  }

 private:
  bool isOutside(Stamp view) const { return !first_ || view < *first_ || view > *last_; }
  std::size_t outside() const;
  std::optional<std::string> complaintOfOutside() const;

  std::vector<Stamp> views_;
  std::optional<Stamp> first_;
  std::optional<Stamp> last_;
  std::size_t left_inside_ = 0;  ///< not saved, because nothing is added after end()
};

}  // namespace ratslam
