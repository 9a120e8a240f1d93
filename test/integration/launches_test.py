#!/usr/bin/python3
"""What the launch files promise to somebody who only calls roslaunch: nothing left behind, a clean ending, his own folder."""
import os
import shutil
import signal
import sys
import tempfile
import unittest
import xmlrpc.client

import rosgraph
import rosnode
import rospy
import rostest
from sensor_msgs.msg import Image

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import harness  # noqa: E402  (lies beside this file)


class Launches(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp()
        cls.config = os.path.join(cls.folder, "config.yaml")
        harness.write_config(cls.config)
        harness.write_bag(os.path.join(cls.folder, "drive.bag"), "/drive", 30, compressed=True)
        cls.master = rosgraph.Master("/launches_test")

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    def setUp(self):
        self.launch = None

    def tearDown(self):
        if self.launch:
            self.launch.interrupt(30.0)

    def start(self, **arguments):
        """Plays the bag, named as the user's folder has it."""
        arguments = {"bag": "drive.bag", "rate": 10, "config": self.config, "topic_root": "drive", "compressed": "true",
                     **arguments}
        words = [f"{key}:={value}" for key, value in arguments.items()]
        self.launch = harness.Process(["roslaunch", "ratslam_ros", "ratslam.launch", *words], cwd=self.folder)
        return self.launch

    def test_a_playback_ends_cleanly_and_leaves_nothing_set_for_the_next(self):
        other = os.path.join(self.folder, "other.yaml")
        harness.write_config(other, exp_height="true", pc_vt_restore=0.07)
        self.assertEqual(self.start(config=other).ended(90.0), 0, self.launch.output())
        self.assertIn("the map has processed the last image", self.launch.output())
        for bad in ("REQUIRED", "has died", "Traceback", "escalating"):
            self.assertNotIn(bad, self.launch.output())
        self.assertFalse(self.master.hasParam("/use_sim_time"))

        self.assertEqual(self.start().ended(90.0), 0, self.launch.output())
        for node in ("/ratslam_em", "/ratslam_pc", "/ratslam_lv", "/ratslam_vo"):
            left = self.master.getParam(node)
            self.assertFalse({"exp_height", "pc_vt_restore"} & set(left), node)

    def test_a_live_launch_after_a_playback_drops_no_more_than_it_says(self):
        """The queue without bound of a playback is none of a camera's."""
        self.assertEqual(self.start().ended(90.0), 0, self.launch.output())
        self.start(bag="")
        self.assertTrue(harness.wait_until(lambda: "/ratslam_vo" in rosnode.get_node_names(), 30.0))
        self.assertNotIn("image_queue_size", self.master.getParam("/ratslam_lv"))
        self.assertNotIn("wait_for_subscribers", self.master.getParam("/ratslam_vo"))

    def test_a_node_that_dies_comes_back_where_it_is_asked_for(self):
        self.start(bag="", respawn="true", odometry="external")
        self.assertTrue(harness.wait_until(lambda: rosnode.rosnode_ping("/ratslam_pc", max_count=1), 30.0), self.launch.output())
        first = rosnode.get_api_uri(self.master, "/ratslam_pc")
        pid = xmlrpc.client.ServerProxy(first).getPid("/launches_test")[2]
        os.kill(pid, signal.SIGKILL)
        self.assertTrue(harness.wait_until(lambda: self.api_of("/ratslam_pc") not in (None, first), 30.0), self.launch.output())
        self.assertTrue(harness.wait_until(lambda: rosnode.rosnode_ping("/ratslam_pc", max_count=1), 30.0), self.launch.output())
        self.assertEqual(self.launch.interrupt(30.0), 0)

    def api_of(self, node):
        try:
            return rosnode.get_api_uri(self.master, node, skip_cache=True)
        except rosgraph.MasterException:
            return None

    def test_keep_leaves_the_nodes_up(self):
        self.start(keep="true")
        self.assertTrue(self.launch.said("the nodes stay up", 90.0), self.launch.output())
        self.assertIn("/ratslam_em", rosnode.get_node_names())
        self.assertTrue(rosnode.rosnode_ping("/ratslam_em", max_count=1))
        self.assertEqual(self.launch.interrupt(30.0), 0)
        self.assertFalse(self.master.hasParam("/use_sim_time"))

    def test_a_playback_says_how_far_it_is_and_who_comes_late_sees_the_last_pictures(self):
        topics = ["/drive/LocalView/View", "/drive/PoseCell/Activity", "/drive/ExperienceMap/Picture"]
        seen = {}
        early = [rospy.Subscriber(topic, Image, lambda message, topic=topic: seen.update({topic: message})) for topic in topics]
        self.start(keep="true", rate=0.25)
        self.assertTrue(self.launch.said("the nodes stay up", 90.0), self.launch.output())
        self.assertRegex(self.launch.output(), r"[0-9]+ %: mapped [0-9]+ of 3 s")
        for subscriber in early:
            subscriber.unregister()
        for topic in topics:
            self.assertEqual(rospy.wait_for_message(topic, Image, 20.0).header.stamp, seen[topic].header.stamp)
        self.assertEqual(self.launch.interrupt(30.0), 0)

    def test_a_bag_that_is_not_there_is_named_with_its_whole_path(self):
        self.assertNotEqual(self.start(bag="no.bag").ended(60.0), None, self.launch.output())
        self.assertRegex(self.launch.output(), os.path.join(self.folder, "no.bag") + ": not a readable bag")
        self.assertNotIn("Traceback", self.launch.output())


if __name__ == "__main__":
    rospy.init_node("launches_test")
    rostest.rosrun("ratslam_ros", "launches", Launches, sys.argv)
