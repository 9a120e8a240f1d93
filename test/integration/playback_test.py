#!/usr/bin/python3
"""A run is a function of the bag and the parameters: playback speed is not among its arguments."""
import contextlib
import json
import os
import sqlite3
import sys

import rosbag
import rostest
from geometry_msgs.msg import PoseStamped
from ratslam_ros.msg import ViewTemplate

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import harness  # noqa: E402  (lies beside this file)
import restart_trials as trials  # noqa: E402

FRAMES = 110


class Playback(harness.FolderTest):
    def play(self, bag, rate, **arguments):
        """Trajectory files of one playback through roslaunch, as bytes: online and final."""
        arguments = {"trajectory_file": self.path(f"{os.path.basename(bag)}_{rate}"), **arguments}
        launched = self.launch(bag=bag, rate=rate, topic_root="drive", **arguments)
        return self.completed(launched, arguments["trajectory_file"])

    def run_offline(self, bag, odometry):
        return self.offline(bag, "offline_" + os.path.basename(bag), "--odometry", odometry)

    def test_profile_odometry_at_every_rate_and_offline(self):
        bag = self.path("images.bag")
        harness.write_bag(bag, "/drive", FRAMES, compressed=True)
        reference = self.play(bag, 5, compressed="true")
        self.assertEqual(reference[1].count(b"\n"), FRAMES)
        self.assertEqual(self.play(bag, 1, compressed="true"), reference)
        self.assertEqual(self.play(bag, 20, compressed="true"), reference)
        self.assertEqual(self.run_offline(bag, "profile"), reference)
        self.assertEqual(self.in_two_parts(bag, "profile_parts", compressed="true"), reference)

    def test_the_last_images_arrive_although_all_are_published_at_once(self):
        """They fill the queues of the player, which must not end before it has sent them."""
        bag = self.path("at_once.bag")
        harness.write_bag(bag, "/drive", FRAMES, size=(1280, 960))
        played = self.play(bag, 1000, odometry="profile")
        self.assertEqual(played[0].count(b"\n"), FRAMES)

    def in_two_parts(self, bag, name, rate=5, first=FRAMES // 2, **arguments):
        """The same, with all nodes ended after that many images, where no message is on its way, and started again."""
        parts = [self.path(f"{name}_{part}.bag") for part in (1, 2)]
        images, ended = 0, False
        with rosbag.Bag(bag) as whole, rosbag.Bag(parts[0], "w") as before, rosbag.Bag(parts[1], "w") as after:
            has_odometry = "/drive/odom" in whole.get_type_and_topic_info().topics
            for topic, message, at in whole.read_messages():
                (after if ended else before).write(topic, message, at)
                images += "image" in topic
                ended = ended or images >= first and (topic.endswith("/odom") or not has_odometry)
        kept = {"map_dir": self.path(name + "_map"), "trajectory_file": self.path(name), **arguments}
        self.play(parts[0], rate, **kept)
        return self.play(parts[1], rate, **kept)

    def kept(self, name):
        """What the nodes have kept in the end: the rows of templates, views, experiences and links."""
        rows = {}
        for part, tables in (("local_view", ["template"]), ("pose_cells", ["view_link", "pose_cell_experience"]),
                             ("experience_map", ["experience", "link"])):
            files = [f"{self.path(name)}/{part}.{turn}.db" for turn in ("a", "b")]
            newest = max((file for file in files if os.path.exists(file)), key=self.stamp_of)
            for table in tables:
                with contextlib.closing(sqlite3.connect(newest)) as file:
                    file.row_factory = sqlite3.Row
                    rows[table] = [dict(row) for row in file.execute(f"SELECT * FROM {table} ORDER BY row_id")]
        return rows

    @staticmethod
    def stamp_of(path):
        with contextlib.closing(sqlite3.connect(path)) as file:
            return file.execute("SELECT stamp FROM checkpoint").fetchone()[0]

    def test_orb_odometry_in_two_parts_and_offline(self):
        profile, self.config = self.config, self.path("orb.yaml")
        harness.write_config(self.config, **trials.CONFIG, vt_descriptor="orientation", vt_recall="belief", exp_scale="true")
        bag = self.path("orb.bag")
        harness.write_town(bag, "--root", "drive", "--frames", "500", "--size", "620x188", "--jpeg-quality", "90")
        orb = {"odometry": "orb", "compressed": "true"}
        reference = self.play(bag, 10, map_dir=self.path("orb_map"), **orb)
        self.assertEqual(self.run_offline(bag, "orb"), reference)
        # On ground that is seen again: with recalls, and with all the odometry's keyframes, before and after. What the
        # odometry says of its quality must be heard whatever its topic is.
        self.assertEqual(self.in_two_parts(bag, "orb_parts", 10, 465, odom="/drive/visual", **orb), reference)
        whole = self.kept("orb_map")
        self.assertLess(len(whole["template"]), 480, "little was recalled")
        self.assertEqual(self.kept("orb_parts_map"), whole)
        self.config = profile

    def test_odometry_stamped_between_the_images_at_every_rate_and_offline(self):
        bag = self.path("odometry.bag")
        harness.write_bag(bag, "/drive", FRAMES, odometry_period_ns=37000000)
        reference = self.play(bag, 5, odometry="external")
        self.assertEqual(self.play(bag, 20, odometry="external"), reference)
        self.assertEqual(self.run_offline(bag, "topic"), reference)
        self.assertEqual(self.in_two_parts(bag, "topic_parts", odometry="external"), reference)

    def test_what_a_bag_holds_of_topics_of_ours_is_not_played(self):
        """An odometry beside the images, and what an earlier run has published."""
        bag = self.path("recorded.bag")
        harness.write_bag(self.path("plain.bag"), "/drive", FRAMES, odometry_period_ns=37000000)
        with rosbag.Bag(self.path("plain.bag")) as plain, rosbag.Bag(bag, "w") as recorded:
            for topic, message, at in plain.read_messages():
                recorded.write(topic, message, at)
                if "image" in topic:
                    view = ViewTemplate(header=message.header, current_id=3)
                    recorded.write("/drive/LocalView/Template", view, at)
                    recorded.write("/drive/ExperienceMap/RobotPose", PoseStamped(header=message.header), at)
        played = self.play(bag, 5, odometry="profile")
        self.assertEqual(self.running[-1].count("not played, since the nodes publish it themselves: /drive/ExperienceMap/RobotPose, "
                                                "/drive/LocalView/Template, /drive/odom$"), 1, self.words())
        self.assertEqual(self.running[-1].count("its source started anew"), 0, self.words())
        self.assertEqual(self.run_offline(bag, "profile"), played)

    def test_a_late_image_beside_an_external_odometry_is_left_out_by_both(self):
        whole, bag = self.path("in_order.bag"), self.path("late.bag")
        harness.write_bag(whole, "/drive", FRAMES, compressed=True, odometry_period_ns=37000000)
        with rosbag.Bag(whole) as source:
            messages = list(source.read_messages())
        images = [index for index, entry in enumerate(messages) if "image" in entry.topic]
        one, other = images[40:42]
        with rosbag.Bag(bag, "w") as late:
            for index, entry in enumerate(messages):
                late.write(entry.topic, messages[{one: other, other: one}.get(index, index)].message, entry.timestamp)
        played = self.play(bag, 5, odometry="external", compressed="true")
        self.assertEqual(self.running[-1].count("image skipped: it is late"), 1, self.words())
        self.assertEqual(self.run_offline(bag, "topic"), played)
        stamps = [float(line.split()[0]) for line in played[1].splitlines()]
        self.assertEqual(stamps, sorted(set(stamps)))
        self.assertGreaterEqual(len(stamps), FRAMES - 1)

    def test_recalls_by_belief_at_every_rate_and_offline(self):
        nearest, self.config = self.config, self.path("belief.yaml")
        harness.write_config(self.config, vt_descriptor="orientation", vt_recall="belief")
        bag = self.path("belief.bag")
        harness.write_bag(bag, "/drive", FRAMES, odometry_period_ns=37000000)
        reference = self.play(bag, 5, odometry="external")
        self.assertEqual(self.play(bag, 20, odometry="external"), reference)
        self.assertEqual(self.run_offline(bag, "topic"), reference)
        self.assertEqual(self.in_two_parts(bag, "belief_parts", odometry="external"), reference)
        with open(os.path.join(self.path("offline_belief.bag"), "summary.json"), encoding="utf-8") as file:
            self.assertLess(json.load(file)["counts"]["templates"], FRAMES, "nothing was recalled")
        self.config = nearest


if __name__ == "__main__":
    rostest.rosrun("ratslam_ros", "playback", Playback, sys.argv)
