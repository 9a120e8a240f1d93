/// The services of the map's node, which act on all parts of the system that keep a share of the map: local view
/// and pose cells are asked by services of their own (PartCommand).
///
///     ExperienceMap/SaveMap             MapPath   one map file of all parts; an empty path: checkpoints now
///     ExperienceMap/LoadMap             MapPath   all parts go on in that map, on a new stretch
///     ExperienceMap/Reset               Trigger   all parts forget everything
///     ExperienceMap/Pause               SetBool   nothing is learned or recalled; odometry is followed
///     ExperienceMap/LocaliseOnly        SetBool   nothing is learned
///     ExperienceMap/WriteTrajectories   Trigger   to trajectory_file
///     ExperienceMap/SaveTrajectories    MapPath   to another name
///
/// Each answers in one line what it did, or why it did not.
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
  /// Writes trajectories. @return what to say
  using Write = std::function<std::string(const std::string& file)>;

  /// @param own  the map's own part
  MapServices(const ros::NodeHandle& handle, const NodeParams& params, PartCommands& own, Write write);

 private:
  using Request = PartCommands::Request;

  /// A service that answers with what `action` returns, or with what it throws.
  template <class Service>
  void advertise(const char* name, std::function<std::string(typename Service::Request&)> action);
  void advertiseAll();

  std::string saveMap(const std::string& path);
  std::string loadMap(const std::string& path);
  /// Sends a command to every part. @return their names
  std::string toAll(const Request& request);
  /// Services of the other parts. @throws std::runtime_error naming those that nobody offers
  std::vector<std::string> others() const;
  static void send(const std::string& service, const Request& request);

  ros::NodeHandle handle_;
  NodeParams params_;
  PartCommands& own_;
  Write write_;
  std::vector<ros::ServiceServer> servers_;
};

}  // namespace ratslam
