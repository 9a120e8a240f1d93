"""A route past identical houses, driven again and again: no place is taken for another one that looks the same."""

import os
import subprocess

import numpy as np

from conftest import SOURCE, built

LATER = 100  # frames since a place was learned, from which on it is recalled and not still in view
SAME_PLACE = 3.0  # [m]; the houses stand 12 m apart


def test_no_place_is_taken_for_another(tmp_path):
    run, town = built("ratslam_town")
    quiet = {"check": True, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    drive = tmp_path / "town"
    subprocess.run([town, "--out", drive, "--identical-houses", "--frames", "600", "--size", "620x188"], **quiet)
    crop = ("--set", "image_crop_y_min=30", "--set", "image_crop_y_max=150")
    config = os.path.join(SOURCE, "config", "demo.yaml")
    subprocess.run([run, drive, "--config", config, "--odometry", "orb", *crop, "--out", tmp_path / "run"], **quiet)

    places = np.loadtxt(drive / "poses.txt").reshape(-1, 3, 4)[:, :, 3]
    learned, errors = {}, []
    views = np.loadtxt(tmp_path / "run" / "templates.csv", delimiter=",", skiprows=1, usecols=1).astype(int)
    assert len(views) == len(places)
    for frame, number in enumerate(views):
        first = learned.setdefault(number, frame)
        if number >= 0 and frame - first > LATER:
            errors.append(np.linalg.norm(places[frame] - places[first]))
    assert len(errors) > 50, "it drives the same way again, and recalls it"
    assert max(errors) < SAME_PLACE
