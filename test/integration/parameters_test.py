#!/usr/bin/python3
"""Bad parameters end a node with exit code 1 and one line that says what is wrong, and where it came from."""
import os
import sys

import rospy
import rostest
from sensor_msgs.msg import Image

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import harness  # noqa: E402  (lies beside this file)

NODES = ("ratslam_lv", "ratslam_pc", "ratslam_em", "ratslam_vo", "ratslam_orb_vo")


class Parameters(harness.FolderTest):
    def start(self, name, *arguments, **parameters):
        return self.keep(harness.start_node(name, *arguments, **parameters))

    def assert_fatal(self, node, *parts):
        self.assertEqual(node.ended(), 1, node.output())
        fatal = [line for line in node.lines if "FATAL" in line]
        self.assertEqual(len(fatal), 1, node.output())
        for part in parts:
            self.assertIn(part, fatal[0])

    def test_misspelt_key_in_every_node(self):
        for name in NODES:
            node = self.start(name, f"__name:=misspelt_{name}", pc_dim_xyz=3)
            self.assert_fatal(node, "pc_dim_xyz", f"/misspelt_{name}/pc_dim_xyz", "pc_dim_xy?")

    def test_wrong_type(self):
        self.assert_fatal(self.start("ratslam_pc", pc_dim_xy="wide"), "pc_dim_xy", "wide", "whole number")

    def test_names_that_are_none(self):
        for name in NODES:
            self.assert_fatal(self.start(name, "__ns:=r 1"), name, "[/r 1] is invalid")
            self.assert_fatal(self.start(name, "__name:=a/b"), name, "a/b")

    def test_out_of_range(self):
        self.assert_fatal(self.start("ratslam_pc", pc_dim_xy=0), "pc_dim_xy: value 0", "[1, 4096]")
        self.assert_fatal(self.start("ratslam_em", exp_correction=0.75), "exp_correction: value 0.75", "0.5")
        self.assert_fatal(self.start("ratslam_vo", camera_fov_deg=-3), "camera_fov_deg: value -3")

    def test_frames_that_tf_cannot_connect(self):
        self.assert_fatal(self.start("ratslam_vo", "__name:=vo_of_a_circle", base_frame="odom"), "base_frame: value 'odom'", "odom_frame")
        self.assert_fatal(self.start("ratslam_orb_vo", "__name:=vo_of_a_slash", camera_frame="/cam"), "camera_frame: value '/cam'",
                          "leading slash")

    def test_only_localising_needs_a_map(self):
        for name in NODES:
            self.assert_fatal(self.start(name, self.config, f"__name:=localise_{name}", localise_only=True), "localise_only", "map_dir")

    def test_a_part_of_a_calibration(self):
        self.assert_fatal(self.start("ratslam_orb_vo", "__name:=part", camera_distortion="[0.1, 0.2]"), "camera_distortion",
                          "camera_fx")

    def test_missing_configuration_file(self):
        self.assert_fatal(self.start("ratslam_em", "/nowhere/config.txt"), "/nowhere/config.txt", "cannot open")

    def test_misspelt_key_in_a_file_names_its_line(self):
        path = self.path("bad.yaml")
        with open(path, "w", encoding="utf-8") as file:
            file.write("exp_loops: 5\nexp_lops: 6\n")
        self.assert_fatal(self.start("ratslam_em", path), "exp_lops", "bad.yaml:2", "exp_loops?")

    def test_private_parameters_override_the_file(self):
        self.assert_fatal(self.start("ratslam_pc", self.config, pc_dim_xy=0), "pc_dim_xy: value 0")

    def test_a_parameter_that_counts_more_than_the_file_is_named(self):
        path = self.path("with_a_list.yaml")
        harness.write_config(path, camera_distortion=[0.1, 0.2, 0, 0])
        rospy.set_param("/overridden/camera_distortion", [0.1, 0.3, 0, 0])
        node = self.start("ratslam_pc", path, "__name:=overridden", pc_dim_xy=13, pc_cell_x_size=0.5)
        self.assertTrue(node.said(r"pc_dim_xy: 13 counts, not 11 of \S+:[0-9]+; .*rosparam delete /overridden/pc_dim_xy"), node.output())
        self.assertTrue(node.said(r"camera_distortion: \[0.1, 0.3, 0, 0\] counts, not \[0.1, 0.2, 0, 0\] of"), node.output())
        self.assertNotIn("pc_cell_x_size", node.output())  # as in the file

    def test_crop_outside_the_image_and_smaller_than_the_template(self):
        publisher = rospy.Publisher("camera/image", Image, queue_size=10)
        for changes, parts in (({"image_crop_x_max": 1000}, ("image_crop_x_max", "1000")),
                               ({"image_crop_x_max": 10}, ("template_x_size", "20"))):
            path = self.path("crop.yaml")
            harness.write_config(path, **changes)
            node = self.start("ratslam_lv", path)
            self.assertTrue(harness.wait_for_links(lambda: publisher.get_num_connections() == 1), node.output())
            publisher.publish(harness.image_message(harness.frame(harness.panorama(), 0), harness.START_NS))
            # The image is refused in one line, and the node waits for one that suits.
            self.assertTrue(harness.wait_until(lambda: all(part in node.output() for part in parts)), node.output())
            self.assertIn("image skipped", node.output())
            self.assertEqual(node.interrupt(), 0, node.output())
            self.assertTrue(harness.wait_until(lambda: publisher.get_num_connections() == 0))


if __name__ == "__main__":
    rostest.rosrun("ratslam_ros", "parameters", Parameters, sys.argv)
