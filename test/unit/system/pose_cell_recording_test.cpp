/// The activity of the pose cells over a drive, in a file of bounded size.
#include "ratslam/system/pose_cell_recording.h"

#include <gtest/gtest.h>

#include <sstream>

#include "ratslam/pose_cells/network.h"

namespace ratslam {
namespace {

TEST(PoseCellRecording, KeepsWhatFitsAndCountsTheRest) {
  PoseCellParams params;
  const PoseCellNetwork cells(params);
  const std::uint64_t snapshot = sizeof(float) * static_cast<std::uint64_t>(params.n_xy) *
                                 static_cast<std::uint64_t>(params.n_xy) *
                                 static_cast<std::uint64_t>(params.n_th);
  PoseCellRecording recording(2, 3 * snapshot);
  for (Stamp stamp = 0; stamp < 12; ++stamp) recording.add(stamp, cells.activity());
  EXPECT_EQ(recording.size(), 3U);
  EXPECT_EQ(recording.leftOut(), 3U) << "every second one of twelve was offered";
  std::ostringstream file;
  recording.write(file);
  EXPECT_EQ(file.str().substr(0, 2), "PK") << "a zip file";
  EXPECT_NE(file.str().find("(3, 36, "), std::string::npos) << "shape of the kept ones";
}

}  // namespace
}  // namespace ratslam
