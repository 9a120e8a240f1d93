#!/usr/bin/python3
"""Every node on every topic it takes, with contents that no honest sender sends: it drops them, counts them, goes on.

The messages are a function of the seed alone. Good messages between them must come through, and the node must end by
itself, with finite numbers in its files.
"""
import math
import os
import random
import sys
import time

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from ratslam_ros.msg import (OdometryQuality, PoseCellState, RecallGeometry, TopologicalAction, ViewTemplate)
from sensor_msgs.msg import CameraInfo, CompressedImage, Image

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import harness  # noqa: E402  (lies beside this file)

SEED = 16
ROUNDS = 40
NUMBERS = (float("nan"), float("inf"), -float("inf"), 1e308, -1e308, 1e-310, 0.0, -1.0, 1e18)
WORDS = ("", "mono8", "mono16", "bgr8", "yuv422", "bayer_rggb8", "32FC1", "64FC4", "nonsense", "x" * 300, "a\nb", "%s%n")
COUNTS = (0, 1, 3, 59, 60, 160, 4096, 65536, 71582789, 2**31 - 1, 2**31, 2**32 - 1)


def hostile_stamp(chance, at):
    return harness.stamp(chance.choice((0, at, at, at - 5 * 10**8, at - 600 * 10**9, at + 2**31 * 10**9, (2**32 - 1) * 10**9)))


def fill(message, chance, at):
    """Any value of the field's kind into some of the fields, at any depth."""
    for name, kind in zip(message.__slots__, message._slot_types):
        value = getattr(message, name)
        if name == "header":
            message.header.stamp = hostile_stamp(chance, at)
            message.header.frame_id = chance.choice(WORDS)
        elif kind in ("time", "duration"):
            setattr(message, name, hostile_stamp(chance, at))
        elif hasattr(value, "_slot_types"):
            fill(value, chance, at)
        elif chance.random() < 0.5:
            continue
        elif kind == "string":
            setattr(message, name, chance.choice(WORDS))
        elif kind in ("float64", "float32"):
            setattr(message, name, chance.choice(NUMBERS))
        elif kind == "uint32":
            setattr(message, name, chance.choice(COUNTS))
        elif kind in ("uint8", "bool"):
            setattr(message, name, chance.choice((0, 1)))
        elif kind == "uint8[]":
            setattr(message, name, bytes(chance.randrange(256) for _ in range(chance.choice((0, 1, 44, 132, 9600)))))
        elif kind.startswith("float64["):
            size = len(value) if not kind.endswith("[]") else chance.choice((0, 1, 5, 8, 14, 300))
            setattr(message, name, [chance.choice(NUMBERS) for _ in range(size)])
    return message


