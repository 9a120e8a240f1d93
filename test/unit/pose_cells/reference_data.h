/// Real odometry, views and OpenRatSLAM's answers, where they are at hand.
#pragma once

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "ratslam/pose_cells/params.h"

namespace ratslam {

using Table = std::vector<std::vector<double>>;

/// $RATSLAM_DATA, by default beside the source tree.
inline std::string referenceFolder() {
  const char* data = std::getenv("RATSLAM_DATA");
  return std::string(data != nullptr ? data : RATSLAM_SOURCE_DIR "/../shared/data") +
         "/openratslam_reference";
}

/// Rows of numbers of a CSV file without its header; empty if there is no such file.
inline Table readTable(const std::string& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  Table table;
  while (std::getline(in, line)) {
    std::istringstream fields(line);
    std::string field;
    table.emplace_back();
    while (std::getline(fields, field, ',')) table.back().push_back(std::stod(field));
  }
  return table;
}

/// The parameters that the reference was computed with.
inline PoseCellParams referenceParams() {
  PoseCellParams params;
  params.n_xy = 30;
  params.cell_size = 2.0;
  params.experience_distance = 1.0;
  params.inject_energy = 0.15;
  params.active_decay = 1.0;
  params.restore = 0.04;
  params.openratslam_injection = true;
  return params;
}

}  // namespace ratslam
