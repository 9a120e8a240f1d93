/// The relaxation against what OpenRatSLAM computes from the same odometry and the same decisions.
#include <gtest/gtest.h>

#include "recorded_drive.h"

namespace ratslam {
namespace {

TEST(ReferenceMap, RelaxationIsOpenRatSlams) {
  const auto experiences = readTable(dataFolder() + "/openratslam_reference/experiences.csv");
  const auto links = readTable(dataFolder() + "/openratslam_reference/links.csv");
  if (experiences.size() < 2) GTEST_SKIP() << "no reference run in " << dataFolder();

  ExperienceMapParams params;
  params.exp_solver = "relaxation";
  params.exp_loops = 20;
  ExperienceMap map(params);
  run(map, readReferenceDrive());

  ASSERT_EQ(map.graph().experiences().size(), experiences.size());
  for (std::uint32_t id = 0; id < experiences.size(); ++id) {
    const MapPose& pose = map.graph().pose(id);
    ASSERT_NEAR(pose.x, experiences[id][1], 1e-6) << "experience " << id;
    ASSERT_NEAR(pose.y, experiences[id][2], 1e-6) << "experience " << id;
    ASSERT_NEAR(wrapAngle(pose.yaw - experiences[id][3]), 0.0, 1e-6) << "experience " << id;
  }
  ASSERT_EQ(map.graph().links().size(), links.size());
  for (std::size_t id = 0; id < links.size(); ++id) {
    const Link& link = map.graph().links()[id];
    ASSERT_EQ(link.from, static_cast<std::uint32_t>(links[id][1])) << "link " << id;
    ASSERT_EQ(link.to, static_cast<std::uint32_t>(links[id][2])) << "link " << id;
    ASSERT_NEAR(link.distance, links[id][3], 1e-6) << "link " << id;
    ASSERT_NEAR(wrapAngle(link.heading_rad - links[id][4]), 0.0, 1e-6) << "link " << id;
    ASSERT_NEAR(wrapAngle(link.facing_rad - links[id][5]), 0.0, 1e-6) << "link " << id;
    ASSERT_NEAR(link.duration_s, links[id][6], 1e-6) << "link " << id;
  }
}

}  // namespace
}  // namespace ratslam
