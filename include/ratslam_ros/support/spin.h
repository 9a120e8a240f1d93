/// Spinning for nodes that still have something to publish when they are asked to end.
#pragma once

namespace ratslam {

/// Like ros::spin, but an interrupt (SIGINT, which roslaunch sends to end a node) leaves the connections
/// open, so that the caller can publish and write what it has. Needs ros::init_options::NoSigintHandler.
void spinUntilInterrupted();

}  // namespace ratslam
