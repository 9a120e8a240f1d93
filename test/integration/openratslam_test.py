#!/usr/bin/python3
"""OpenRatSLAM's launch files, as they are, with our executables and a bag under the data set's root."""
import os
import sys

import rostest
from ratslam_ros.msg import TopologicalMap

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import harness  # noqa: E402  (lies beside this file)

LAUNCH_FILES = os.path.join(os.path.dirname(os.path.realpath(__file__)), "openratslam")


class OpenRatSlam(harness.FolderTest):
    def setUp(self):
        super().setUp()
        os.environ["ROS_HOME"] = self.folder  # where rosbag record of the launch files writes

    def check(self, launch_file, root, size, with_odometry):
        maps = self.collected(root + "/ExperienceMap/Map", TopologicalMap)
        launch = self.keep(harness.launch(os.path.join(LAUNCH_FILES, launch_file)))
        bag = self.path("drive.bag")
        harness.write_bag(bag, root, 40, compressed=True, size=size,
                          odometry_period_ns=50000000 if with_odometry else None)
        self.keep(harness.Process(["rosbag", "play", "--clock", "--wait-for-subscribers", "--delay", "3", bag]))
        self.assertTrue(harness.wait_until(lambda: maps and maps[-1].node_count > 1, 60.0), launch.output())
        self.assertEqual(launch.count("FATAL"), 0, launch.output())

    def test_st_lucia(self):
        self.check("openratslam_stlucia.launch", "/stlucia", (640, 480), with_odometry=False)

    def test_irat(self):
        self.check("openratslam_irataus.launch", "/irat_red", (416, 240), with_odometry=True)

    def test_oxford_new_college(self):
        self.check("openratslam_newcollege.launch", "/newcollege", (512, 128), with_odometry=True)


if __name__ == "__main__":
    rostest.rosrun("ratslam_ros", "openratslam", OpenRatSlam, sys.argv)
