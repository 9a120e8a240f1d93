#!/usr/bin/python3
"""What suggest_parameters is worth on drives of several kinds: docs/tuning.md's table.

Each drive is run with a configuration from which image crop, threshold, size of the cells and injected energy have been taken
out, so that the defaults apply, and again with what suggest_parameters proposes for it. Errors are those of the final map,
aligned by similarity, mean [m]; of laps without a truth, how far each is from the one before it, in percent of their size.

Usage: suggestions.py DATA [--out FOLDER] [--drives NAME ...]     DATA holds kitti_00/, nordland/ and donkey_lab_laps/; a drive
whose data is not there is left out, and said so. Figures come from runs of this tree's programs."""
import argparse
import os
import subprocess
import sys

import numpy as np

SOURCE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.realpath(__file__))))
SCRIPTS = os.path.join(SOURCE, "scripts")
sys.path.insert(0, SCRIPTS)

from ratslam_tools.datasets import flat_yaml, truth  # noqa: E402
from ratslam_tools.errors import InputError  # noqa: E402
from ratslam_tools.evaluation import comparison, metrics  # noqa: E402
from ratslam_tools.runs import run_folder, runner  # noqa: E402
from ratslam_tools.table import format_table  # noqa: E402
from ratslam_tools.trajectory import Trajectory, frames, geometry, write_kitti  # noqa: E402

FOUND = ("image_crop_x_min", "image_crop_x_max", "image_crop_y_min", "image_crop_y_max", "pc_cell_x_size", "exp_recall_sigma",
         "vt_match_threshold", "vt_orientation_threshold", "pc_vt_inject_energy")
LAP_S = 17.0  # of the small robot car


def ring(data, out, lap=400, second=350):
    """The Nordland railway as a ring of `lap` metres: a lap of the summer and most of one of the winter, a metre an image. The
    odometry is 2 % too long and turns by 0.002 rad an image too much or too little."""
    folder = os.path.join(data, "nordland")
    names = sorted(os.listdir(os.path.join(folder, "summer")))
    os.makedirs(os.path.join(out, "image_0"))
    for number in range(lap + second):
        season = "summer" if number < lap else "winter"
        source = os.path.join(folder, season, names[number % lap])
        os.symlink(os.path.abspath(source), os.path.join(out, "image_0", f"{number:06d}.png"))
    angle = 2.0 * np.pi / lap * np.arange(lap + second)
    stamps = 0.1 * np.arange(lap + second)
    radius = lap / (2.0 * np.pi)
    positions = radius * np.stack([np.sin(angle), 1.0 - np.cos(angle), np.zeros_like(angle)], axis=1)
    rotations = np.array([geometry.rotation_about_z(yaw) for yaw in angle])
    write_kitti(os.path.join(out, "poses.txt"), frames.convert(Trajectory(positions, rotations, stamps, "ring"), "base", "camera"))
    np.savetxt(os.path.join(out, "times.txt"), stamps, fmt="%.9f")
    noise = np.random.RandomState(1).normal(0.0, 0.002, len(angle))
    with open(os.path.join(out, "odometry.csv"), "w", encoding="utf-8") as file:
        file.write("frame,stamp,linear_x,angular_z\n")
        for number, stamp in enumerate(stamps):
            turn = 2.0 * np.pi / lap + noise[number]
            file.write(f"{number},{stamp:.9f},{10.2 if number else 0.0:g},{turn / 0.1 if number else 0.0:.9f}\n")


def town(_, out):
    words = [os.path.join(os.path.dirname(runner.find()), "ratslam_town"), "--layout", "kitti", "--out", out]
    runner.Runner().run(words + ["--frames", "600", "--size", "620x188"])


def laps(data, out):
    words = [os.path.join(SCRIPTS, "donkey_to_kitti"), os.path.join(data, "donkey_lab_laps"), out, "--run", "2129:5014"]
    runner.Runner().run([sys.executable, *words])


