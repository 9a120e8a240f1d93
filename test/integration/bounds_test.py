#!/usr/bin/python3
"""Whoever stands still takes no memory of the others without end; what was lost is said; all go on afterwards."""
import math
import os
import signal
import sys
import time

import rostest
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from ratslam_ros.msg import PoseCellState, RecallGeometry, ViewTemplate

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import harness  # noqa: E402  (lies beside this file)

MESSAGES = 30000  # more than a publisher keeps
PARTS = 5  # the sockets of both sides hold some more


def resident_mb(node):
    with open(f"/proc/{node.process.pid}/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20


def wait_until_idle(node):
    """Returns once the node has worked off what it was sent: it takes next to no processor time any more."""
    def ticks():
        with open(f"/proc/{node.process.pid}/stat", encoding="ascii") as file:
            return sum(map(int, file.read().rsplit(")", 1)[1].split()[11:13]))

    last = -math.inf
    end = time.monotonic() + 120.0
    while time.monotonic() < end and ticks() - last > 4:  # of a hundred a second; timers take some
        last = ticks()
        time.sleep(2.0)


class Bounds(harness.NodeTest):
    def feed(self, begin, end, odometry, views):
        """Odometry and views to the pose cells, a thousand at a time."""
        for index in range(begin, end):
            at = harness.START_NS + index * harness.FRAME_PERIOD_NS
            for publisher in odometry:
                publisher.publish(harness.odometry_message(at))
            view = ViewTemplate(current_id=index % harness.LAP_FRAMES)
            view.header.stamp = harness.stamp(at)
            views.publish(view)
            if index % 1000 == 999:
                self.assertTrue(harness.wait_until(lambda: len(self.states) >= index + 1, 60.0), len(self.states))

    def test_a_subscriber_that_stands_still(self):
        pose_cells = self.start("ratslam_pc")
        self.states = self.collected("PoseCell/State", PoseCellState, connected=True)  # all are counted
        # With an odometry of its own: this test would wait for it as long as it sleeps.
        sleeper = self.start("ratslam_em", f"{self.root}/odom:={self.root}/odom_of_sleeper", sync_timeout=0.5)
        odometry = self.publisher("odom", Odometry, queue_size=None)
        for_sleeper = self.publisher("odom_of_sleeper", Odometry, queue_size=None)
        views = self.publisher("LocalView/Template", ViewTemplate, queue_size=None)
        poses = self.collected("ExperienceMap/RobotPose", PoseStamped)
        self.feed(0, 1000, (odometry, for_sleeper), views)
        self.assertTrue(harness.wait_until(lambda: len(poses) > 10, 60.0), sleeper.output())
        sleeper.process.send_signal(signal.SIGSTOP)
        sizes = []
        for part in range(PARTS):
            self.feed(1000 + part * MESSAGES, 1000 + (part + 1) * MESSAGES, (odometry,), views)
            sizes.append(resident_mb(pose_cells))
        self.assertLess(sizes[-1] - sizes[-2], 1.0, sizes)
        before = len(poses)
        sleeper.process.send_signal(signal.SIGCONT)
        self.assertTrue(sleeper.said(r"PoseCell/State: messages of .* were lost: this node did not read them in time", 60.0),
                        sleeper.output())
        self.feed(1000 + PARTS * MESSAGES, 2000 + PARTS * MESSAGES, (odometry, for_sleeper), views)
        self.assertTrue(harness.wait_until(lambda: len(poses) > before + 10, 60.0), sleeper.output())
        newest = self.states[-1].header.stamp
        self.assertTrue(harness.wait_until(lambda: poses[-1].header.stamp == newest, 60.0), sleeper.output())

    def test_geometry_while_the_pose_cells_are_dead(self):
        node = self.start("ratslam_em", vt_verify="orb")
        odometry = self.publisher("odom", Odometry, queue_size=None)
        geometry = self.publisher("LocalView/RecallGeometry", RecallGeometry, queue_size=None)
        sizes = []
        for index in range(2 * MESSAGES):
            at = harness.START_NS + index * harness.FRAME_PERIOD_NS
            odometry.publish(harness.odometry_message(at))
            message = RecallGeometry()
            message.header.stamp = harness.stamp(at)
            geometry.publish(message)
            if index % MESSAGES == MESSAGES - 1:
                wait_until_idle(node)
                sizes.append(resident_mb(node))
        self.assertLess(sizes[1] - sizes[0], 5.0, sizes)
        self.assertTrue(node.said(r"recall geometry forgotten"), node.output())


if __name__ == "__main__":
    rostest.rosrun("ratslam_ros", "bounds", Bounds, sys.argv)
