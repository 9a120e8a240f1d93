#include "ratslam/experience_map/params.h"

namespace ratslam {

void ExperienceMapParams::validate() const {
  checkBounds(*this);
  if (exp_solver != "graph" && exp_solver != "relaxation") {
    throwBadValue("exp_solver", exp_solver, "it must be graph or relaxation");
  }
  if (relaxes() && exp_scale) {
    throwBadValue("exp_scale", exp_scale, "only exp_solver graph carries scale");
  }
  if (relaxes() && exp_height) {
    throwBadValue("exp_height", exp_height, "only exp_solver graph carries height");
  }
}

}  // namespace ratslam
