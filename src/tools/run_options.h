// The command line of ratslam_run.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ratslam/system/pipeline.h"
#include "recordings.h"

namespace ratslam {

struct RunOptions {
  std::string input;
  std::string config;
  std::string out;
  std::string odometry;
  std::string
      calibration;    ///< file of the camera's intrinsics; empty: those of the recording or configuration
  std::string video;  ///< file to write; empty: none
  std::size_t pose_cells_every = 0;  ///< views from one snapshot to the next; 0: none
  std::string pose_cells_at;         ///< times of snapshots [s]; empty: at equal distances
  std::vector<std::string> assignments;
  std::string changes;
  std::size_t max_frames = 0;  ///< 0: all
  std::size_t from_frame = 0;  ///< number of images to skip
  std::string save_map;        ///< map file to write at the end; empty: none
  bool localise_only = false;  ///< learn nothing
  std::string load_map;        ///< map file to continue; empty: none
  RecordingOptions recording;
  int decode_threads = 2;
};

/// @return nullopt if the user only asked for help, which has been printed
/// @throws std::exception saying what is wrong
std::optional<RunOptions> parseRunOptions(int argc, char** argv);

/// Checks that the output files, which replace old files, do not include any input of the run.
/// @throws std::invalid_argument naming both
void requireOutputsApart(const RunOptions& options);

}  // namespace ratslam
