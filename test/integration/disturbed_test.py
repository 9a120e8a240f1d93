#!/usr/bin/python3
"""A drive that is disturbed as real ones are - a gap, a blind, a frozen, a covered camera, a late image - with the ORB
odometry: nodes and ratslam_run leave the same map."""
import os
import sys

import cv2
import numpy as np
import rostest

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import broken_recordings  # noqa: E402  (lies beside this file)
import broken_test  # noqa: E402
import harness  # noqa: E402

FRAMES, SIZE, FOCAL = 110, (480, 160), 280.0
START = 1000 * broken_recordings.SECOND
CAMERA = {"camera_fx": FOCAL, "camera_fy": FOCAL, "camera_cx": 239.5, "camera_cy": 70.0, "camera_width_px": SIZE[0],
          "camera_height_px": SIZE[1], "camera_height": 1.65, "orb_features": 1000, "orb_init_points": 40, "exp_scale": 1,
          "exp_height": 1}


def disturbed(shots):
    black = broken_recordings.png(np.zeros((SIZE[1], SIZE[0]), np.uint8))
    for index in range(25, 40):
        shots[index].data = black
    for index in range(50, 60):
        shots[index].data = shots[49].data
    for index in range(70, 75):
        image = cv2.imdecode(np.frombuffer(shots[index].data, np.uint8), cv2.IMREAD_GRAYSCALE)
        image[:, :2 * SIZE[0] // 3] = 0
        shots[index].data = broken_recordings.png(image)
    shots[95], shots[96] = shots[96], shots[95]
    return shots[:80] + shots[90:]


class Disturbed(broken_test.Broken):
    ODOMETRY = ("orb_vo", "orb")

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        harness.write_config(cls.config, **CAMERA)

    def test_nodes_and_runner_agree_on_bags_and_folders(self):
        town = self.path("town")
        harness.write_town(town, "--frames", str(FRAMES), "--size", "480x160", "--calibration", f"{FOCAL},{FOCAL},239.5,70")
        shots = []
        for index in range(FRAMES):
            shots.append(broken_recordings.Shot(START + index * 100000000, data=harness.contents(f"{town}/image_0/{index:06d}.png")))
        shots = disturbed(shots)
        bag, folder = self.path("disturbed.bag"), self.path("disturbed")
        broken_recordings.write_bag(bag, shots)
        run, counts, trajectories, decisions = self.run_offline(bag, "disturbed")
        self.assertEqual(run.returncode, 0, run.stdout)
        self.assertEqual((counts["frames"], counts["late_images"], counts["frozen_images"], counts["blank_images"]),
                         (len(shots), 1, 14 + 10, 1), run.stdout)
        self.assertEqual(len(trajectories[1].splitlines()), counts["used_images"])
        broken_recordings.write_folder(folder, shots)
        self.assertEqual(self.run_offline(folder, "disturbed_folder")[2], trajectories)
        node_counts, node_trajectories, words = self.run_nodes("disturbed", shots, decisions)
        self.assertEqual(node_trajectories, trajectories, words)
        known = [key for key in counts if key.endswith("_images")]
        for one in node_counts:
            self.assertEqual({key: one[key] for key in known}, {key: counts[key] for key in known}, words)


if __name__ == "__main__":
    rostest.rosrun("ratslam_ros", "disturbed", Disturbed, sys.argv)
