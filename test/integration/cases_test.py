#!/usr/bin/python3
"""Single messages that have ended a node, or taken its memory or its map: each between good ones, and all goes on."""
import io
import math
import os
import struct
import sys
import time
import zlib

import rostest
from nav_msgs.msg import Odometry
from ratslam_ros.msg import OdometryQuality, PoseCellState, TopologicalAction, TopologicalMap, ViewTemplate
from sensor_msgs.msg import CompressedImage, Image

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import harness  # noqa: E402  (lies beside this file)

SECOND = 10**9
IMAGE_NODES = {"ratslam_lv": ("LocalView/Template", ViewTemplate), "ratslam_vo": ("odom", Odometry),
               "ratslam_orb_vo": ("odom", Odometry)}


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png_of_a_gigabyte():
    """Less than a megabyte of file for 2^30 black pixels."""
    side = 32768
    packer = zlib.compressobj(9)
    rows = bytes(64 * (side + 1))
    packed = b"".join(packer.compress(rows) for _ in range(side // 64)) + packer.flush()
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", side, side, 8, 0, 0, 0, 0)) + chunk(b"IDAT", packed)
            + chunk(b"IEND", b""))


class Claim:
    """A message whose last array claims to be as long as a machine's memory. `behind`: bytes from its length to the end"""
    behind = 0

    def serialize(self, buff):
        whole = io.BytesIO()
        super().serialize(whole)
        at = len(whole.getvalue()) - self.behind
        buff.write(whole.getvalue()[:at] + struct.pack("<I", 0xFFFFFFF0) + whole.getvalue()[at + 4:])


class ImageThatClaims(Claim, Image):
    behind = 4 + 44


class QualityThatClaims(Claim, OdometryQuality):
    behind = 4


def most_memory_mb(node):
    with open(f"/proc/{node.process.pid}/status", encoding="ascii") as file:
        return next(int(line.split()[1]) / 1024 for line in file if line.startswith("VmHWM"))


class Cases(harness.NodeTest):
    def between_good_images(self, bad, compressed, complaint):
        """@param bad  a message without a stamp  @return the nodes, which have gone on"""
        base = self.root
        for name, (output, kind) in IMAGE_NODES.items():
            self.root = f"{base}/{name}"
            node = self.start(name, image_transport="compressed" if compressed else "raw", camera_fx=46.0, camera_fy=46.0,
                              camera_cx=80.0, camera_cy=30.0, camera_width_px=harness.WIDTH, camera_height_px=harness.HEIGHT)
            came = self.collected(output, kind, connected=True)
            images = self.publisher("camera/image" + ("/compressed" if compressed else ""), CompressedImage if compressed else Image)
            make = harness.compressed_message if compressed else harness.image_message
            for index in range(10):
                images.publish(make(harness.frame(self.strip, index), harness.frame_stamp(index)))
                if index == 5:
                    bad.header.stamp = harness.stamp(harness.frame_stamp(index) + 1000)
                    images.publish(bad)
            last = harness.stamp(harness.frame_stamp(9))
            self.assertTrue(harness.wait_until(lambda c=came, s=last: c and c[-1].header.stamp == s), node.output())
            self.assertTrue(node.said(complaint), node.output())
            yield node
            self.ends_well(node)

    def test_a_step_that_wraps_at_32_bits(self):
        bad = Image(height=60, width=160, encoding="mono8", step=71582789, data=bytes(44))
        self.assertEqual(len(list(self.between_good_images(bad, False, "image skipped: malformed image: 160x60"))), 3)

    def test_a_length_for_which_there_are_no_bytes(self):
        bad = ImageThatClaims(height=60, width=160, encoding="mono8", step=160, data=bytes(44))
        for node in self.between_good_images(bad, False, "image skipped: the lengths that it names do not fit into its"):
            self.assertLess(most_memory_mb(node), 300.0)
        node = self.start("ratslam_pc", sync_timeout=1.0)
        states = self.collected("PoseCell/State", PoseCellState, connected=True)
        odometry = self.publisher("odom", Odometry)
        quality = self.publisher("odom_quality", OdometryQuality)
        views = self.publisher("LocalView/Template", ViewTemplate)
        quality.publish(QualityThatClaims())
        self.assertTrue(node.said("odom_quality: message dropped: the lengths that it names do not fit into its"), node.output())
        for index in range(10):
            view = ViewTemplate(current_id=index)
            view.header.stamp = harness.stamp(harness.frame_stamp(index))
            odometry.publish(harness.odometry_message(harness.frame_stamp(index)))
            views.publish(view)
        self.assertTrue(harness.wait_until(lambda: len(states) == 10), node.output())
        self.assertLess(most_memory_mb(node), 300.0)
        self.ends_well(node)

    def test_a_medical_image(self):
        bad = CompressedImage(format="jpeg", data=bytes(128) + b"DICM")
        self.assertEqual(len(list(self.between_good_images(bad, True, "image skipped"))), 3)

    def test_a_png_that_unpacks_to_a_gigabyte(self):
        bad = CompressedImage(format="png", data=png_of_a_gigabyte())
        for node in self.between_good_images(bad, True, "image_max_pixels"):
            self.assertLess(most_memory_mb(node), 300.0)

    def test_numbers_that_are_none_or_overflow_once_driven(self):
        node = self.start("ratslam_pc")
        states = self.collected("PoseCell/State", PoseCellState, connected=True)
        odometry = self.publisher("odom", Odometry)
        views = self.publisher("LocalView/Template", ViewTemplate)
        for index in range(20):
            at = harness.START_NS + index * 10 * SECOND
            odometry.publish(harness.odometry_message(at, speed=1e308 if index == 7 else 1.0))
            view = ViewTemplate(current_id=index, relative_rad=float("nan") if index == 9 else 0.0)
            view.header.stamp = harness.stamp(at)
            views.publish(view)
        self.assertTrue(harness.wait_until(lambda: len(states) == 19), f"{len(states)}\n{node.output()}")
        self.assertTrue(all(math.isfinite(v) for state in states for v in (state.x, state.y, state.th)))
        self.assertTrue(node.said("odometry dropped: the speed"), node.output())
        self.assertTrue(node.said("Template: message dropped: .*relative_rad"), node.output())
        self.ends_well(node)

    def test_stamps_68_years_later(self):
        prefix = os.path.join(self.folder, "later")
        node = self.start("ratslam_em", trajectory_file=prefix)
        odometry = self.publisher("odom", Odometry)
        states = self.publisher("PoseCell/State", PoseCellState)
        maps = self.collected("ExperienceMap/Map", TopologicalMap)
        for later in (0, 2**31 * SECOND):
            for index in range(10):
                at = harness.START_NS + later + index * SECOND
                odometry.publish(harness.odometry_message(at))
                number = index + (10 if later else 0)
                state = PoseCellState(action=TopologicalAction.CREATE_NODE, src_id=max(0, number - 1), dest_id=number)
                state.header.stamp = harness.stamp(at)
                states.publish(state)
                time.sleep(0.02)
        self.assertTrue(harness.wait_until(lambda: maps and len(maps[-1].node) == 20), node.output())
        self.ends_well(node)
        for name in (prefix + "_online.tum", prefix + "_final.tum"):
            with open(name, encoding="ascii") as file:
                rows = [[float(word) for word in line.split()] for line in file]
            self.assertEqual(len(rows), 20, name)
            self.assertTrue(all(math.isfinite(value) for row in rows for value in row), name)
            # Nothing was measured in 68 years: nothing is driven in them.
            self.assertLess(math.hypot(rows[10][1] - rows[9][1], rows[10][2] - rows[9][2]), 10.0, name)

    def test_odometry_that_steps_back_between_the_images(self):
        states = self.collected("PoseCell/State", PoseCellState)
        maps = self.collected("ExperienceMap/Map", TopologicalMap)
        cells = self.start("ratslam_pc")
        node = self.start("ratslam_em", map_period=0.0)
        odometry = self.publisher("odom", Odometry, 2)
        views = self.publisher("LocalView/Template", ViewTemplate)
        for index in range(100):  # images at 5 Hz, odometry at 20 Hz
            at = harness.START_NS + index * SECOND // 5
            for part in range(4):
                odometry.publish(harness.odometry_message(at + part * SECOND // 20, speed=10.0, yaw_rate=0.0))
            if index % 7 == 3:
                odometry.publish(harness.odometry_message(at - SECOND // 4, speed=10.0, yaw_rate=0.0))
            view = ViewTemplate(current_id=index)
            view.header.stamp = harness.stamp(at)
            views.publish(view)
            time.sleep(0.01)
        self.assertTrue(harness.wait_until(lambda: len(states) == 100), f"{len(states)}\n{cells.output()}")
        created = sum(state.action == TopologicalAction.CREATE_NODE for state in states)
        self.assertGreater(created, 80)
        self.assertTrue(harness.wait_until(lambda: maps and len(maps[-1].node) == created), node.output())
        self.assertEqual(node.count("decision of the pose cells dropped"), 0, node.output())
        for ended in (cells, node):
            self.assertTrue(ended.said("odometry dropped, it is older than the message before it"), ended.output())
            self.ends_well(ended)


if __name__ == "__main__":
    rostest.rosrun("ratslam_ros", "cases", Cases, sys.argv)
