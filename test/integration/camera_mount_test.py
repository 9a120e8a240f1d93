#!/usr/bin/python3
"""Where the camera sits on the robot, taken from tf: the odometry is base_link's, and the numbers that are logged give the same
run without tf, to the byte."""
import os
import re
import sys

import rostest
import tf2_ros
from geometry_msgs.msg import TransformStamped

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import harness  # noqa: E402  (lies beside this file)

NUMBERS = ("camera_x", "camera_y", "camera_z", "camera_roll_deg", "camera_pitch_deg", "camera_yaw_deg")


class CameraMount(harness.FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.config = harness.demo_config()
        cls.bag = cls.path("town.bag")
        harness.write_town_bag(cls.bag)

    def test_the_transform_gives_the_mount_and_its_numbers_the_same_run(self):
        broadcaster = tf2_ros.StaticTransformBroadcaster()
        transform = TransformStamped()
        transform.header.frame_id, transform.child_frame_id = "base_link", "eye_optical"
        transform.transform.translation.x, transform.transform.translation.z = 1.5, 1.2
        q = transform.transform.rotation  # looks ahead: x right, y down, z forward
        q.x, q.y, q.z, q.w = -0.5, 0.5, -0.5, 0.5
        broadcaster.sendTransform(transform)
        launch = self.keep(harness.launch_on_town(odometry="orb", bag=self.bag, rate=4, camera_frame="eye_optical",
                                                  trajectory_file=self.path("nodes")))
        nodes = self.completed(launch, self.path("nodes"))
        said = {name: re.search(name + r": ([^,\s\x1b]+)", launch.output()).group(1) for name in NUMBERS}
        self.assertEqual([float(said[name]) for name in NUMBERS[:3]], [1.5, 0.0, 1.2])
        for name in NUMBERS[3:]:
            self.assertAlmostEqual(float(said[name]), 0.0, places=9)
        same = self.offline(self.bag, "same", "--odometry", "orb", *(word for name in NUMBERS for word in ("--set", f"{name}={said[name]}")))
        in_the_camera = self.offline(self.bag, "in_the_camera", "--odometry", "orb")
        self.assertEqual(nodes, same)
        for one, other in zip(nodes, in_the_camera):
            self.assertNotEqual(one, other)

    def test_a_transform_that_nobody_broadcasts_is_named(self):
        launch = self.keep(harness.launch_on_town(odometry="orb", bag="", camera_frame="no_such_eye"))
        self.assertTrue(launch.said(r"images wait for the transform base_link -> no_such_eye \(camera_frame\)", 30.0), launch.output())
        done = harness.offline(self.bag, self.config, self.path("no_tf"), "--odometry", "orb", "--set", "camera_frame=eye")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("camera_frame: value eye is not allowed: there is no tf here", done.stdout)


if __name__ == "__main__":
    rostest.rosrun("ratslam_ros", "camera_mount", CameraMount, sys.argv)
