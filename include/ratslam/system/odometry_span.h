/// Checks that odometry and images cover the same time. If their clocks differ, there is no map; the complaint then
/// tells the user by how much they differ.
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

  /// Number of views before the first sample of odometry or after the last.
  std::size_t viewsOutside() const;
  /// "812 of 900 images lie outside the odometry's time: it is 3600.2 s behind"; none if all lie inside
  std::optional<std::string> complaint() const;

  /// For common/state.h.
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
