/// Picture of the experience map from above: driven links, links by recall, the robot, and a scale bar.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "ratslam/experience_map/experience_graph.h"

namespace ratslam {

/// Draws the whole map as large as possible, x to the right and y up.
/// @param robot  its pose in the map
cv::Mat drawMap(const ExperienceGraph& graph, const MapPose& robot, const cv::Size& size);

}  // namespace ratslam
