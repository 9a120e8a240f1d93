/// The services of the map's node. They act on all parts of the system that hold a part of the map: the node sends
/// commands (PartCommand) to the local view and the pose cells.
///
///     ExperienceMap/SaveMap             MapPath   one map file of all parts; an empty path: checkpoints now
///     ExperienceMap/LoadMap             MapPath   all parts continue in that map; the path begins unconnected
///     ExperienceMap/Reset               Trigger   all parts forget everything
///     ExperienceMap/Pause               SetBool   nothing is learned or recalled; odometry is followed
///     ExperienceMap/LocaliseOnly        SetBool   nothing is learned
///     ExperienceMap/WriteTrajectories   Trigger   to trajectory_file
///     ExperienceMap/SaveTrajectories    MapPath   to another name
///
/// Each service answers with one line: what it has done, or why it has not. The services run in a thread of their own,
/// so that the node processes messages while they wait for other nodes. They change the node itself only in its own
/// thread. All parts are changed or saved at one message of the stream (part_calls.h).
#pragma once

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>

#include <functional>
#include <string>
#include <vector>

#include "ratslam_ros/MapPath.h"
#include "ratslam_ros/support/node_params.h"
#include "ratslam_ros/support/part_calls.h"
#include "ratslam_ros/support/part_commands.h"

namespace ratslam {

class MapServices {
 public:
  using IsEmpty = std::function<bool()>;  ///< whether nothing is mapped
  /// Writes trajectories. @return text of the answer
  using Write = std::function<std::string(const std::string& file)>;

  /// What the map has not received yet, up to the last decision (PartCalls::Behind). @param all  also what it has
  /// received but not processed
  using Behind = std::function<std::string(const StreamPoint& last, Stamp last_change, bool all)>;

  /// @param own  the map's own part
  MapServices(const ros::NodeHandle& handle, const NodeParams& params, PartCommands& own, IsEmpty is_empty,
              Write write, Behind behind);
  ~MapServices();
  MapServices(const MapServices&) = delete;
  MapServices& operator=(const MapServices&) = delete;

 private:
  using Request = PartCommands::Request;

  /// Offers a service that answers with the result of `action`, or with the message of its exception.
  template <class Service>
  void advertise(const char* name, std::function<std::string(typename Service::Request&)> action);
  void advertiseAll();

  /// Runs `action` in the node's own thread. @return its result   @throws std::runtime_error with the message of its
  /// exception
  std::string inNode(std::function<std::string()> action);
  /// @throws std::runtime_error if nothing is mapped; otherwise an empty file would be reported as a success
  void requireMap();
  std::string writeTrajectories(const std::string& file);
  std::string saveMap(const std::string& path);
  std::string loadMap(const std::string& path);
  /// Sends commands to every part while all are held, and calls `then` once all have done them. @return the names of
  /// their services   @throws std::runtime_error if a part has not done them, or was not held all the time
  std::string toAll(const std::vector<Request>& requests, const std::function<void()>& then = nullptr);
  void toOwn(const Request& request);
  /// Sets a parameter for parts that start later.
  void remember(const char* asked, bool on);
  PartCalls::Behind behind(bool all);

  ros::NodeHandle handle_;
  NodeParams params_;
  PartCommands& own_;
  IsEmpty is_empty_;
  Write write_;
  Behind behind_;
  PartCalls others_;
  ros::CallbackQueueInterface* node_queue_;
  ros::CallbackQueue queue_;
  ros::NodeHandle own_handle_;  ///< with that queue
  std::vector<ros::ServiceServer> servers_;
  ros::AsyncSpinner thread_;
};

}  // namespace ratslam
