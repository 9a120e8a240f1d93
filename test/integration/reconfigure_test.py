#!/usr/bin/python3
"""Thresholds and gains changed while the nodes run: every change is in the outputs with its stamp, so that a run without ROS
that knows the changes leaves the same bytes. What sizes depend on, and what is not allowed, is refused."""
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

import dynamic_reconfigure.client
import rospy
import rostest
from dynamic_reconfigure.msg import Config, IntParameter
from dynamic_reconfigure.srv import Reconfigure
from ratslam_ros.msg import ParameterChange

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import harness  # noqa: E402  (lies beside this file)

FRAMES = 150


class Reconfiguration(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.config, self.bag = os.path.join(self.folder, "config.yaml"), os.path.join(self.folder, "drive.bag")
        harness.write_config(self.config)
        harness.write_bag(self.bag, "/drive", FRAMES)
        self.launch = None

    def tearDown(self):
        if self.launch:
            self.launch.interrupt(30.0)
        shutil.rmtree(self.folder)

    def start(self, **arguments):
        arguments = {"config": self.config, "topic_root": "drive", **arguments}
        words = [f"{key}:={value}" for key, value in arguments.items()]
        self.launch = harness.Process(["roslaunch", "ratslam_ros", "ratslam.launch", *words])

    def offline(self, name, *options):
        out = os.path.join(self.folder, name)
        subprocess.run([harness.executable("ratslam_run"), self.bag, "--config", self.config, "--out", out, *options],
                       check=True, stdout=subprocess.DEVNULL)
        return self.contents(os.path.join(out, "trajectory"))

    def contents(self, path):
        found = []
        for kind in ("online", "final"):
            with open(f"{path}_{kind}.tum", "rb") as file:
                found.append(file.read())
        return found

    def test_a_run_with_changes_is_repeated_to_the_byte(self):
        told, played = [], []
        rospy.Subscriber("/drive/ParameterChange", ParameterChange, told.append)
        rospy.Subscriber("/drive/camera/image", rospy.AnyMsg, played.append)
        self.start(bag=self.bag, rate=1.5, trajectory_file=os.path.join(self.folder, "nodes"))
        clients = {node: dynamic_reconfigure.client.Client(node, timeout=30.0)
                   for node in ("ratslam_lv", "ratslam_pc", "ratslam_em")}
        self.assertTrue(harness.wait_until(lambda: len(played) > 20, 60.0), self.launch.output())
        clients["ratslam_lv"].update_configuration({"vt_match_threshold": 0.008})
        clients["ratslam_pc"].update_configuration({"pc_vt_inject_energy": 0.4, "exp_delta_pc_threshold": 0.6})
        self.assertTrue(harness.wait_until(lambda: len(played) > 60, 60.0), self.launch.output())
        clients["ratslam_lv"].update_configuration({"vt_match_threshold": 0.05})
        clients["ratslam_em"].update_configuration({"exp_recall_kernel": 4.0})
        self.assertEqual(self.launch.ended(120.0), 0, self.launch.output())

        changes = os.path.join(self.folder, "nodes_changes.csv")
        with open(changes, encoding="utf-8") as file:
            lines = file.read().splitlines()
        self.assertEqual(lines[0], "after_ns,name,value")
        self.assertEqual(len(lines), 1 + 5)
        self.assertEqual(sorted(lines[1:]), sorted(f"{c.header.stamp.to_nsec()},{c.name},{c.value}" for c in told))
        nodes = self.contents(os.path.join(self.folder, "nodes"))
        self.assertEqual(self.offline("same", "--changes", changes), nodes)
        self.assertNotEqual(self.offline("unchanged"), nodes)

    def test_what_may_not_change_is_refused_and_said(self):
        self.start()
        client = dynamic_reconfigure.client.Client("ratslam_pc", timeout=30.0)
        self.assertEqual({p["name"] for p in client.get_parameter_descriptions()},
                         {"pc_global_inhib", "pc_vt_inject_energy", "vt_active_decay", "pc_vt_restore", "exp_delta_pc_threshold"})
        ask = rospy.ServiceProxy("/ratslam_pc/set_parameters", Reconfigure)
        with self.assertRaises(rospy.ServiceException):
            ask(Config(ints=[IntParameter("pc_dim_xy", 30)]))
        self.assertTrue(self.launch.said("pc_dim_xy: it cannot be changed while the node runs"), self.launch.output())
        with self.assertRaises(rospy.ServiceException):
            ask(Config(ints=[IntParameter("pc_global_inhib", 2)]))
        self.assertTrue(self.launch.said(r"pc_global_inhib: value 2 is not allowed"), self.launch.output())
        self.assertEqual(client.get_configuration()["pc_global_inhib"], 0.00002)


if __name__ == "__main__":
    rospy.init_node("reconfigure_test")
    rostest.rosrun("ratslam_ros", "reconfigure", Reconfiguration, sys.argv)
