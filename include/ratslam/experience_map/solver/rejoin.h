/// What lies beyond a way that nobody measured goes to where a recall says it is.
///
/// An odometry that was silent for a while leaves constraints so loose that the robot may be anywhere, turned any
/// way. The recall that says where it is then disagrees so strongly that Cauchy's kernel all but switches it off,
/// and no descent from there finds the map in which everything agrees. So the nodes beyond the loose constraints
/// are moved as one body to where the recall fits, if that lowers the energy of all that joins the two sides: a
/// wrong recall is outvoted as soon as there are more right ones.
#pragma once

#include "ratslam/experience_map/solver/pose_graph.h"

namespace ratslam {

/// @param recall  the newest constraint of the graph
/// @return whether nodes were moved
bool rejoin(PoseGraph& graph, const Constraint& recall);

}  // namespace ratslam
