/// The protocol of dynamic_reconfigure, from descriptions that parameter structs give: names, bounds and meanings are written
/// once, in visitFields, so that there is no .cfg beside them.
///
/// A request with an unknown name, or with a value that is not allowed, is refused as a whole; nothing is clamped.
/// Parameters on the server stay as they were: a node that starts again starts as it was configured.
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
  bool whole = false;  ///< int, else double
  double value = 0.0;
  Bounds bounds;
  std::string meaning;
};

/// A number as a configuration would have it, to the last bit.
std::string numberText(double number, bool whole);

class ReconfigureServer {
 public:
  /// Gets the texts of what is to change. @throws std::invalid_argument to refuse
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
