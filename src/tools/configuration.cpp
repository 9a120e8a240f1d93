#include "configuration.h"

#include <iostream>
#include <stdexcept>

#include "ratslam_ros/support/system_keys.h"

namespace ratslam {

ParameterMap readConfiguration(const std::string& program, const std::string& file,
                               const std::vector<std::string>& assignments) {
  if (file.empty() && assignments.empty()) {
    // The defaults are OpenRatSLAM's: a template of one block, which cannot distinguish places.
    throw std::invalid_argument(
        "--config FILE is missing; the package's folder config/ holds some to begin with");
  }
  ParameterMap map;
  std::vector<std::string> remarks;
  if (!file.empty()) map = ParameterMap::fromFile(file, &remarks);
  for (const std::string& remark : remarks) std::cout << program << ": " << remark << '\n';
  for (const std::string& assignment : assignments) map.setFromAssignment(assignment);
  if (map.values().empty()) throw std::runtime_error(file + ": it holds no parameter");
  map.rejectUnknown(systemKeys());
  // Every value is checked, also those that only another program uses.
  NodeParams nodes;
  map.read(nodes);
  PipelineParams::fromMap(map);
  return map;
}

}  // namespace ratslam
