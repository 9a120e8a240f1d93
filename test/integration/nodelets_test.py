#!/usr/bin/python3
"""Local view and odometry as nodelets of one process: the map is the nodes', to the last byte, and so are their names."""
import os
import sys

import rosnode
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import harness  # noqa: E402  (lies beside this file)


class Nodelets(harness.FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.bag = cls.path("town.bag")
        harness.write_town_bag(cls.bag)

    def on_town(self, **arguments):
        return self.keep(harness.launch_on_town(**arguments))

    def played(self, name, **arguments):
        out = self.path(name)
        return self.completed(self.on_town(bag=self.bag, rate=4, trajectory_file=out, **arguments), out)

    def test_same_bytes_as_the_nodes(self):
        for odometry in ("profile", "orb"):
            nodes = self.played("nodes", odometry=odometry)
            nodelets = self.played("nodelets", odometry=odometry, nodelet_manager="eyes", start_manager="true")
            self.assertGreaterEqual(nodes[1].count(b"\n"), 59)
            self.assertEqual(nodelets, nodes, self.words())

    def test_names_are_those_of_the_nodes(self):
        states = set()
        self.addCleanup(rospy.Subscriber("/diagnostics", DiagnosticArray,
                                         lambda message: states.update(status.name for status in message.status),
                                         queue_size=None).unregister)
        launch = self.on_town(bag="", odometry="orb", nodelet_manager="eyes", start_manager="true")

        def published():
            return {name for name, _ in rospy.get_published_topics()}

        wanted = {"/ratslam_orb_vo/debug_image", "/ratslam_orb_vo/landmarks", "/town/odom", "/town/LocalView/Template"}
        self.assertTrue(harness.wait_until(lambda: wanted <= published(), 30.0), (published(), launch.output()))
        self.assertIn("/eyes", rosnode.get_node_names())
        wanted = {"ratslam_lv: messages", "ratslam_lv: images", "ratslam_orb_vo: images"}
        self.assertTrue(harness.wait_until(lambda: wanted <= states, 30.0), states)
        self.assertEqual({name for name in states if name.startswith("eyes: ")}, set())

    def test_a_bad_parameter_ends_the_launch_and_is_named(self):
        bad = self.path("bad.yaml")
        harness.write_config(bad, vt_match_threshold=7.0)
        launch = self.on_town(bag="", config=bad, nodelet_manager="eyes", start_manager="true")
        self.assertTrue(launch.said("/ratslam_lv: vt_match_threshold: value 7 is not allowed", 30.0), launch.output())
        self.assertIsNotNone(launch.ended(30.0), launch.output())


if __name__ == "__main__":
    rostest.rosrun("ratslam_ros", "nodelets", Nodelets, sys.argv)
