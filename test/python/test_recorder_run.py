"""A phone's recording, rendered, from its folder to figures against GPS: through a bag and directly."""

import filecmp
import json
import os
import subprocess

import pytest

from conftest import SOURCE, built

FRAMES = 70
RESULTS = ("trajectory_online.tum", "trajectory_final.tum", "map.yaml", "templates.csv", "actions.csv")


@pytest.fixture(scope="module")
def programs():
    """ratslam_run and ratslam_town; skips where they are not built."""
    return built("ratslam_town")


def call(*words):
    return subprocess.run(list(map(str, words)), check=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)


def test_recording_gives_the_same_map_directly_and_through_a_bag_and_gps_judges_it(programs, tmp_path, run):
    program, town = programs
    call(
        *(town, "--layout", "recorder", "--out", tmp_path / "drive", "--frames", FRAMES),
        *("--size", "640x480", "--calibration", "500,500,320,240"),
        *("--distortion=-0.2,0.05,0.0005,-0.0005,0", "--gps-noise", "0.5"),
    )
    (index,) = (tmp_path / "drive").glob("*/data_image.txt")
    calibration = tmp_path / "drive" / "calibration.yaml"
    # What a phone leaves: a stamp that repeats and a line cut off.
    lines = index.read_text().splitlines()
    index.write_text("\n".join([lines[1], *lines, lines[-1][:7]]))
    words = ("--config", os.path.join(SOURCE, "config", "kitti_orb.yaml"), "--odometry", "orb")
    settings = ("--set", "image_crop_y_min=120", "--set", "image_crop_y_max=360")
    converted = run(
        "recorder_to_bag",
        *(index.parent, tmp_path / "nn.bag", "--calibration", calibration),
        *("--gps_tum", tmp_path / "gps.tum"),
    )
    assert converted.returncode == 0 and f"{FRAMES} images" in converted.stdout, converted
    call(program, tmp_path / "nn.bag", *words, *settings, "--out", tmp_path / "bag")
    call(program, index.parent, *words, *settings, "--calibration", calibration, "--out", tmp_path / "folder")
    for name in RESULTS:
        assert filecmp.cmp(tmp_path / "bag" / name, tmp_path / "folder" / name, shallow=False), name

    final = tmp_path / "folder" / "trajectory_final.tum"
    saved = tmp_path / "ape.json"
    judged = run(
        *("evaluate_ape", tmp_path / "gps.tum", final, "-as", "--t_max_diff", "0.06"),
        *("--save_results", saved),
    )
    assert judged.returncode == 0, judged
    assert json.loads(saved.read_text())["results"][0]["stats"]["mean"] < 1.5
    exact = ("--ref_frame", "camera", "--est_frame", "base", "--save_results", saved)
    judged = run("evaluate_ape", tmp_path / "drive" / "truth.tum", final, "-as", *exact)
    assert judged.returncode == 0, judged
    assert json.loads(saved.read_text())["results"][0]["stats"]["mean"] < 0.5


def test_recording_without_calibration_is_told_what_is_missing(programs, tmp_path):
    program, town = programs
    call(town, "--layout", "recorder", "--out", tmp_path / "drive", "--frames", 2, "--size", "320x240")
    (index,) = (tmp_path / "drive").glob("*/data_image.txt")
    failed = subprocess.run(
        [program, index.parent, "--odometry", "orb", "--out", tmp_path / "run", "--set", "vt_shift_match=0"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        universal_newlines=True,
        check=False,
    )
    assert failed.returncode == 1 and "--calibration FILE" in failed.stderr and failed.stderr.count("\n") == 1
