#!/usr/bin/python3
"""Recordings that are broken in one way each: nodes and ratslam_run leave the same map and the same counts, from bags as
from folders, whatever is wrong."""
import json
import os
import sys

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from sensor_msgs.msg import CompressedImage, Image

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import broken_recordings  # noqa: E402  (lies beside this file)
import harness  # noqa: E402

FRAMES = broken_recordings.FRAMES
# What is counted beside frames and used_images, and how many frames are used; kinds that are not here lose nothing.
EXPECTED = {
    "mono16_of_12_bits": (FRAMES, {"changes_of_bit_depth": 1}),
    "float_in_the_middle": (FRAMES - 1, {"corrupt_images": 1}),
    "all_float": (0, {"corrupt_images": FRAMES}),
    "step_that_wraps": (FRAMES - 2, {"corrupt_images": 2}),
    "step_too_small": (FRAMES - 1, {"corrupt_images": 1}),
    "height_beyond_data": (FRAMES - 2, {"corrupt_images": 2}),
    "truncated_jpeg": (FRAMES - 2, {"corrupt_images": 2}),
    "truncated_behind_thumbnail": (FRAMES - 2, {"corrupt_images": 2}),
    "truncated_png": (FRAMES - 2, {"corrupt_images": 2}),
    "empty_file": (FRAMES - 2, {"corrupt_images": 2}),
    "noise_for_a_file": (FRAMES - 2, {"corrupt_images": 2}),
    "bitmap_for_a_file": (FRAMES - 2, {"corrupt_images": 2}),
    "medical_image": (FRAMES - 2, {"corrupt_images": 2}),
    "huge_png": (FRAMES - 2, {"corrupt_images": 2}),
    "first_unreadable": (FRAMES - 2, {"corrupt_images": 2}),
    "all_unreadable": (0, {"corrupt_images": FRAMES}),
    "odd_sizes": (FRAMES - 2, {"other_size_images": 2}),
    "odd_size_first": (FRAMES - 1, {"other_size_images": 1, "new_beginnings": 1}),
    "smaller_than_template_first": (FRAMES - 2, {"other_size_images": 1, "new_beginnings": 1, "unsuitable_images": 1}),
    "late": (FRAMES - 3, {"late_images": 3}),
    "repeated_stamps": (FRAMES - 2, {"repeated_stamp_images": 2}),
    "all_stamps_zero": (1, {"repeated_stamp_images": FRAMES - 1}),
    "unstamped": (FRAMES - 2, {"unstamped_images": 2, "new_beginnings": 1}),
    "looped": (FRAMES, {"new_beginnings": 1}),
    "clock_set_back": (FRAMES - 4, {"late_images": 4}),
    "frozen": (FRAMES, {"frozen_images": 9}),
    "dark": (FRAMES, {"blank_images": 1, "frozen_images": 9}),
    "white_from_the_start": (FRAMES, {"blank_images": 1, "frozen_images": 9}),
    "dark_with_noise": (FRAMES, {"blank_images": 10}),
}
NOTHING_MAPPED = {"all_float", "all_unreadable", "all_stamps_zero"}