class Hostile(harness.NodeTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.dropped = {}
        cls.diagnostics = rospy.Subscriber("/diagnostics", DiagnosticArray, cls.count, queue_size=None)

    @classmethod
    def count(cls, message):
        for status in message.status:
            for entry in status.values:
                if entry.key.startswith("dropped /"):
                    cls.dropped[entry.key[len("dropped "):]] = float(entry.value)

    def drive(self, node_name, topics, good, output, must_go_on=True, **parameters):
        """Hostile messages on all topics, good ones in between.
        @param topics  (name, type) list  @param good  index -> [(name, message)]  @param output  (name, type), of which messages must come again where it must_go_on"""
        chance = random.Random(f"{node_name} {SEED}")
        came = self.collected(*output)
        node = self.start(node_name, sync_timeout=1.0, **parameters)
        publishers = {name: self.publisher(name, kind) for name, kind in topics}
        for index in range(ROUNDS):
            at = harness.frame_stamp(index)
            for name, kind in topics:
                publishers[name].publish(fill(kind(), chance, at))
            for name, message in good(index):
                publishers[name].publish(message)
            time.sleep(0.02)
        before = len(came)
        begin = harness.frame_stamp(ROUNDS) + 10**15  # a time that nothing hostile has named
        for index in range(40):
            for name, message in good(index):
                message.header.stamp = harness.stamp(begin + harness.frame_stamp(index))
                publishers[name].publish(message)
            time.sleep(0.02)
        goes_on = harness.wait_until(lambda: len(came) > before + 10, 15.0 if must_go_on else 3.0)
        self.assertTrue(goes_on or not must_go_on, f"{len(came) - before} after\n" + node.output())
        self.ends_well(node)
        self.assertNotIn("Traceback", node.output())
        return node

    def odometry(self, index):
        return harness.odometry_message(harness.frame_stamp(index))

    def test_local_view(self):
        self.drive("ratslam_lv", [("camera/image", Image)], lambda i: [("camera/image", self.image(i))],
                   ("LocalView/Template", ViewTemplate))

    def test_local_view_compressed(self):
        self.drive("ratslam_lv", [("camera/image/compressed", CompressedImage)],
                   lambda i: [("camera/image/compressed", harness.compressed_message(self.frame(i), harness.frame_stamp(i)))],
                   ("LocalView/Template", ViewTemplate), image_transport="compressed")

    def test_local_view_that_verifies(self):
        info = CameraInfo(width=harness.WIDTH, height=harness.HEIGHT)
        info.K = [46.0, 0, 80, 0, 46.0, 30, 0, 0, 1]
        self.drive("ratslam_lv", [("camera/image", Image), ("camera/camera_info", CameraInfo)],
                   lambda i: [("camera/camera_info", info), ("camera/image", self.image(i))],
                   ("LocalView/Template", ViewTemplate), vt_verify="orb")

    def test_profile_odometry(self):
        self.drive("ratslam_vo", [("camera/image", Image)], lambda i: [("camera/image", self.image(i))], ("odom", Odometry))

    def test_orb_odometry(self):
        info = CameraInfo(width=harness.WIDTH, height=harness.HEIGHT)
        info.K = [46.0, 0, 80, 0, 46.0, 30, 0, 0, 1]
        self.drive("ratslam_orb_vo", [("camera/image", Image), ("camera/camera_info", CameraInfo)],
                   lambda i: [("camera/camera_info", info), ("camera/image", self.image(i))], ("odom", Odometry))

    def test_pose_cells(self):
        self.drive("ratslam_pc", [("odom", Odometry), ("odom_quality", OdometryQuality), ("LocalView/Template", ViewTemplate)],
                             lambda i: [("odom", self.odometry(i)), ("LocalView/Template", harness.view_message(i))],
                             ("PoseCell/State", PoseCellState))
        for topic in ("odom_quality", "LocalView/Template"):
            self.assertGreater(self.dropped.get(f"{self.root}/{topic}", 0), 0, self.dropped)

    def test_map(self):
        prefix = os.path.join(self.folder, "hostile")

        def action(index):
            message = PoseCellState(action=TopologicalAction.CREATE_NODE, src_id=max(0, index - 1), dest_id=index)
            message.session = harness.stamp(harness.START_NS)  # numbers of a session of its own
            message.header.stamp = harness.stamp(harness.frame_stamp(index))
            return message

        node = self.drive(
            "ratslam_em",
            [("odom", Odometry), ("odom_quality", OdometryQuality), ("PoseCell/State", PoseCellState),
             ("PoseCell/TopologicalAction", TopologicalAction), ("LocalView/RecallGeometry", RecallGeometry),
             ("ExperienceMap/SetGoalPose", PoseStamped)],
            lambda i: [("odom", self.odometry(i)), ("PoseCell/State", action(i))],
            ("ExperienceMap/RobotPose", PoseStamped), must_go_on=False, vt_verify="orb", trajectory_file=prefix)
        for topic in ("odom_quality", "PoseCell/State", "ExperienceMap/SetGoalPose"):
            self.assertGreater(self.dropped.get(f"{self.root}/{topic}", 0), 0, self.dropped)
        for name in (prefix + "_online.tum", prefix + "_final.tum"):
            with open(name, encoding="ascii") as file:
                rows = [[float(word) for word in line.split()] for line in file]
            self.assertTrue(rows, node.output())
            self.assertTrue(all(math.isfinite(value) for row in rows for value in row), name)
            stamps = [row[0] for row in rows]
            self.assertEqual(stamps, sorted(stamps), name)


if __name__ == "__main__":
    rostest.rosrun("ratslam_ros", "hostile", Hostile, sys.argv)
