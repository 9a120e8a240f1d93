/// Log messages of the map's node about decisions of the pose cells that it could not carry out unchanged.
#pragma once

#include "ratslam/system/map_stage.h"
#include "ratslam_ros/support/counted_warning.h"
#include "ratslam_ros/support/node_diagnostics.h"

namespace ratslam {

class DecisionReports {
 public:
  /// Drains the stage. Reports refused decisions, experiences that had to be created again, and geometry that was
  /// forgotten because no decision came. @return stamps of the processed decisions
  std::vector<Stamp> drain(MapStage& stage, Passing which);
  void timeWentBack();

  /// Size of the map, and numbers of decisions that wait and that were refused.
  void describe(DiagnosticStatus& status, const MapStage& stage) const;

 private:
  CountedWarning refused_;
  CountedWarning recreated_;
  CountedWarning forgotten_{60.0};
  CountedWarning time_went_back_;
};

}  // namespace ratslam
