#!/usr/bin/python3
"""Thresholds and gains changed while the nodes run: every change is in the outputs with its stamp, so that a run without ROS
that knows the changes leaves the same bytes. What sizes depend on, and what is not allowed, is refused."""
import os
import sys

import dynamic_reconfigure.client
import rospy
import rostest
from dynamic_reconfigure.msg import Config, DoubleParameter, IntParameter, StrParameter
from dynamic_reconfigure.srv import Reconfigure
from ratslam_ros.msg import ParameterChange

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import harness  # noqa: E402  (lies beside this file)

FRAMES = 150


class Reconfiguration(harness.FolderTest):
    def start(self, **arguments):
        self.launched = self.launch(topic_root="drive", **arguments)

    def test_a_run_with_changes_is_repeated_to_the_byte(self):
        bag, nodes = self.path("drive.bag"), self.path("nodes")
        harness.write_bag(bag, "/drive", FRAMES)
        told = self.collected("/drive/ParameterChange", ParameterChange)
        played = self.collected("/drive/camera/image", rospy.AnyMsg)
        self.start(bag=bag, rate=1.5, trajectory_file=nodes)
        clients = {node: dynamic_reconfigure.client.Client(node, timeout=30.0)
                   for node in ("ratslam_lv", "ratslam_pc", "ratslam_em")}
        self.assertTrue(harness.wait_until(lambda: len(played) > 20, 60.0), self.launched.output())
        clients["ratslam_lv"].update_configuration({"vt_match_threshold": 0.008})
        clients["ratslam_pc"].update_configuration({"pc_vt_inject_energy": 0.4, "exp_delta_pc_threshold": 0.6})
        self.assertTrue(harness.wait_until(lambda: len(played) > 60, 60.0), self.launched.output())
        clients["ratslam_lv"].update_configuration({"vt_match_threshold": 0.05})
        clients["ratslam_em"].update_configuration({"exp_recall_kernel": 4.0})
        by_nodes = self.completed(self.launched, nodes)

        changes = nodes + "_changes.csv"
        with open(changes, encoding="utf-8") as file:
            lines = file.read().splitlines()
        self.assertEqual(lines[0], "after_ns,name,value")
        self.assertEqual(len(lines), 1 + 5)
        self.assertEqual(sorted(lines[1:]), sorted(f"{c.header.stamp.to_nsec()},{c.name},{c.value}" for c in told))
        self.assertEqual(self.offline(bag, "same", "--changes", changes), by_nodes)
        self.assertNotEqual(self.offline(bag, "unchanged"), by_nodes)

    def test_what_may_not_change_is_refused_and_said(self):
        self.start()
        client = dynamic_reconfigure.client.Client("ratslam_pc", timeout=30.0)
        self.assertEqual({p["name"] for p in client.get_parameter_descriptions()},
                         {"pc_global_inhib", "pc_vt_inject_energy", "vt_active_decay", "pc_vt_restore", "exp_delta_pc_threshold"})
        ask = rospy.ServiceProxy("/ratslam_pc/set_parameters", Reconfigure)
        with self.assertRaises(rospy.ServiceException):
            ask(Config(ints=[IntParameter("pc_dim_xy", 30)]))
        self.assertTrue(self.launched.said("pc_dim_xy: it cannot be changed while the node runs"), self.launched.output())
        with self.assertRaises(rospy.ServiceException):
            ask(Config(ints=[IntParameter("pc_global_inhib", 2)]))
        self.assertTrue(self.launched.said(r"pc_global_inhib: value 2 is not allowed"), self.launched.output())
        self.assertEqual(client.get_configuration()["pc_global_inhib"], 0.00002)
        with self.assertRaises(rospy.ServiceException):
            ask(Config(strs=[StrParameter("pc_global_inhib", "much")]))
        self.assertTrue(self.launched.said("pc_global_inhib: value 'much' is not allowed"), self.launched.output())
        dynamic_reconfigure.client.Client("ratslam_em", timeout=30.0)  # waits until the node is up
        ask = rospy.ServiceProxy("/ratslam_em/set_parameters", Reconfigure)
        with self.assertRaises(rospy.ServiceException):
            ask(Config(doubles=[DoubleParameter("exp_loops", 2.5)]))
        self.assertTrue(self.launched.said("exp_loops: value 2.5 is not allowed: a whole number"), self.launched.output())


if __name__ == "__main__":
    rostest.rosrun("ratslam_ros", "reconfigure", Reconfiguration, sys.argv)
