#!/usr/bin/python3
"""A run is a function of the bag and the parameters: playback speed is not among its arguments."""
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

import rostest

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import harness  # noqa: E402  (lies beside this file)

FRAMES = 110


class Playback(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp()
        cls.config = os.path.join(cls.folder, "config.yaml")
        harness.write_config(cls.config)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    def path(self, name):
        return os.path.join(self.folder, name)

    def play(self, bag, rate, **arguments):
        """Trajectory files of one playback through roslaunch, as bytes: online and final."""
        out = self.path(f"{os.path.basename(bag)}_{rate}")
        arguments = {"bag": bag, "rate": rate, "config": self.config, "topic_root": "drive", "trajectory_file": out, **arguments}
        launch = harness.Process(["roslaunch", "ratslam_ros", "ratslam.launch", *(f"{k}:={v}" for k, v in arguments.items())])
        self.assertEqual(launch.ended(120.0), 0, launch.output())
        self.assertIn("the map has processed the last image", launch.output())
        contents = []
        for kind in ("online", "final"):
            with open(f"{out}_{kind}.tum", "rb") as file:
                contents.append(file.read())
        return contents

    def run_offline(self, bag, odometry):
        out = self.path("offline_" + os.path.basename(bag))
        subprocess.run([harness.executable("ratslam_run"), bag, "--config", self.config, "--out", out, "--odometry", odometry],
                       check=True, stdout=subprocess.DEVNULL)
        contents = []
        for kind in ("online", "final"):
            with open(f"{out}/trajectory_{kind}.tum", "rb") as file:
                contents.append(file.read())
        return contents

    def test_profile_odometry_at_every_rate_and_offline(self):
        bag = self.path("images.bag")
        harness.write_bag(bag, "/drive", FRAMES, compressed=True)
        reference = self.play(bag, 5, compressed="true")
        self.assertEqual(reference[1].count(b"\n"), FRAMES)
        self.assertEqual(self.play(bag, 1, compressed="true"), reference)
        self.assertEqual(self.play(bag, 20, compressed="true"), reference)
        self.assertEqual(self.run_offline(bag, "profile"), reference)

    def test_odometry_stamped_between_the_images_at_every_rate_and_offline(self):
        bag = self.path("odometry.bag")
        harness.write_bag(bag, "/drive", FRAMES, odometry_period_ns=37000000)
        reference = self.play(bag, 5, odometry="external")
        self.assertEqual(self.play(bag, 20, odometry="external"), reference)
        self.assertEqual(self.run_offline(bag, "topic"), reference)


if __name__ == "__main__":
    rostest.rosrun("ratslam_ros", "playback", Playback, sys.argv)
