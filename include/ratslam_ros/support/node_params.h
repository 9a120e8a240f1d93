/// Parameters that belong to ROS and not to a model: topics, frames, queues, timeouts, output files.
///
/// All nodes read one shared configuration. So one struct describes these keys for all nodes; the structs of
/// the models describe the models' keys.
#pragma once

#include <string>

#include "ratslam/common/params.h"

namespace ratslam {

struct NodeParams {
  std::string topic_root;  ///< namespace of the data set, with or without outer slashes
  std::string image_transport = "raw";
  std::string stamp_source = "header";
  int image_queue_size = 2;   ///< [images]; 0: no bound
  double sync_timeout = 5.0;  ///< [s] of wall time
  int wait_for_subscribers = 0;
  bool publish_tf = true;
  std::string map_frame = "map";
  std::string odom_frame;
  std::string base_frame = "base_link";
  double map_period = 1.0;      ///< [s] of wall time
  double map_line_width = 0.2;  ///< [m]
  std::string decision_source = "auto";
  std::string trajectory_file;
  std::string trajectory_format = "tum";
  std::string map_dir;
  double autosave_period = 5.0;  ///< [s] of message time
  bool localise_only = false;

  template <class Visitor>
  void visitFields(Visitor&& visit) {
    const Bounds any;
    visit("topic_root", topic_root, any, "namespace of the data set's topics; empty: the node's namespace");
    visit("image_transport", image_transport, any,
          "raw, or compressed (decoded by the node, no plugin needed)");
    visit("stamp_source", stamp_source, any,
          "stamps of images: header, or arrival for cameras that do not stamp (results then depend on the "
          "machine and cannot be repeated)");
    visit("image_queue_size", image_queue_size, Bounds{0, 1000000},
          "images that may wait; the oldest are dropped, counted and reported; 0: no bound");
    visit("sync_timeout", sync_timeout, Bounds{0.01, 3600.0},
          "wall time after which an input no longer waits for another that is silent [s]");
    visit("wait_for_subscribers", wait_for_subscribers, Bounds{0, 1000},
          "listen to inputs only once every output has this many subscribers (gives up after 15 s); "
          "ratslam_em, the "
          "last node, does not wait");
    visit("publish_tf", publish_tf, any,
          "broadcast map -> odom (ratslam_em) or odom -> base_link (odometries)");
    visit(
        "map_frame", map_frame, any,
        "frame of the map; empty: messages name no frame, as OpenRatSLAM's scripts expect, and no transform "
        "is broadcast");
    visit("odom_frame", odom_frame, any,
          "frame of the odometry; empty: that of an external odometry's messages, odom for ours");
    visit("base_frame", base_frame, any, "frame of the robot");
    visit("map_period", map_period, Bounds{0.0, 3600.0},
          "least time between two publications of a changed map, in wall time [s]");
    visit("map_line_width", map_line_width, Bounds{1e-6, 1e6},
          "width of the links in ExperienceMap/MapMarker [m]");
    visit("decision_source", decision_source, any,
          "what the map follows: state (PoseCell/State), action (PoseCell/TopologicalAction) or auto "
          "(state where it is published)");
    visit("trajectory_file", trajectory_file, any,
          "write trajectories here on shutdown: FILE_online.tum and FILE_final.tum; empty: none");
    visit("trajectory_format", trajectory_format, any, "tum or kitti");
    visit(
        "map_dir", map_dir, any,
        "folder in which each node keeps checkpoints of what it has learned, and goes on from; empty: none");
    visit("autosave_period", autosave_period, Bounds{0.1, 86400.0},
          "time between checkpoints, in message time [s]");
    visit("localise_only", localise_only, any,
          "learn nothing and leave map_dir as it is: only localise in the map");
  }

  /// Frame of the odometry. @param in_messages frame that the odometry's messages name; may be empty
  std::string odomFrame(const std::string& in_messages = "") const;

  /// @throws std::invalid_argument naming key, value and what is allowed
  void validate() const;
};

}  // namespace ratslam
