#include "ratslam/local_view/recall/recall_geometry_params.h"

namespace ratslam {

void RecallGeometryParams::validate() const {
  checkBounds(*this);
  if (verify != "none" && verify != "orb") throwBadValue("vt_verify", verify, "it must be none or orb");
  if (min_inliers > features) {
    throwBadValue("vt_verify_min_inliers", min_inliers, "it must not exceed vt_verify_features");
  }
}

}  // namespace ratslam