# name: (folder of DATA that it needs, maker of the recording or None, configuration, odometry, more settings)
DRIVES = {
    "kitti": ("kitti_00", None, "kitti_orb.yaml", "orb"),
    "kitti_profile": ("kitti_00", None, "kitti.yaml", "profile"),
    "town": (None, town, "demo.yaml", "orb"),
    "nordland": ("nordland", ring, "kitti_orb.yaml", "odometry.csv"),
    "nordland_nearest": ("nordland", ring, "kitti.yaml", "odometry.csv"),
    "laps": ("donkey_lab_laps", laps, "donkey.yaml", "odometry.csv"),
}


def lap_gap(estimate):
    """Distance of each pose to the lap before, mean, in percent of the root-mean-square distance from the middle."""
    places, stamps = estimate.positions[:, :2], estimate.stamps
    size = np.sqrt(((places - places.mean(axis=0)) ** 2).sum(axis=1).mean())
    gaps = []
    for place, stamp in zip(places, stamps):
        before = places[(stamps > stamp - 1.5 * LAP_S) & (stamps < stamp - 0.5 * LAP_S)]
        if len(before) and stamp > stamps[0] + 1.5 * LAP_S:
            gaps.append(np.linalg.norm(before - place, axis=1).min())
    return 100.0 * np.mean(gaps) / size


def error_of(run, recording):
    """As it stands in the table."""
    if not os.path.isfile(os.path.join(recording, "poses.txt")):
        return f"{lap_gap(run.final):.1f} %"
    settings = comparison.Settings(align=True, correct_scale=True)
    compared = comparison.compare(truth.read_truth(recording), run.final, settings, needs_body=False)
    return f"{metrics.statistics(metrics.ape(compared.reference, compared.estimate))['mean']:.3g} m"


def row(name, data, out):
    needs, make, config, odometry = DRIVES[name]
    recording = os.path.join(data, needs or "")
    if make:
        recording = os.path.join(out, make.__name__)
        if not os.path.isdir(recording):
            make(data, recording)
    if odometry.endswith(".csv"):
        odometry = os.path.join(recording, odometry)
    stripped = os.path.join(out, name + ".yaml")
    with open(stripped, "w", encoding="utf-8") as file:
        given = flat_yaml.read(runner.find_config(config))
        file.writelines(f"{key}: {value}\n" for key, value in given.items() if key not in FOUND)
    proposed = os.path.join(out, name + "_found.yaml")
    trials = os.path.join(out, name + "_trials")
    subprocess.run([sys.executable, os.path.join(SCRIPTS, "suggest_parameters"), recording, "--config", stripped, "--odometry", odometry,
                    "--out", trials, "--yaml", proposed], check=True, stdout=subprocess.DEVNULL)
    settings = flat_yaml.read(proposed)
    cells = [name, config, " ".join(f"{key}={value}" for key, value in settings.items())]
    for part, changed in (("defaults", {}), ("proposed", settings)):
        folder = os.path.join(out, f"{name}_{part}")
        run = run_folder.Run(runner.run_once(runner.command(runner.find(), recording, stripped, folder, changed, odometry), folder))
        counts = run.summary["counts"]
        cells += [error_of(run, recording), f"{counts['templates']}, {counts['experiences']}, {len(run.map.loop_ends)}"]
    return cells


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", help="folder of the data sets")
    parser.add_argument("--out", default=os.path.join(SOURCE, "out", "endurance", "suggestions"),
                        help="folder for recordings and runs (default: %(default)s)")
    parser.add_argument("--drives", nargs="+", choices=sorted(DRIVES), default=list(DRIVES))
    options = parser.parse_args()
    os.makedirs(options.out, exist_ok=True)
    rows = [["drive", "configuration", "proposed", "error before", "templates, experiences, recalls", "error after", "counts"]]
    for name in options.drives:
        needs = DRIVES[name][0]
        if needs and not os.path.isdir(os.path.join(options.data, needs)):
            print(f"{name}: left out, there is no {os.path.join(options.data, needs)}")
            continue
        rows.append(row(name, options.data, options.out))
        print(f"{name}: done", flush=True)
    print(format_table(rows))


if __name__ == "__main__":
    try:
        main()
    except InputError as error:
        sys.exit(f"suggestions.py: {error}")
