// The view events that OpenRatSLAM's own arithmetic gives on a real drive.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <vector>

#include "ratslam/local_view/local_view_cells.h"
#include "test_data.h"

namespace ratslam {
namespace {

struct ReferenceEvent {
  int frame = 0;
  std::uint32_t id = 0;
  double error = 0.0;
  double relative_rad = 0.0;
};

std::vector<ReferenceEvent> readReference(const std::string& name) {
  std::ifstream file(dataFolder() / "openratslam_reference" / name);
  std::vector<ReferenceEvent> events;
  std::string line;
  std::getline(file, line);  // names of the columns
  while (std::getline(file, line)) {
    std::istringstream fields(line);
    ReferenceEvent event;
    char comma = 0;
    fields >> event.frame >> comma >> event.id >> comma >> event.error >> comma >> event.relative_rad;
    events.push_back(event);
  }
  return events;
}

// Decoding dominates: both configurations see each image once.
TEST(LocalViewReference, EventsEqualOpenRatSlamOnKitti) {
  const std::vector<ReferenceEvent> forward = readReference("local_view_forward.csv");
  const std::vector<ReferenceEvent> panoramic = readReference("local_view_panoramic.csv");
  if (forward.empty() || panoramic.empty() || kittiImage(0).empty()) {
    GTEST_SKIP() << "no reference data in " << dataFolder();
  }
  ASSERT_EQ(forward.size(), 1700U);
  ASSERT_EQ(panoramic.size(), 1700U);
  LocalViewCells forward_cells(forwardReference());
  LocalViewCells panoramic_cells(panoramicReference());
  for (std::size_t i = 0; i < forward.size(); ++i) {
    const cv::Mat image = kittiImage(forward[i].frame);
    for (const bool is_panoramic : {false, true}) {
      const ReferenceEvent& expected = is_panoramic ? panoramic[i] : forward[i];
      const ViewEvent event =
          (is_panoramic ? panoramic_cells : forward_cells).observe(forward[i].frame, image);
      ASSERT_EQ(event.id, expected.id) << "frame " << i << ", panoramic " << is_panoramic;
      ASSERT_NEAR(event.error, expected.error, 1e-9) << "frame " << i << ", panoramic " << is_panoramic;
      ASSERT_NEAR(event.relative_rad, expected.relative_rad, 1e-9)
          << "frame " << i << ", panoramic " << is_panoramic;
    }
  }
}

}  // namespace
}  // namespace ratslam
