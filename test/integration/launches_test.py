#!/usr/bin/python3
"""What the launch files promise to somebody who only calls roslaunch: nothing left behind, a clean ending, his own folder."""
import os
import signal
import subprocess
import sys
import time
import xmlrpc.client

import rosbag
import rosgraph
import rosnode
import rostest
from sensor_msgs.msg import Image
from std_msgs.msg import String

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import harness  # noqa: E402  (lies beside this file)


class Launches(harness.FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        harness.write_bag(cls.path("drive.bag"), "/drive", 30, compressed=True)
        cls.master = rosgraph.Master("/launches_test")

    def start(self, **arguments):
        """Plays the bag, named as the user's folder has it."""
        self.launched = self.launch(cwd=self.folder, **{"bag": "drive.bag", "rate": 10, "topic_root": "drive", "compressed": "true",
                                                        **arguments})
        return self.launched

    def test_a_playback_ends_cleanly_and_leaves_nothing_set_for_the_next(self):
        other = self.path("other.yaml")
        harness.write_config(other, exp_height="true", pc_vt_restore=0.07)
        self.assertEqual(self.start(config=other).ended(90.0), 0, self.launched.output())
        self.assertIn("the map has processed the last image", self.launched.output())
        for bad in ("REQUIRED", "has died", "Traceback", "escalating"):
            self.assertNotIn(bad, self.launched.output())
        self.assertFalse(self.master.hasParam("/use_sim_time"))

        self.assertEqual(self.start().ended(90.0), 0, self.launched.output())
        for node in ("/ratslam_em", "/ratslam_pc", "/ratslam_lv", "/ratslam_vo"):
            left = self.master.getParam(node)
            self.assertFalse({"exp_height", "pc_vt_restore"} & set(left), node)

    def test_a_live_launch_after_a_playback_drops_no_more_than_it_says(self):
        """The queue without bound of a playback is none of a camera's."""
        self.assertEqual(self.start().ended(90.0), 0, self.launched.output())
        self.start(bag="")
        self.assertTrue(harness.wait_until(lambda: "/ratslam_vo" in rosnode.get_node_names(), 30.0))
        self.assertNotIn("image_queue_size", self.master.getParam("/ratslam_lv"))
        self.assertNotIn("wait_for_subscribers", self.master.getParam("/ratslam_vo"))

    def test_a_node_that_dies_comes_back_where_it_is_asked_for(self):
        self.start(bag="", respawn="true", odometry="external")
        self.assertTrue(harness.wait_until(lambda: rosnode.rosnode_ping("/ratslam_pc", max_count=1), 30.0), self.launched.output())
        first = rosnode.get_api_uri(self.master, "/ratslam_pc")
        pid = xmlrpc.client.ServerProxy(first).getPid("/launches_test")[2]
        os.kill(pid, signal.SIGKILL)
        self.assertTrue(harness.wait_until(lambda: self.api_of("/ratslam_pc") not in (None, first), 30.0), self.launched.output())
        self.assertTrue(harness.wait_until(lambda: rosnode.rosnode_ping("/ratslam_pc", max_count=1), 30.0), self.launched.output())
        self.assertEqual(self.launched.interrupt(30.0), 0)

    def api_of(self, node):
        try:
            return rosnode.get_api_uri(self.master, node, skip_cache=True)
        except rosgraph.MasterException:
            return None

    def test_keep_leaves_the_nodes_up(self):
        self.start(keep="true")
        self.assertTrue(self.launched.said("the nodes stay up", 90.0), self.launched.output())
        self.assertIn("/ratslam_em", rosnode.get_node_names())
        self.assertTrue(rosnode.rosnode_ping("/ratslam_em", max_count=1))
        self.assertEqual(self.launched.interrupt(30.0), 0)
        self.assertFalse(self.master.hasParam("/use_sim_time"))

    def test_a_playback_says_how_far_it_is_and_who_comes_late_sees_the_last_pictures(self):
        topics = ["/drive/LocalView/View", "/drive/PoseCell/Activity", "/drive/ExperienceMap/Picture"]
        early = {topic: self.collected(topic, Image) for topic in topics}
        self.start(keep="true", rate=0.25)
        self.assertTrue(self.launched.said("the nodes stay up", 90.0), self.launched.output())
        self.assertRegex(self.launched.output(), r"[0-9]+ %: mapped [0-9]+ of 3 s")
        for topic in topics:
            late = self.collected(topic, Image)
            self.wait(lambda came=late: came, 20.0)
            # A map may draw its last state a moment later, for both.
            self.wait(lambda came=late, before=early[topic]: before[-1].header.stamp == came[-1].header.stamp)
        self.assertEqual(self.launched.interrupt(30.0), 0)

    def test_ctrl_c_at_any_moment_of_the_start_ends_everything_quietly(self):
        for seconds in (0.0, 0.1, 0.2, 0.3, 0.4, 0.6, 0.9, 1.2):
            launched = self.start(rate=0.2)
            # The last node that roslaunch starts; before that an interruption would be roslaunch's own matter.
            self.assertTrue(launched.said(r"process\[ratslam_vo-", 30.0), launched.output())
            time.sleep(seconds)
            begin = time.monotonic()
            # Older versions of roslaunch may end by the signal itself, as long as they have not begun to wait.
            self.assertIn(launched.interrupt(30.0), (0, -signal.SIGINT), launched.output())
            self.assertLess(time.monotonic() - begin, 12.0, launched.output())
            self.assertEqual(launched.count("Traceback|escalating|has died"), 0, launched.output())
            self.assertFalse(self.master.hasParam("/use_sim_time"))

    def test_a_second_playback_takes_over_and_keeps_its_clock(self):
        first = self.start(rate=0.05)
        # The master may still know the player of an earlier playback. Two launches that begin at once clear each other's parameters.
        self.assertTrue(first.said("Opening .*drive.bag", 30.0), first.output())
        second = self.start(rate=0.5, keep="true")  # is still up when the first has ended, however long that takes
        self.assertIsNotNone(first.ended(60.0), first.output() + second.output())
        # The first may have removed it before the second playback had begun, which then sets it.
        self.assertTrue(harness.wait_until(lambda: self.master.hasParam("/use_sim_time")), first.output() + second.output())
        self.assertTrue(second.said("the nodes stay up", 60.0), second.output())
        self.assertIn("the map has processed the last image", second.output())
        self.assertEqual(second.interrupt(30.0), 0, second.output())
        self.assertFalse(self.master.hasParam("/use_sim_time"))

    def rewritten(self, name, stamps):
        """The drive with other stamps: one for each image, again from the first image on where there are more."""
        with rosbag.Bag(self.path("drive.bag")) as source:
            images = [message for _, message, _ in source.read_messages()]
        with rosbag.Bag(self.path(name), "w") as bag:
            for index, at in enumerate(stamps):
                message = images[index % len(images)]
                message.header.stamp = harness.stamp(at)
                bag.write("/drive/camera/image/compressed", message, harness.stamp(harness.frame_stamp(index)))
        return name

    def test_a_recording_whose_time_goes_back_is_played_to_its_end(self):
        once = [harness.frame_stamp(index) for index in range(30)]
        bag = self.rewritten("twice.bag", once + once)
        self.assertEqual(self.start(bag=bag, trajectory_file=self.path("twice")).ended(90.0), 0, self.launched.output())
        self.assertIn("the map has processed the last image", self.launched.output())
        counts = [harness.contents(self.path(name)).count(b"\n") for name in ("twice_final.tum", "twice_final_2.tum")]
        self.assertGreaterEqual(min(counts), 29, self.launched.output())

    def test_images_without_stamps_are_played_to_the_end_as_well(self):
        config = self.path("arrival.yaml")
        harness.write_config(config, stamp_source="arrival")
        self.start(bag=self.rewritten("unstamped.bag", 30 * [0]), config=config, trajectory_file=self.path("unstamped"))
        self.assertEqual(self.launched.ended(90.0), 0, self.launched.output())
        self.assertIn("the map has processed the last image", self.launched.output())
        self.assertGreaterEqual(harness.contents(self.path("unstamped_final.tum")).count(b"\n"), 20, self.launched.output())

    def test_a_wrong_switch_or_odometry_is_named_before_anything_starts(self):
        for arguments, said in (({"odometry": "sonar"}, "odometry:=sonar is not allowed: orb, profile or external"),
                                ({"compressed": "yes"}, "compressed:=yes.* is not allowed: true or false"),
                                ({"nodelet_manager": "a b"}, "nodelet_manager:=a b is not allowed: the name of a node"),
                                ({"start_manager": "true"}, "is not allowed with start_manager:=true: the name of a node"),
                                ({"nodelet_manager": "/front/eyes", "start_manager": "true"}, "a node, without a namespace"),
                                ({"keep": "no"}, "keep:=no.* is not allowed: true or false"),
                                ({"localise_only": 2}, "localise_only:=2.* is not allowed: true or false")):
            launched = self.start(**arguments)
            self.assertEqual(launched.ended(30.0), 1, launched.output())
            self.assertEqual(launched.count(said), 1, launched.output())
            self.assertEqual(launched.count("process\\["), 0, launched.output())

    def test_each_of_two_robots_keeps_a_map_of_its_own(self):
        words = ["roslaunch", "--dump-params", "ratslam_ros", "two_robots.launch", "first:=anna", "second:=ben"]
        for given, expected in (("map_dir:=/maps", "/maps/"), ("map_dir:=", None)):
            told = subprocess.run([*words, given], stdout=subprocess.PIPE, text=True, check=True).stdout
            for robot in ("anna", "ben"):
                folder = f"{expected}{robot}" if expected else "''"
                self.assertIn(f"/{robot}/ratslam_em/map_dir: {folder}\n", told)

    def test_names_that_look_like_numbers_stay_names(self):
        words = ["roslaunch", "--dump-params", "ratslam_ros", "ratslam.launch", "map_dir:=2024.10", "trajectory_file:=2024.20"]
        told = subprocess.run(words, stdout=subprocess.PIPE, text=True, check=True).stdout
        self.assertIn("/ratslam_em/map_dir: '2024.10'\n", told)
        self.assertIn("/ratslam_em/trajectory_file: '2024.20'\n", told)

    def test_a_bag_may_have_any_name(self):
        os.link(self.path("drive.bag"), self.path("rat's \"drive\" 1.bag"))
        self.assertEqual(self.start(bag="rat's \"drive\" 1.bag").ended(90.0), 0, self.launched.output())
        self.assertIn("the map has processed the last image", self.launched.output())

    def test_a_bag_that_is_not_there_is_named_with_its_whole_path(self):
        self.assertNotEqual(self.start(bag="no.bag").ended(60.0), None, self.launched.output())
        self.assertRegex(self.launched.output(), os.path.join(self.folder, "no.bag") + ": not a readable bag")
        self.assertNotIn("Traceback", self.launched.output())

    def test_what_cannot_be_played_is_one_line(self):
        with open(self.path("other.mcap"), "wb") as file:
            file.write(b"\x89MCAP0\r\n" + bytes(100))
        with rosbag.Bag(self.path("words.bag"), "w") as bag:
            bag.write("/drive/camera/image/compressed", String("no image"), harness.stamp(harness.START_NS))
        for arguments, said in (({"bag": "words.bag"},
                                 "/compressed holds no sensor_msgs/CompressedImage, but std_msgs/String; the bag has"),
                                ({"bag": "other.mcap"}, "other.mcap: not a readable bag: .*ROS 2"),
                                ({"rate": 0}, "--rate: value '0' is not allowed"),
                                ({"rate": "fast"}, "--rate: value 'fast' is not allowed"),
                                ({"rate": "nan"}, "--rate: value 'nan' is not allowed"),
                                ({"odometry": "external"}, "no messages on /drive/odom, to which nodes listen")):
            launched = self.start(**arguments)
            self.assertTrue(launched.said(said, 60.0), launched.output())
            if "odometry" in arguments:
                self.assertTrue(launched.said("FATAL.* nothing was mapped", 60.0), launched.output())
            self.assertIsNotNone(launched.ended(60.0), launched.output())
            self.assertEqual(launched.count("Traceback|without all subscribers"), 0, launched.output())


if __name__ == "__main__":
    rostest.rosrun("ratslam_ros", "launches", Launches, sys.argv)
