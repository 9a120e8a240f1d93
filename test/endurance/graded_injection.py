#!/usr/bin/python3
"""Equation (3) with all view cells at once: every learned view injects at its pose cells as far as it looks like the
present one, and the attractor, moved by odometry, decides where the robot is. Prints what is recalled in that way, beside
scripts/evaluate_places, which asks `vt_recall: belief` the same questions in the same measure.

One recording (KITTI folder, ORB odometry, --truth), or a pass of a route and another one of it, image for image, each
image one metre on.

Each frame: the network takes the odometry's step; learned views older than --min-gap, of two passes those of the first,
inject --energy in all, view i the share exp(s z_i) of it (z: likeness standardised over them, s: --sharpness; one more
share is that of a place not yet known, UNKNOWN_Z); the packet's new place is the answer: of the views learned within a cell
of it, the one most alike, as sure as these views' shares.
"""
import argparse
import os
import sys
import tempfile

import numpy as np

HERE = os.path.dirname(os.path.realpath(__file__))
SOURCE = os.path.join(HERE, "..", "..")
sys.path[:0] = [os.path.join(SOURCE, "scripts"), os.path.join(SOURCE, "devel", "lib", "python3", "dist-packages")]

import cv2  # noqa: E402
import ratslam  # noqa: E402
import yaml  # noqa: E402

from ratslam_tools.datasets.images import list_images  # noqa: E402
from ratslam_tools.datasets.odometry_file import read_odometry  # noqa: E402
from ratslam_tools.datasets.truth import read_plane_poses  # noqa: E402
from ratslam_tools.evaluation import places  # noqa: E402
from ratslam_tools.runs import runner  # noqa: E402

UNKNOWN_Z = 0.8  # likeness, standardised, of a place not yet known
WITHIN = 1.0  # cells from the packet


def odometry_of(options, times):
    """Way [m] and turn [rad] up to each frame, by ORB odometry."""
    with tempfile.TemporaryDirectory() as folder:
        runner.Runner().run(runner.command(runner.find(), options.recording, options.config, folder, odometry="orb"))
        rows = read_odometry(os.path.join(folder, "odometry.csv"))
    steps = np.diff(rows[:, 1], prepend=rows[0, 1])[:, None] * rows[:, 2:4]
    return np.stack([np.interp(times, rows[:, 1], np.cumsum(steps[:, k])) for k in (0, 1)], axis=1)


def likenesses(images, config):
    """Of each frame to all views learned so far, the largest over the shifts; and the frames at which they were learned."""
    views = {key: value for key, value in config.items() if key.split("_")[0] in ("vt", "template", "image")}
    views.update(vt_descriptor="orientation", vt_recall="nearest", vt_match_threshold=0.0)  # learns each frame
    cells, rows, learned_at = ratslam.LocalViewCells(**views), [], []
    for frame, path in enumerate(images):
        if cells.observe(frame, cv2.imread(path, cv2.IMREAD_GRAYSCALE)).learned:  # all but repeated images
            learned_at.append(frame)
        rows.append(cells.likeness.max(axis=0))
    return rows, np.array(learned_at)


