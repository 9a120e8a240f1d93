#include "ratslam/experience_map/params.h"

#include <string>

namespace ratslam {
namespace {

constexpr int kLeastPoses = 1000;  // corrections of the odometry need the newest poses

}  // namespace

void ExperienceMapParams::validate() const {
  checkBounds(*this);
  if (exp_solver != "graph" && exp_solver != "relaxation") {
    throwBadValue("exp_solver", exp_solver, "it must be graph or relaxation");
  }
  if (exp_trajectory_poses > 0 && exp_trajectory_poses < kLeastPoses) {
    throwBadValue("exp_trajectory_poses", exp_trajectory_poses,
                  "it must be 0 or at least " + std::to_string(kLeastPoses));
  }
  if (relaxes() && exp_scale) {
    throwBadValue("exp_scale", exp_scale, "only exp_solver graph carries scale");
  }
  if (relaxes() && exp_height) {
    throwBadValue("exp_height", exp_height, "only exp_solver graph carries height");
  }
}

}  // namespace ratslam
