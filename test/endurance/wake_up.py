#!/usr/bin/python3
"""Maps the first frames of a recording, then wakes up at many of its later frames that see mapped places again, without
knowing where, and prints how often the place was found, after how many frames, and how often it was taken for another.
Exits with 1 where it was.

A place counts as found with the first recall, and as another one where the true poses lie farther than --radius apart."""
import argparse
import csv
import os
import sys
import tempfile

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "..", "scripts"))

from ratslam_tools.datasets.truth import read_plane_poses  # noqa: E402
from ratslam_tools.errors import InputError  # noqa: E402
from ratslam_tools.runs import runner  # noqa: E402

CREATED, RECALLED = "1", ("2", "3")
CLOSE = 50  # frames


def actions(folder):
    with open(os.path.join(folder, "actions.csv"), encoding="utf-8") as file:
        return list(csv.DictReader(file))


def revisits(options, positions, headings):
    """Later frames that lie within half the radius of a mapped one, and face as it does: evenly spaced ones. What follows the
    end of the map at once goes on in it, knowing where it is, and what is near its end alone does not come back.
    """
    mapped = slice(0, max(options.map_frames - CLOSE, 0))
    found = []
    for frame in range(options.map_frames + CLOSE, len(positions) - options.frames):
        near = np.linalg.norm(positions[mapped] - positions[frame], axis=1) < options.radius / 2.0
        if np.any(near & (np.cos(headings[mapped] - headings[frame]) > 0.7)):
            found.append(frame)
    if not found:
        raise InputError(f"{options.recording}: no frame after the first {options.map_frames} sees them again")
    return [found[k] for k in np.unique(np.linspace(0, len(found) - 1, options.starts).astype(int))]


def run(options, folder):
    positions, headings = read_plane_poses(options.truth)
    with open(os.path.join(options.recording, "times.txt"), encoding="utf-8") as file:
        times = np.array([float(line) for line in file])

    def frame_of(row):
        return int(np.argmin(np.abs(times - float(row["stamp"]))))

    words = [runner.find(), options.recording, "--config", options.config]
    if options.descriptor:
        words += ["--set", f"vt_descriptor={options.descriptor}", "--set", "vt_recall=belief"]
    store, mapping = os.path.join(folder, "map.db"), os.path.join(folder, "map")
    made = ["--odometry", options.odometry[0], "--max-frames", str(options.map_frames), "--save-map", store]
    runner.Runner().run(words + made + ["--out", mapping])
    learned_at = {row["dest_id"]: frame_of(row) for row in actions(mapping) if row["action"] == CREATED}
    needed, recalls, false = [], 0, 0
    starts = revisits(options, positions, headings)
    for start in starts:
        out = os.path.join(folder, str(start))
        part = ["--odometry", options.odometry[-1], "--from-frame", str(start), "--max-frames", str(options.frames)]
        runner.Runner().run(words + part + ["--load-map", store, "--localise-only", "--out", out])
        # A log goes on where that of the map ended.
        later = [row for row in actions(out) if row["action"] in RECALLED and frame_of(row) >= start]
        if later:
            needed.append(frame_of(later[0]) - start + 1)
        for row in later:
            off = np.linalg.norm(positions[frame_of(row)] - positions[learned_at[row["dest_id"]]])
            recalls += 1
            false += bool(off > options.radius)
    print(f"starts: {len(starts)}, the place was found: {len(needed)} within {options.frames} frames")
    if needed:
        print(f"frames until then: median {np.median(needed):.0f}, 90 %: {np.percentile(needed, 90):.0f}")
    print(f"recalls: {recalls}, of another place: {false}")
    return false


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recording", help="KITTI sequence folder")
    parser.add_argument("--config", required=True)
    parser.add_argument("--truth", required=True, help="true poses, KITTI format")
    parser.add_argument("--odometry", nargs="+", required=True, help="of the mapped part, and of the later one, if it differs")
    parser.add_argument("--map-frames", type=int, required=True, help="frames that are mapped")
    parser.add_argument("--starts", type=int, default=50)
    parser.add_argument("--frames", type=int, default=40, help="frames after a start")
    parser.add_argument("--radius", type=float, default=10.0, help="farther off is another place [m] (default 10)")
    parser.add_argument("--descriptor", help="vt_descriptor, with vt_recall belief")
    options = parser.parse_args()
    try:
        with tempfile.TemporaryDirectory() as folder:
            sys.exit(1 if run(options, folder) else 0)
    except InputError as error:
        sys.exit(f"wake_up.py: {error}")


if __name__ == "__main__":
    main()
