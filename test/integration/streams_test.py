#!/usr/bin/python3
"""Single nodes on streams as they come in the field: corrupt, odd, late, missing, running backwards."""
import math
import os
import signal
import sys
import time
import xmlrpc.client

import numpy as np
import rosgraph
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry
from ratslam_ros.msg import PoseCellState, TopologicalAction, ViewTemplate
from ratslam_tools import master
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from tf2_msgs.msg import TFMessage

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import harness  # noqa: E402  (lies beside this file)


class Streams(harness.NodeTest):
    def test_corrupt_jpegs_are_counted_skipped_and_reported(self):
        node = self.start("ratslam_lv", image_transport="compressed")
        templates = self.collected("LocalView/Template", ViewTemplate, connected=True)
        images = self.publisher("camera/image/compressed", CompressedImage)
        for index in range(6):
            message = harness.compressed_message(self.frame(8 * index), harness.frame_stamp(index))
            if index in (2, 4):
                message.data = message.data[:len(message.data) // 2]
            images.publish(message)
        self.assertTrue(harness.wait_until(lambda: len(templates) >= 4), node.output())
        self.assertEqual([m.header.stamp for m in templates],
                         [harness.stamp(harness.frame_stamp(i)) for i in (0, 1, 3, 5)])
        self.assertTrue(node.said(r"image skipped: corrupt compressed image"), node.output())

    def test_a_slow_node_drops_old_images_and_says_so(self):
        node = self.start("ratslam_lv", image_queue_size=2)
        templates = self.collected("LocalView/Template", ViewTemplate, connected=True)
        images = self.publisher("camera/image", Image)
        images.publish(self.image(0))
        self.assertTrue(harness.wait_until(lambda: len(templates) >= 1), node.output())
        node.process.send_signal(signal.SIGSTOP)  # as slow as a machine can be
        for index in range(1, 200):
            images.publish(self.image(index))
        time.sleep(0.5)
        node.process.send_signal(signal.SIGCONT)
        self.assertTrue(node.said(r"camera/image: images dropped, they come faster than they are processed; results are "
                                  r"[0-9.]+ s behind; image_queue_size: 0 keeps all, as a bag needs \([0-9]+ so far\)"),
                        node.output())
        last = harness.stamp(harness.frame_stamp(199))
        self.assertTrue(harness.wait_until(lambda: templates[-1].header.stamp == last), node.output())

    def test_cameras_that_do_not_stamp_are_stamped_by_arrival(self):
        node = self.start("ratslam_lv", stamp_source="arrival")
        templates = self.collected("LocalView/Template", ViewTemplate, connected=True)
        images = self.publisher("camera/image", Image)
        begin = rospy.Time.now()
        for index in range(3):
            images.publish(harness.image_message(self.frame(index), 0))
            self.assertTrue(harness.wait_until(lambda: len(templates) >= index + 1), node.output())
        stamps = [message.header.stamp for message in templates]
        self.assertTrue(begin <= stamps[0] < stamps[1] < stamps[2] <= rospy.Time.now())

    def test_remapping_the_images_carries_to_their_transport_and_calibration(self):
        node = self.start("ratslam_orb_vo", f"{self.root}/camera/image:=/usb{self.root}/image_raw", image_transport="compressed")
        odometry = self.collected("odom", Odometry, connected=True)
        info = CameraInfo(width=harness.WIDTH, height=harness.HEIGHT)
        info.K = [46.0, 0, 80, 0, 46.0, 30, 0, 0, 1]
        calibration = rospy.Publisher(f"/usb{self.root}/camera_info", CameraInfo, queue_size=10)
        images = rospy.Publisher(f"/usb{self.root}/image_raw/compressed", CompressedImage, queue_size=10)
        for publisher in (calibration, images):
            self.assertTrue(harness.wait_for_links(lambda p=publisher: p.get_num_connections() > 0), publisher.resolved_name)
        calibration.publish(info)
        images.publish(harness.compressed_message(self.frame(0), harness.frame_stamp(0)))
        self.assertTrue(harness.wait_until(lambda: len(odometry) >= 1), node.output())

    def test_encodings_of_one_picture_are_one_view(self):
        node = self.start("ratslam_lv")
        templates = self.collected("LocalView/Template", ViewTemplate, connected=True)
        images = self.publisher("camera/image", Image)
        grey = self.frame(0)
        colour = np.dstack([grey, grey, grey])
        with_alpha = np.dstack([colour, np.full_like(grey, 13)])
        deep = (grey.astype(np.uint16) * 257).view(np.uint8)
        variants = [(grey, "mono8", 0), (grey, "mono8", 7), (colour, "bgr8", 0), (colour, "rgb8", 11),
                    (with_alpha, "bgra8", 0), (with_alpha, "rgba8", 4)]
        messages = [harness.image_message(pixels, 0, encoding, padding) for pixels, encoding, padding in variants]
        messages.append(harness.image_message(deep, 0, "mono16"))
        messages[-1].width //= 2
        for index, message in enumerate(messages):  # another picture in between: the camera is not frozen
            message.header.stamp = harness.stamp(harness.frame_stamp(2 * index))
            images.publish(message)
            images.publish(harness.image_message(self.frame(40), harness.frame_stamp(2 * index + 1)))
        self.assertTrue(harness.wait_until(lambda: len(templates) >= 14), node.output())
        self.assertEqual({m.current_id for m in templates[::2]}, {0})
        # Behind the camera's frame the message says of which session its numbers are.
        self.assertEqual(templates[0].header.frame_id.split()[0], "camera")

    def test_unknown_encoding_and_another_size_are_skipped_by_name(self):
        node = self.start("ratslam_lv")
        templates = self.collected("LocalView/Template", ViewTemplate, connected=True)
        images = self.publisher("camera/image", Image)
        images.publish(self.image(0))
        self.assertTrue(harness.wait_until(lambda: len(templates) >= 1))
        images.publish(harness.image_message(self.frame(1), harness.frame_stamp(1), "32FC1"))
        self.assertTrue(node.said("image encoding '32FC1' is not supported"), node.output())
        images.publish(harness.image_message(self.frame(2)[:40], harness.frame_stamp(2)))
        images.publish(self.image(3))
        self.assertTrue(harness.wait_until(lambda: len(templates) >= 2))
        self.assertEqual(templates[-1].header.stamp, harness.stamp(harness.frame_stamp(3)))

    def test_image_size_change_is_said_clearly(self):
        node = self.start("ratslam_vo")
        odometry = self.collected("odom", Odometry, connected=True)
        images = self.publisher("camera/image", Image)
        images.publish(self.image(0))
        self.assertTrue(harness.wait_until(lambda: len(odometry) >= 1))
        images.publish(harness.image_message(self.frame(1)[:, :100], harness.frame_stamp(1)))
        self.assertTrue(node.said("size changed from 160x60 to 100x60"), node.output())

    def test_odometry_of_ours_is_complete(self):
        self.start("ratslam_vo", publish_tf="false")
        odometry = self.collected("odom", Odometry, connected=True)
        images = self.publisher("camera/image", Image)
        for index in range(5):
            images.publish(self.image(index))
        self.assertTrue(harness.wait_until(lambda: len(odometry) >= 5))
        last = odometry[-1]
        self.assertEqual(last.header.stamp, harness.stamp(harness.frame_stamp(4)))
        self.assertEqual((last.header.frame_id, last.child_frame_id), ("odom", "base_link"))
        # The strip moves right to left: the camera turns right, 6 px a frame of 120 deg over 160 px.
        self.assertAlmostEqual(last.twist.twist.angular.z, -math.radians(6 * 120.0 / 160.0) / 0.1, delta=0.02)
        self.assertGreater(last.twist.covariance[0], 0.0)
        self.assertGreater(last.twist.covariance[35], 0.0)
        self.assertGreater(last.pose.covariance[35], odometry[1].pose.covariance[35])
        self.assertNotEqual(last.pose.pose.orientation.w, 0.0)

    def test_odometry_that_is_not_finite_is_dropped_and_counted(self):
        node = self.start("ratslam_pc")
        states = self.collected("PoseCell/State", PoseCellState, connected=True)
        odometry = self.publisher("odom", Odometry)
        views = self.publisher("LocalView/Template", ViewTemplate)
        for index in range(5):
            at = harness.frame_stamp(index)
            odometry.publish(harness.odometry_message(at))
            odometry.publish(harness.odometry_message(at + 1000, speed=float("nan")))
            odometry.publish(harness.odometry_message(at + 2000, yaw_rate=float("inf")))
            views.publish(harness.view_message(index))
        self.assertTrue(harness.wait_until(lambda: len(states) >= 5), node.output())
        for state in states:
            self.assertTrue(all(math.isfinite(v) for v in (state.x, state.y, state.th)))
        self.assertEqual(node.count("odometry dropped: the speed is not finite"), 1, node.output())

    def test_actions_are_published_for_what_is_to_do_and_states_for_every_view(self):
        self.start("ratslam_pc")
        states = self.collected("PoseCell/State", PoseCellState, connected=True)
        actions = self.collected("PoseCell/TopologicalAction", TopologicalAction, connected=True)
        odometry = self.publisher("odom", Odometry)
        views = self.publisher("LocalView/Template", ViewTemplate)
        odometry.publish(harness.odometry_message(harness.frame_stamp(0) - 1000))
        for index in range(6):
            odometry.publish(harness.odometry_message(harness.frame_stamp(index), speed=0.0, yaw_rate=0.0))
            views.publish(harness.view_message(index, number=0))
        self.assertTrue(harness.wait_until(lambda: len(states) >= 6))
        self.assertEqual([s.action for s in states], [TopologicalAction.CREATE_NODE] + 5 * [0])
        self.assertTrue(harness.wait_until(lambda: len(actions) >= 1))
        self.assertEqual(len(actions), 1)
        self.assertEqual(actions[0].header.stamp, states[0].header.stamp)

    def test_time_that_jumps_back_is_one_warning_and_no_crash(self):
        node = self.start("ratslam_pc")
        states = self.collected("PoseCell/State", PoseCellState, connected=True)
        odometry = self.publisher("odom", Odometry)
        views = self.publisher("LocalView/Template", ViewTemplate)
        for turn in range(2):
            for index in range(15):
                odometry.publish(harness.odometry_message(harness.frame_stamp(index)))
                views.publish(harness.view_message(index))
            # Two connections keep no common order: the second turn must not overtake the first.
            self.assertTrue(harness.wait_until(lambda: len(states) >= 15 * (turn + 1)), node.output())
        self.assertEqual(node.count(r"odom: time went back"), 1, node.output())
        self.assertEqual(node.count(r"Template: time went back"), 1, node.output())

    def test_odometry_a_little_late_is_left_out(self):
        node = self.start("ratslam_pc")
        states = self.collected("PoseCell/State", PoseCellState, connected=True)
        odometry = self.publisher("odom", Odometry)
        views = self.publisher("LocalView/Template", ViewTemplate)
        for index in range(10):
            odometry.publish(harness.odometry_message(harness.frame_stamp(index)))
            if index == 5:
                odometry.publish(harness.odometry_message(harness.frame_stamp(3)))
            views.publish(harness.view_message(index))
        self.assertTrue(harness.wait_until(lambda: len(states) >= 10), node.output())
        self.assertEqual(node.count("older than the message before it"), 1, node.output())
        self.assertEqual(node.count("time went back"), 0, node.output())

    def test_covariances_that_cannot_be_are_named_once(self):
        node = self.start("ratslam_pc")
        states = self.collected("PoseCell/State", PoseCellState, connected=True)
        odometry = self.publisher("odom", Odometry)
        views = self.publisher("LocalView/Template", ViewTemplate)
        for index in range(5):
            message = harness.odometry_message(harness.frame_stamp(index))
            message.twist.covariance[0] = -1.0
            odometry.publish(message)
            views.publish(harness.view_message(index))
        self.assertTrue(harness.wait_until(lambda: len(states) >= 5), node.output())
        self.assertEqual(node.count(r"covariances that cannot be used .*\(0, 0\) = -1 is negative"), 1, node.output())

    def test_silent_odometry_does_not_stall_the_views(self):
        node = self.start("ratslam_pc", sync_timeout=0.5)
        states = self.collected("PoseCell/State", PoseCellState, connected=True)
        views = self.publisher("LocalView/Template", ViewTemplate)
        for index in range(3):
            views.publish(harness.view_message(index))
        self.assertTrue(harness.wait_until(lambda: len(states) >= 3), node.output())
        self.assertTrue(node.said(self.root + "/odom is silent"), node.output())

    def test_a_camera_that_stops_is_named_once(self):
        node = self.start("ratslam_pc", sync_timeout=0.5)
        odometry = self.publisher("odom", Odometry)
        views = self.publisher("LocalView/Template", ViewTemplate)
        for index in range(40):
            odometry.publish(harness.odometry_message(harness.frame_stamp(index)))
            if index < 20:
                views.publish(harness.view_message(index))
            time.sleep(0.1)
        self.assertTrue(node.said(self.root + "/LocalView/Template is silent while odometry goes on"), node.output())
        self.assertEqual(node.count("is silent while"), 1, node.output())
        self.assertEqual(node.count("is stamped"), 0, node.output())

    def test_clocks_that_disagree_are_named_with_the_difference(self):
        node = self.start("ratslam_pc")
        odometry = self.publisher("odom", Odometry)
        views = self.publisher("LocalView/Template", ViewTemplate)
        for index in range(60):
            # Messages of two topics arrive in any order, so that one side may be a message of 0.1 s ahead.
            odometry.publish(harness.odometry_message(harness.frame_stamp(index) - 900200000000))
            views.publish(harness.view_message(index))
            time.sleep(0.1)
        self.assertTrue(node.said(f"{self.root}/odom is stamped 900.[0-9] s behind {self.root}/LocalView/Template"), node.output())
        self.assertEqual(node.count("is stamped"), 1, node.output())

    def test_streams_in_step_are_not_complained_of(self):
        node = self.start("ratslam_pc")
        odometry = self.publisher("odom", Odometry)
        views = self.publisher("LocalView/Template", ViewTemplate)
        for index in range(50):
            odometry.publish(harness.odometry_message(harness.frame_stamp(index) - 500000000))
            views.publish(harness.view_message(index))
            time.sleep(0.1)
        self.assertEqual(node.count("is stamped"), 0, node.output())

    def test_a_second_odometry_and_a_second_broadcaster_are_named(self):
        suffix = self.root[1:]
        frames = {"odom_frame": "odom" + suffix, "base_frame": "base" + suffix}
        node = self.start("ratslam_em", **frames)
        self.start("ratslam_vo", **frames)
        wheels = self.publisher("odom", Odometry)
        images = self.publisher("camera/image", Image)
        broadcaster = rospy.Publisher("/tf", TFMessage, queue_size=10)
        transform = TransformStamped(child_frame_id=frames["base_frame"])
        transform.header.frame_id, transform.transform.rotation.w = frames["odom_frame"], 1.0
        for index in range(60):
            images.publish(self.image(index))
            wheels.publish(harness.odometry_message(harness.frame_stamp(index)))
            broadcaster.publish(TFMessage([transform]))
            time.sleep(0.1)
        ours = "ratslam_vo_" + suffix
        self.assertTrue(node.said(f"{self.root}/odom is published by .*{ours}"), node.output())
        self.assertTrue(node.said(f"odom{suffix} -> base{suffix} is broadcast by .*{ours}"), node.output())
        self.assertEqual(node.count("is published by"), 1, node.output())

    def test_publishers_of_which_the_master_failed_to_tell(self):
        """Its notice is replaced by one that names nobody."""
        node = self.start("ratslam_pc")
        odometry = self.publisher("odom", Odometry)
        known = rosgraph.Master(rospy.get_name())
        uri = known.lookupNode(self.named("/ratslam_pc"))
        xmlrpc.client.ServerProxy(uri).publisherUpdate("/master", odometry.resolved_name, [])
        self.assertTrue(harness.wait_until(lambda: odometry.get_num_connections() == 0), node.output())
        master.tell_subscribers(rospy.get_name())
        self.assertTrue(harness.wait_until(lambda: odometry.get_num_connections() == 1), node.output())
        master.tell_subscribers(rospy.get_name())  # nobody is connected twice
        time.sleep(1.0)
        self.assertEqual(odometry.get_num_connections(), 1)

    def test_a_publisher_that_stands_still_stays_connected_when_subscribers_are_told(self):
        cells = self.start("ratslam_pc")
        self.publisher("odom", Odometry)
        self.start("ratslam_em")
        link = (self.root + "/PoseCell/State", self.named("/ratslam_em"))
        self.assertTrue(harness.wait_for_links(lambda: link in harness.links(self.named("/ratslam_pc"))), cells.output())
        self.publisher("PoseCell/State", PoseCellState)  # one that does answer
        cells.process.send_signal(signal.SIGSTOP)
        master.tell_subscribers(rospy.get_name())
        uri = rosgraph.Master(rospy.get_name()).lookupNode(link[1])
        _, _, heard = xmlrpc.client.ServerProxy(uri).getBusInfo(rospy.get_name())
        self.assertEqual([topic for _, _, direction, _, topic, *_ in heard if direction == "i"].count(link[0]), 2)
        cells.process.send_signal(signal.SIGCONT)

    def test_every_node_tells_its_state(self):
        states = {}
        rospy.Subscriber("/diagnostics", DiagnosticArray,
                         lambda message: states.update({s.name: s for s in message.status}), queue_size=None)
        for name in ("ratslam_lv", "ratslam_vo", "ratslam_orb_vo", "ratslam_pc", "ratslam_em"):
            self.start(name)
        images = rospy.Publisher(self.root + "/camera/image", Image, queue_size=10)
        self.assertTrue(harness.wait_for_links(lambda: images.get_num_connections() == 3))
        for index in range(40):
            images.publish(self.image(index))
            time.sleep(0.1)

        def node(name, part):
            return f"ratslam_{name}_{self.root[1:]}: {part}"

        def value(name, key):
            return float({entry.key: entry.value for entry in states[name].values}[key])

        expected = {node(*words) for words in (
            ("lv", "images"), ("lv", "places"), ("lv", "memory"), ("vo", "images"), ("orb_vo", "visual odometry"),
            ("orb_vo", "images"), ("pc", "streams"), ("em", "map"), ("em", "memory"))}
        self.assertTrue(harness.wait_until(lambda: expected <= set(states)), sorted(states))
        self.assertTrue(harness.wait_until(lambda: value(node("lv", "images"), "used_images") == 40), states[node("lv", "images")])
        self.assertGreater(value(node("lv", "memory"), "resident memory [MB]"), 1.0)
        self.assertTrue(harness.wait_until(lambda: value(node("em", "map"), "experiences") > 0))
        self.assertEqual(states[node("orb_vo", "visual odometry")].message, "no calibration")

    def test_orb_odometry_without_calibration_says_how_to_supply_one(self):
        node = self.start("ratslam_orb_vo")
        odometry = self.collected("odom", Odometry, connected=True)
        images = self.publisher("camera/image", Image)
        images.publish(self.image(0))
        self.assertTrue(node.said(r"images wait for %s/camera/camera_info; publish a calibration there, or set camera_fx" %
                                  self.root), node.output())
        self.assertEqual(len(odometry), 0)
        info = CameraInfo(width=harness.WIDTH, height=harness.HEIGHT)
        info.K = [46.0, 0, 80, 0, 46.0, 30, 0, 0, 1]
        self.publisher("camera/camera_info", CameraInfo).publish(info)
        self.assertTrue(harness.wait_until(lambda: len(odometry) >= 1), node.output())
        self.assertEqual(odometry[0].header.stamp, harness.stamp(harness.frame_stamp(0)))

    def test_a_calibration_of_another_size_is_said_and_the_right_one_taken_when_it_comes(self):
        node = self.start("ratslam_orb_vo")
        odometry = self.collected("odom", Odometry, connected=True)
        infos = self.publisher("camera/camera_info", CameraInfo)
        infos.publish(CameraInfo(width=640, height=480, K=[500.0, 0, 320, 0, 500.0, 240, 0, 0, 1]))
        images = self.publisher("camera/image", Image)
        for index in range(5):
            images.publish(self.image(index))
        self.assertTrue(node.said(r"camera_info holds no usable calibration: it is for images of 640x480, they are of 160x60"),
                        node.output())
        infos.publish(CameraInfo(width=harness.WIDTH, height=harness.HEIGHT, K=[46.0, 0, 80, 0, 46.0, 30, 0, 0, 1]))
        self.assertTrue(harness.wait_until(lambda: len(odometry) == 5), node.output())
        infos.publish(CameraInfo(width=640, height=480, K=[500.0, 0, 320, 0, 500.0, 240, 0, 0, 1]))
        images.publish(harness.image_message(np.zeros((480, 640), np.uint8), harness.frame_stamp(5)))
        images.publish(self.image(6))
        self.assertTrue(harness.wait_until(lambda: len(odometry) == 6), node.output())

    def test_stream_that_never_comes_is_named_with_what_looks_like_it(self):
        elsewhere = rospy.Publisher("/wheels" + self.root, Odometry, queue_size=1)
        node = self.start("ratslam_pc")
        self.assertTrue(node.said(r"nothing has come on %s/odom \[nav_msgs/Odometry\] for 5 s.*%s" %
                                  (self.root, elsewhere.resolved_name)), node.output())
        self.assertTrue(node.said(r"nothing has come on %s/LocalView/Template" % self.root), node.output())

    def test_images_that_come_in_the_other_transport_are_named_with_the_parameter_that_reads_them(self):
        base = self.root
        for transport, ending, other, kind in (("raw", "", "compressed", CompressedImage), ("compressed", "/compressed", "raw", Image)):
            self.root = f"{base}/{transport}"
            came = rospy.Publisher(f"{self.root}/camera/image{'' if ending else '/compressed'}", kind, queue_size=1)
            node = self.start("ratslam_lv", image_transport=transport)
            hint = f"nothing has come on {self.root}/camera/image{ending} .* published are {came.resolved_name} .*"
            self.assertTrue(node.said(hint + f"_image_transport:={other}"), node.output())
            # The node's own pictures are images, too, and none to suggest.
            self.assertEqual(node.count(r"published are .*LocalView"), 0, node.output())
            self.ends_well(node)


if __name__ == "__main__":
    rostest.rosrun("ratslam_ros", "streams", Streams, sys.argv)
