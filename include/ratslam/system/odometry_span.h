/// Whether odometry and images are of one time: clocks that differ by a second or by hours leave no map, and
/// whoever made the recording should hear by how much.
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

  /// How many views lie before the first sample of odometry or after the last.
  std::size_t viewsOutside() const;
  /// "812 of 900 images lie outside the odometry's time: it is 3600.2 s behind"; none where all lie inside
  std::optional<std::string> complaint() const;

  /// What it knows, for common/state.h.
  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("views", views_);
    fields("first", first_);
    fields("last", last_);
  }

 private:
  std::vector<Stamp> views_;
  std::optional<Stamp> first_;
  std::optional<Stamp> last_;
};

}  // namespace ratslam