def answers_of(rows, learned_at, ways, last_old, config, energy, sharpness):
    """last_old: of each frame, the last one that may be an answer."""
    network = ratslam.PoseCellNetwork(**{key: value for key, value in config.items() if key.startswith("pc_")})
    size = np.array([network.parameters["pc_dim_th"], network.parameters["pc_dim_xy"], network.parameters["pc_dim_xy"]])
    packets, answers = np.zeros((len(rows), 3)), []
    for frame, row in enumerate(rows):
        step = ways[frame] - ways[max(frame - 1, 0)]
        network.step(float(step[0]), float(step[1]))
        old, place, score = row[:np.searchsorted(learned_at, last_old[frame] + 1)].astype(float), -1, -np.inf
        learned = packets[learned_at[:len(old)]]
        if len(old) >= 20:
            z = (old - old.mean()) / max(old.std(), 1e-6)
            shares = np.exp(sharpness * z)
            shares /= shares.sum() + len(old) * np.exp(sharpness * UNKNOWN_Z)
            cells, where = np.unique(np.rint(learned).astype(int) % size, axis=0, return_inverse=True)
            for (heading, y, x), share in zip(cells, np.bincount(where.ravel(), weights=shares)):
                network.inject(int(heading), int(y), int(x), float(energy * share))
            network.attract()
            network.step(0.0, 0.0)  # the estimate follows
            apart = np.abs(learned - packet(network))
            near = (np.minimum(apart, size - apart) <= WITHIN).all(axis=1)
            if near.any():
                place, score = int(learned_at[np.where(near, shares, -1.0).argmax()]), float(shares[near].sum())
        packets[frame] = packet(network)
        answers.append((frame, place, score))
    frames, found, scores = (np.array(column) for column in zip(*answers))
    return places.Answers(frames, found, scores, np.zeros(len(frames), bool))


def packet(network):
    estimate = network.estimate
    return np.array([estimate.th, estimate.y, estimate.x])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recording", help="KITTI sequence folder, or folder of the images of a pass")
    parser.add_argument("query", nargs="?", help="folder of the images of another pass")
    parser.add_argument("--truth", help="true poses of the one recording")
    parser.add_argument("--config", required=True, help="crop, view and pose cells")
    parser.add_argument("--radius", type=float, default=3.0, help="distance of a right place [m]")
    parser.add_argument("--tolerance", type=int, default=1, help="two passes: images that a right answer may be off")
    parser.add_argument("--min-gap", type=int, default=100, help="frames that a revisit lies apart")
    parser.add_argument("--energy", type=float, nargs="+", default=[0.05, 0.15, 0.5, 1.5])
    parser.add_argument("--sharpness", type=float, nargs="+", default=[0.7, 1.5, 3.0])
    options = parser.parse_args()
    if (options.query is None) == (options.truth is None):
        parser.error("one recording needs --truth, two passes have none")
    with open(options.config, encoding="utf-8") as file:
        config = yaml.safe_load(file)
    if options.query:
        first, second = list_images(options.recording), list_images(options.query)
        config = {key: value for key, value in config.items() if not key.startswith("image_crop")}
        ways = np.stack([np.arange(len(first) + len(second)), np.zeros(len(first) + len(second))], axis=1)
        rows, learned_at = likenesses(first + second, config)
        last_old = np.repeat([-1, len(first) - 1], [len(first), len(second)])
        first_asked = len(first)
    else:
        ways = odometry_of(options, np.loadtxt(os.path.join(options.recording, "times.txt")))
        rows, learned_at = likenesses(list_images(os.path.join(options.recording, "image_0")), config)
        last_old = np.arange(len(rows)) - options.min_gap
        first_asked = 0
    print("| energy | sharpness | right at rank 1 | AUC | recall at 100 % precision |\n|---|---|---|---|---|")
    for energy in options.energy:
        for sharpness in options.sharpness:
            scores = judged(options, answers_of(rows, learned_at, ways, last_old, config, energy, sharpness), first_asked)
            print(f"| {energy:g} | {sharpness:g} | {100 * scores.right_at_1:.1f} % | {100 * scores.auc:.1f} | "
                  f"{100 * scores.recall_at_100:.1f} % |", flush=True)


def judged(options, answers, first_asked):
    """first_asked: frame of the first question, that of the second pass."""
    if not options.query:
        truth = read_plane_poses(options.truth)
        return places.score(answers, *places.by_truth(answers, *truth, options.radius, options.min_gap))
    asked = answers.frame >= first_asked
    answers = places.Answers(answers.frame[asked] - first_asked, answers.place[asked], answers.score[asked], answers.claimed[asked])
    return places.score(answers, *places.by_index(answers, options.tolerance, first_asked))


if __name__ == "__main__":
    main()
