/// Parameters of recall geometry.
#pragma once

#include <string>

#include "ratslam/common/params.h"

namespace ratslam {

struct RecallGeometryParams {
  std::string verify = "none";  ///< "none": nothing is stored or measured; "orb": ORB geometry
  int features = 500;           ///< features kept of a template; three times as many of an image
  int min_inliers = 20;         ///< matches that must agree for a recall to be confirmed
  int max_templates = 5000;     ///< templates kept: a bound on memory

  template <class Visitor>
  void visitFields(Visitor&& visit) {
    visit("vt_verify", verify, Bounds{}, "check of recalls by image geometry: none or orb");
    visit("vt_verify_features", features, Bounds{50, 5000}, "ORB features kept of a template");
    visit("vt_verify_min_inliers", min_inliers, Bounds{8, 5000},
          "feature matches that must agree for a recall to be confirmed");
    visit("vt_verify_max_templates", max_templates, Bounds{1, 1e6},
          "most templates kept with their features: a bound on memory");
  }
  bool verifies() const { return verify != "none"; }

  /// @throws std::invalid_argument naming key, value and requirement
  void validate() const;
};

}  // namespace ratslam
