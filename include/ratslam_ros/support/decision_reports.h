/// Log messages of the map's node about decisions of the pose cells that it could not carry out unchanged.
#pragma once

#include <cstddef>

#include "ratslam/system/map_stage.h"
#include "ratslam_ros/support/counted_warning.h"

namespace ratslam {

class DecisionReports {
 public:
  /// To be called after every drain. Reports refused decisions, experiences that had to be created again, and geometry
  /// that was forgotten because no decision came.
  void report(MapStage& stage);
  void timeWentBack();

  std::size_t refused() const { return refused_.count(); }

 private:
  CountedWarning refused_;
  CountedWarning recreated_;
  CountedWarning forgotten_{60.0};
  CountedWarning time_went_back_;
};

}  // namespace ratslam
