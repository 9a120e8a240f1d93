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
/// Each answers in one line what it has done, or why it has not.
#pragma once

#include <ros/node_handle.h>

#include <functional>
#include <string>
#include <vector>

#include "ratslam_ros/MapPath.h"
#include "ratslam_ros/support/node_params.h"
#include "ratslam_ros/support/part_commands.h"

namespace ratslam {

class MapServices {
 public:
  using IsEmpty = std::function<bool()>;  ///< whether nothing is mapped
  /// Writes trajectories. @return text of the answer
  using Write = std::function<std::string(const std::string& file)>;

  /// @param own  the map's own part
  MapServices(const ros::NodeHandle& handle, const NodeParams& params, PartCommands& own, IsEmpty is_empty,
              Write write);

 private:
  using Request = PartCommands::Request;

  /// Offers a service that answers with the result of `action`, or with the message of its exception.
  template <class Service>
  void advertise(const char* name, std::function<std::string(typename Service::Request&)> action);
  void advertiseAll();

  /// @throws std::runtime_error if nothing is mapped, so that no empty file is written as a success
  void requireMap() const;
  std::string saveMap(const std::string& path);
  std::string loadMap(const std::string& path);
  /// Sends a command to every part. @return their names
  std::string toAll(const Request& request);
  /// Services of the other parts. @throws std::runtime_error naming those that are not offered
  std::vector<std::string> others() const;
  static void send(const std::string& service, const Request& request);

  ros::NodeHandle handle_;
  NodeParams params_;
  PartCommands& own_;
  IsEmpty is_empty_;
  Write write_;
  std::vector<ros::ServiceServer> servers_;
};

}  // namespace ratslam
