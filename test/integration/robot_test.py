#!/usr/bin/python3
"""Simulated robots: images at 15 Hz, raw and compressed, wheel odometry at 50 Hz whose stamps lie half a second behind."""
import math
import os
import sys
import threading
import time

import rospy
import rostest
import tf2_msgs.msg
from nav_msgs.msg import Odometry
from ratslam_ros.msg import TopologicalMap
from sensor_msgs.msg import CompressedImage, Image

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import harness  # noqa: E402  (lies beside this file)

IMAGE_PERIOD_S, ODOMETRY_PERIOD_S, LATE_S = 1.0 / 15, 1.0 / 50, 0.5
LAP_S = harness.LAP_FRAMES * IMAGE_PERIOD_S


class Robot:
    """Drives round and round, each stream in a thread of its own, as drivers do."""

    def __init__(self, name):
        self.name = name
        self.strip = harness.panorama()
        self.begin = rospy.Time.now().to_sec()
        self.stopped = threading.Event()
        self.raw = rospy.Publisher(f"/{name}/camera/image_raw", Image, queue_size=10)
        self.compressed = rospy.Publisher(f"/{name}/camera/image_raw/compressed", CompressedImage, queue_size=10)
        self.odometry = rospy.Publisher(f"/{name}/odom", Odometry, queue_size=50)
        self.threads = [threading.Thread(target=self.repeat, args=args, daemon=True)
                        for args in ((self.publish_image, IMAGE_PERIOD_S), (self.publish_odometry, ODOMETRY_PERIOD_S))]
        for thread in self.threads:
            thread.start()

    def repeat(self, publish, period):
        number = 0
        while not self.stopped.is_set():
            publish(number)
            number += 1
            time.sleep(max(0.0, self.begin + number * period - time.time()))

    def stamp(self, number, period):
        return int((self.begin + number * period) * 1e9)

    def publish_image(self, number):
        pixels, at = harness.frame(self.strip, number), self.stamp(number, IMAGE_PERIOD_S)
        if self.raw.get_num_connections():
            self.raw.publish(harness.image_message(pixels, at))
        if self.compressed.get_num_connections():
            self.compressed.publish(harness.compressed_message(pixels, at))

    def publish_odometry(self, number):
        message = harness.odometry_message(self.stamp(number, ODOMETRY_PERIOD_S) - int(LATE_S * 1e9), 1.0, 2 * math.pi / LAP_S)
        message.header.frame_id, message.child_frame_id = f"{self.name}/wheels", f"{self.name}/base_link"
        self.odometry.publish(message)

    def stop(self):
        self.stopped.set()
        for thread in self.threads:
            thread.join()
        for publisher in (self.raw, self.compressed, self.odometry):
            publisher.unregister()


class Robots(harness.FolderTest):
    def setUp(self):
        super().setUp()
        self.robots = []

    def tearDown(self):
        super().tearDown()
        for robot in self.robots:
            robot.stop()

    def check_loop(self, maps):
        """The first lap is a circle of 80 places that closes when the second begins."""
        def closed():
            return maps and any(edge.destination_id < edge.source_id for edge in maps[-1].edge)

        self.wait(closed, LAP_S + 45.0)
        ends = [node.pose.position for node in maps[-1].node]
        size = max(math.hypot(a.x - b.x, a.y - b.y) for a in ends for b in ends)
        self.assertAlmostEqual(size, LAP_S / math.pi, delta=0.3 * LAP_S / math.pi)

    def check_quiet(self):
        for bad in ("is stamped", "FATAL", "died", "published by", "broadcast by", "is silent"):
            self.assertNotIn(bad, self.words())

    def test_a_robot_with_its_own_topics_frames_and_odometry(self):
        transforms = self.collected("/tf", tf2_msgs.msg.TFMessage)
        maps = self.collected("/ExperienceMap/Map", TopologicalMap)
        self.robots = [Robot("anna")]
        self.launch("robot.launch", image="/anna/camera/image_raw", odom="/anna/odom", compressed="true")
        self.check_loop(maps)
        names = {(t.header.frame_id, t.child_frame_id) for m in transforms for t in m.transforms}
        self.assertEqual(names, {("map", "anna/wheels")})
        self.check_quiet()

    def test_two_robots_have_two_maps(self):
        transforms = self.collected("/tf", tf2_msgs.msg.TFMessage)
        maps = [self.collected(f"/{name}/ExperienceMap/Map", TopologicalMap) for name in ("anna", "ben")]
        self.robots = [Robot("anna"), Robot("ben")]
        self.launch("two_robots.launch", first="anna", second="ben")
        for own in maps:
            self.check_loop(own)
        names = {(t.header.frame_id, t.child_frame_id) for m in transforms for t in m.transforms}
        self.assertEqual(names, {("anna/map", "anna/wheels"), ("ben/map", "ben/wheels")})
        self.assertEqual({own[-1].header.frame_id for own in maps}, {"anna/map", "ben/map"})
        self.check_quiet()


if __name__ == "__main__":
    rostest.rosrun("ratslam_ros", "robot", Robots, sys.argv)
