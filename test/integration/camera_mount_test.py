#!/usr/bin/python3
"""Where the camera sits on the robot, taken from tf: the odometry is base_link's, and the numbers that are logged give the same
run without tf, to the byte."""
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

import rospy
import rostest
import tf2_ros
from geometry_msgs.msg import TransformStamped

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import harness  # noqa: E402  (lies beside this file)

NUMBERS = ("camera_x", "camera_y", "camera_z", "camera_roll_deg", "camera_pitch_deg", "camera_yaw_deg")


class CameraMount(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp()
        cls.config = harness.demo_config()
        cls.bag = os.path.join(cls.folder, "town.bag")
        harness.write_town_bag(cls.bag)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    def offline(self, name, *options):
        out = os.path.join(self.folder, name)
        return out, subprocess.run([harness.executable("ratslam_run"), self.bag, "--config", self.config, "--odometry", "orb",
                                    "--out", out, *options], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                   check=False)

    def test_the_transform_gives_the_mount_and_its_numbers_the_same_run(self):
        broadcaster = tf2_ros.StaticTransformBroadcaster()
        transform = TransformStamped()
        transform.header.frame_id, transform.child_frame_id = "base_link", "eye_optical"
        transform.transform.translation.x, transform.transform.translation.z = 1.5, 1.2
        q = transform.transform.rotation  # looks ahead: x right, y down, z forward
        q.x, q.y, q.z, q.w = -0.5, 0.5, -0.5, 0.5
        broadcaster.sendTransform(transform)
        nodes = os.path.join(self.folder, "nodes")
        launch = harness.launch_on_town(odometry="orb", bag=self.bag, rate=4, camera_frame="eye_optical", trajectory_file=nodes)
        self.assertEqual(launch.ended(120.0), 0, launch.output())
        said = {name: re.search(name + r": ([^,\s\x1b]+)", launch.output()).group(1) for name in NUMBERS}
        self.assertEqual([float(said[name]) for name in NUMBERS[:3]], [1.5, 0.0, 1.2])
        for name in NUMBERS[3:]:
            self.assertAlmostEqual(float(said[name]), 0.0, places=9)
        same, done = self.offline("same", *(word for name in NUMBERS for word in ("--set", f"{name}={said[name]}")))
        self.assertEqual(done.returncode, 0, done.stdout)
        other, _ = self.offline("in_the_camera")
        for kind in ("online", "final"):
            with open(f"{nodes}_{kind}.tum", "rb") as a, open(f"{same}/trajectory_{kind}.tum", "rb") as b, \
                    open(f"{other}/trajectory_{kind}.tum", "rb") as c:
                by_tf, by_numbers, without = a.read(), b.read(), c.read()
            self.assertEqual(by_tf, by_numbers)
            self.assertNotEqual(by_tf, without)

    def test_a_transform_that_nobody_broadcasts_is_named(self):
        launch = harness.launch_on_town(odometry="orb", bag="", camera_frame="no_such_eye")
        try:
            self.assertTrue(launch.said(r"images wait for the transform base_link -> no_such_eye \(camera_frame\)", 30.0),
                            launch.output())
        finally:
            launch.interrupt(30.0)
        _, done = self.offline("no_tf", "--set", "camera_frame=eye")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("camera_frame: value eye is not allowed: there is no tf here", done.stdout)


if __name__ == "__main__":
    rospy.init_node("camera_mount_test")
    rostest.rosrun("ratslam_ros", "camera_mount", CameraMount, sys.argv)
