/// The default solver of the experience map under a simulated drive, with its pose graph in reach.
#pragma once

#include "oracle/experience_map_drive.h"
#include "ratslam/experience_map/solver/pose_graph_map.h"

namespace ratslam {

/// The default solver without the rest of the map, so that its pose graph is in reach.
struct DrivenPoseGraph {
  explicit DrivenPoseGraph(const ExperienceMapParams& params) : solver(params) {}

  /// Takes in one step of a drive; the solver does not work on it yet.
  void take(const DriveStep& step) {
    robot.motion.add(step.motion);
    if (step.action.kind == ActionKind::kCreateNode) {
      const bool first = graph.experiences().empty();
      graph.addExperience(first ? MapPose{}
                                : compose(solver.framePose(graph, robot.frame), robot.motion.pose));
      robot = solver.create(graph, robot, nullptr);
    } else if (step.action.kind == ActionKind::kCreateEdge) {
      robot = solver.recall(graph, step.action.dest_id, robot, 0.0, nullptr).value_or(robot);
    }
  }

  PoseGraphMap solver;
  ExperienceGraph graph;
  RobotPlace robot;
};

}  // namespace ratslam