class Broken(harness.NodeTest):
    ODOMETRY = ("vo", "profile")  # node, and name for the runner

    def run_offline(self, recording, name):
        """Exit code, what was said, counts of summary.json and trajectories as bytes."""
        out = self.path("run_" + name)
        run = harness.offline(recording, self.config, out, "--odometry", self.ODOMETRY[1])
        self.assertIn(run.returncode, (0, 1), run.stdout)
        with open(out + "/summary.json", encoding="utf-8") as file:
            counts = json.load(file)["counts"]
        return run, counts, harness.trajectories(out + "/trajectory"), harness.contents(out + "/actions.csv").count(b"\n") - 1

    def run_nodes(self, name, shots, decisions):
        """What the nodes count and their trajectories, and the nodes' words; all must live to the end."""
        self.root = "/" + name.lower()
        self.running.clear()  # of the kind before, which have ended
        out = self.path("nodes_" + name)
        compressed = shots[0].data is not None
        counts = {}

        def diagnosed(message):
            for status in message.status:
                if status.name.endswith(self.named("") + ": images"):
                    counts[status.name] = {value.key: int(value.value) for value in status.values if value.value.isdigit()}

        listener = rospy.Subscriber("/diagnostics", DiagnosticArray, diagnosed, queue_size=None)
        poses = self.collected("ExperienceMap/RobotPose", PoseStamped)
        common = {"image_transport": "compressed" if compressed else "raw", "publish_tf": "false", "sync_timeout": 60}
        nodes = [self.start("ratslam_" + node, **common, **more)
                 for node, more in (("em", {"trajectory_file": out}), ("pc", {"wait_for_subscribers": 1}),
                                    ("lv", {"wait_for_subscribers": 1}), (self.ODOMETRY[0], {"wait_for_subscribers": 2}))]
        publisher = rospy.Publisher(self.root + "/camera/image" + ("/compressed" if compressed else ""),
                                    CompressedImage if compressed else Image, queue_size=0)
        try:
            self.assertTrue(harness.wait_for_links(lambda: publisher.get_num_connections() == 2
                                                   and self.subscribers[-1].get_num_connections() == 1), self.words())
            for shot in shots:
                publisher.publish(shot.compressed() if compressed else shot.raw())
            complete = lambda: len(counts) == 2 and all(c.get("frames") == len(shots) for c in counts.values())
            self.assertTrue(harness.wait_until(complete, 30.0), f"{counts} {self.words()}")
            self.assertTrue(harness.wait_until(lambda: len(poses) >= decisions, 10.0), f"{len(poses)} {self.words()}")
            for node in nodes:
                self.assertEqual(node.interrupt(), 0, self.words())
            return list(counts.values()), harness.trajectories(out), self.words()
        finally:
            publisher.unregister()
            listener.unregister()
            for node in nodes:
                node.interrupt()

    def check(self, name, shots, as_folder):
        bag = self.path(name + ".bag")
        broken_recordings.write_bag(bag, shots)
        run, counts, trajectories, decisions = self.run_offline(bag, name)
        used, events = EXPECTED.get(name, (len(shots), {}))
        self.assertEqual(run.returncode, 1 if name in NOTHING_MAPPED else 0, run.stdout)
        known = [key for key in counts if key.endswith("_images") or key in ("new_beginnings", "changes_of_bit_depth")]
        found = {key: counts[key] for key in known if counts[key] and key not in ("used_images",)}
        self.assertEqual((counts["frames"], counts["used_images"], found), (len(shots), used, events), run.stdout)
        stamps = [float(line.split()[0]) for line in trajectories[1].splitlines()]
        if name != "looped":
            self.assertEqual(stamps, sorted(set(stamps)))
        if as_folder:
            folder = self.path(name)
            broken_recordings.write_folder(folder, shots)
            folder_run, folder_counts, folder_trajectories, _ = self.run_offline(folder, name + "_folder")
            self.assertEqual(folder_run.returncode, run.returncode, folder_run.stdout)
            self.assertEqual(folder_trajectories, trajectories, folder_run.stdout)
            self.assertEqual(folder_counts, counts)
        node_counts, node_trajectories, words = self.run_nodes(name, shots, decisions)
        self.assertEqual(node_trajectories, trajectories, words)
        for one in node_counts:
            if name == "smaller_than_template_first":  # too small for the template, not for the profiles
                one.update({key: counts[key] for key in ("unsuitable_images", "used_images")})
            self.assertEqual({key: one[key] for key in known}, {key: counts[key] for key in known}, words)

    def test_nodes_and_runner_agree_on_bags_and_folders(self):
        kinds = broken_recordings.kinds()
        self.assertGreaterEqual(len(kinds), 25)
        self.assertLessEqual(set(EXPECTED), set(kinds))
        failures = []  # sub-tests would not show in rostest's results
        for name, (shots, as_folder) in kinds.items():
            try:
                self.check(name, shots, as_folder)
            except AssertionError as error:
                failures.append(f"{name}: {error}")
        self.assertFalse(failures, "\n\n".join(failures))


if __name__ == "__main__":
    rostest.rosrun("ratslam_ros", "broken", Broken, sys.argv)
