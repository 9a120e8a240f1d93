#include "ratslam_ros/support/decision_reports.h"

namespace ratslam {

std::vector<Stamp> DecisionReports::drain(MapStage& stage, Passing which) {
  const std::size_t recreated = stage.recreated();
  const std::vector<Stamp> processed = stage.drain(which);
  for (const std::string& why : stage.takeRefusals()) {
    refused_.report("decision of the pose cells dropped: " + why);
  }
  recreated_.reportIncrease("the pose cells know an experience that this map does not: it is made anew",
                            recreated, stage.recreated());
  if (forgotten_.count() < stage.forgottenGeometry()) {
    forgotten_.report(
        "recall geometry forgotten, no decision of the pose cells has asked for it: they are silent",
        stage.forgottenGeometry());
  }
  return processed;
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
