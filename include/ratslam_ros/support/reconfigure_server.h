/// Server of the dynamic_reconfigure protocol. Names, bounds and meanings come from the parameter structs' visitFields,
/// so no .cfg file is needed.
///
/// A request with an unknown name, or with a value that is not allowed, is refused as a whole; nothing is clamped. The
/// parameters on the parameter server are not changed: a restarted node has its configured values.
#pragma once

#include <dynamic_reconfigure/Config.h>
#include <dynamic_reconfigure/Reconfigure.h>
#include <ros/node_handle.h>

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "ratslam/common/params.h"

namespace ratslam {

struct ReconfigurableField {
  std::string name;
  bool whole = false;  ///< true: int, false: double
  double value = 0.0;
  Bounds bounds;
  std::string meaning;
};

/// Text of a number that gives the same bits when read.
std::string numberText(double number, bool whole);

class ReconfigureServer {
 public:
  /// Receives names and texts of the new values. @throws std::invalid_argument to refuse them
  using Apply = std::function<void(const std::map<std::string, std::string>&)>;

  /// @param own  handle of the node's private names
  ReconfigureServer(const ros::NodeHandle& own, std::vector<ReconfigurableField> fields, Apply apply);

 private:
  bool onRequest(dynamic_reconfigure::ReconfigureRequest& request,
                 dynamic_reconfigure::ReconfigureResponse& response);
  void publishDescription();
  using Property = double (*)(const ReconfigurableField&);
  dynamic_reconfigure::Config config(Property property) const;

  ros::NodeHandle own_;
  std::vector<ReconfigurableField> fields_;
  Apply apply_;
  ros::Publisher description_;
  ros::Publisher updates_;
  ros::ServiceServer service_;
};

}  // namespace ratslam
