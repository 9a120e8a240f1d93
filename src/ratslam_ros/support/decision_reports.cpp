#include "ratslam_ros/support/decision_reports.h"

namespace ratslam {

void DecisionReports::report(MapStage& stage) {
  for (const std::string& why : stage.takeRefusals()) {
    refused_.report("decision of the pose cells dropped: " + why);
  }
  while (recreated_.count() < stage.recreated()) {
    recreated_.report("the pose cells know an experience that this map does not: it is made anew");
  }
  if (forgotten_.count() < stage.forgottenGeometry()) {
    forgotten_.report(
        "recall geometry forgotten, no decision of the pose cells has asked for it: they are silent",
        stage.forgottenGeometry());
  }
}

void DecisionReports::timeWentBack() {
  time_went_back_.report("time went back in the decisions of the pose cells: their stream starts anew");
}

void DecisionReports::describe(DiagnosticStatus& status, const MapStage& stage) const {
  describeMap(status, stage.map().graph());
  status.add("decisions that wait", stage.waitingDecisions());
  status.add("decisions refused", refused_.count());
}

}  // namespace ratslam
