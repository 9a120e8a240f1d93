/// Loop closure after an unmeasured stretch of the path.
///
/// While the odometry is silent, the chain gets constraints so loose that the robot may be anywhere, with any
/// heading. The recall after that disagrees so strongly that Cauchy's kernel all but switches it off. Descent
/// from there cannot reach the map in which everything agrees. So rejoin() moves the nodes beyond the loose
/// constraints as one rigid body to where the recall fits, if that lowers the energy of all constraints between
/// the two sides. A wrong recall is undone in the same way as soon as more recalls contradict it.
#pragma once

#include "ratslam/experience_map/solver/pose_graph.h"

namespace ratslam {

/// @param recall  the newest constraint of the graph
/// @return whether nodes were moved
bool rejoin(PoseGraph& graph, const Constraint& recall);

}  // namespace ratslam
