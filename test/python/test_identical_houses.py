"""A route past identical houses, and one round corners that look alike, driven again and again: no place is taken for another
one that looks the same."""

import os
import subprocess

import numpy as np
import pytest

from conftest import SOURCE, built

LATER = 100  # frames since a place was learned, from which on it is recalled and not still in view
SAME_PLACE = 3.0  # [m]; the houses stand 12 m apart


CROP = ("--set", "image_crop_y_min=30", "--set", "image_crop_y_max=150")
QUIET = {"check": True, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}


def drive_through(folder, *options):
    """Renders a drive along the built-in circuit; the program that maps it."""
    run, town = built("ratslam_town")
    subprocess.run([town, "--out", folder, "--frames", "600", "--size", "620x188", *options], **QUIET)
    return run


def poses_of(drive):
    return np.loadtxt(drive / "poses.txt").reshape(-1, 3, 4)


def distances_of_recalls(drive, run):
    """Of each view that was recalled: how far it is from where it was learned [m]."""
    places, learned, errors = poses_of(drive)[:, :, 3], {}, []
    views = np.loadtxt(run / "templates.csv", delimiter=",", skiprows=1, usecols=1).astype(int)
    assert len(views) == len(places)
    for frame, number in enumerate(views):
        first = learned.setdefault(number, frame)
        if number >= 0 and frame - first > LATER:
            errors.append(np.linalg.norm(places[frame] - places[first]))
    return errors


def test_no_place_is_taken_for_another(tmp_path):
    run = drive_through(tmp_path / "town", "--identical-houses")
    config = os.path.join(SOURCE, "config", "demo.yaml")
    subprocess.run([run, tmp_path / "town", "--config", config, "--odometry", "orb", *CROP, "--out", tmp_path / "run"], **QUIET)
    errors = distances_of_recalls(tmp_path / "town", tmp_path / "run")
    assert len(errors) > 50, "it drives the same way again, and recalls it"
    assert max(errors) < SAME_PLACE


@pytest.mark.parametrize("seed", ["1", "4"])
def test_corners_that_look_alike_are_told_apart_without_help_of_the_odometry(tmp_path, seed):
    # It does not say how well it knows its way: dead reckoning excludes little in so small a town.
    run = drive_through(tmp_path / "town", "--seed", seed)
    poses = poses_of(tmp_path / "town")
    stamps = np.loadtxt(tmp_path / "town" / "times.txt")
    steps = np.linalg.norm(np.diff(poses[:, :, 3], axis=0, prepend=poses[:1, :, 3]), axis=1)
    headings = np.unwrap(np.arctan2(-poses[:, 0, 2], poses[:, 2, 2]))
    rates = 1.0 / np.diff(stamps, prepend=stamps[0] - 1.0)
    rows = np.stack([np.arange(len(stamps)), stamps, steps * rates, np.diff(headings, prepend=headings[0]) * rates], axis=1)
    np.savetxt(tmp_path / "odometry.csv", rows, "%.9f", ",", header="frame,stamp,linear_x,angular_z", comments="")
    config = os.path.join(SOURCE, "config", "demo.yaml")
    subprocess.run([run, tmp_path / "town", "--config", config, "--odometry", tmp_path / "odometry.csv", *CROP,
                    "--out", tmp_path / "run"], **QUIET)
    errors = distances_of_recalls(tmp_path / "town", tmp_path / "run")
    assert len(errors) > 50, "it drives the same way again, and recalls it"
    assert max(errors) < SAME_PLACE
