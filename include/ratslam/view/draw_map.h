/// Picture of the experience map from above: driven links, links by recall, the robot, a bar of known length.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "ratslam/experience_map/experience_graph.h"

namespace ratslam {

/// The whole map as large as it fits, x to the right and y up.
/// @param robot  its pose in the map
cv::Mat drawMap(const ExperienceGraph& graph, const MapPose& robot, const cv::Size& size);

}  // namespace ratslam
