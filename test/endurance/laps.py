#!/usr/bin/python3
"""Patrols one block of the synthetic town, rendered: laps of 265 m that wander 0.25 m to either side in their lane, with ORB odometry,
each lap by a process that goes on where the one before ended. Prints what the map holds after each lap and what a frame took."""
import argparse
import json
import math
import os
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "..", "scripts"))

from ratslam_tools.runs import runner  # noqa: E402

SIDES, RADIUS = (72.0, 32.0, 72.0, 32.0), 9.0  # straight ways and the turns between them [m]
STEP, WANDER, WANDER_LAPS = 0.8, 0.25, 1.37    # of a frame, to either side in so many laps [m]
# Half the size of KITTI's images, and so are the rows that the local view looks at.
SIZE, REGION = "620x188", ["--set", "image_crop_y_min=30", "--set", "image_crop_y_max=150"]


def place(way):
    """Position [m] and heading [rad] on the block after so much way from its first corner."""
    x, y, heading = -0.5 * SIDES[0], -0.5 * SIDES[1] - RADIUS, 0.0
    for side in SIDES:
        if way <= side:
            return x + way * math.cos(heading), y + way * math.sin(heading), heading
        x, y, way = x + side * math.cos(heading), y + side * math.sin(heading), way - side
        turned = min(way / RADIUS, math.pi / 2.0)
        x += RADIUS * (math.sin(heading + turned) - math.sin(heading))
        y -= RADIUS * (math.cos(heading + turned) - math.cos(heading))
        heading, way = heading + turned, way - 0.5 * math.pi * RADIUS
        if way <= 0.0:
            break
    return x, y, heading


def write_poses(path, laps):
    """KITTI poses of the patrol. @return frames a lap"""
    length = sum(SIDES) + 2.0 * math.pi * RADIUS
    frames = round(length / STEP)
    with open(path, "w", encoding="utf-8") as file:
        for k in range(frames * laps):
            x, y, heading = place(k % frames * length / frames)
            aside = WANDER * math.sin(2.0 * math.pi * k / (frames * WANDER_LAPS))
            x, y = x - aside * math.sin(heading), y + aside * math.cos(heading)
            c, s = math.cos(heading), math.sin(heading)
            print(c, 0, -s, -y, 0, 1, 0, 0, s, 0, c, x, file=file)
    return frames


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--laps", type=int, default=20)
    parser.add_argument("--config", default=os.path.join(os.path.dirname(__file__), "..", "..", "config", "demo.yaml"))
    parser.add_argument("--out", help="keep drive, map and runs in this folder")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        patrol(options, options.out or folder)


def patrol(options, folder):
    os.makedirs(folder, exist_ok=True)
    town, store, programs = os.path.join(folder, "town"), os.path.join(folder, "map.db"), os.path.dirname(runner.find())
    frames = write_poses(os.path.join(folder, "poses.txt"), options.laps)
    subprocess.run([os.path.join(programs, "ratslam_town"), "--out", town, "--trajectory", os.path.join(folder, "poses.txt"), "--size",
                    SIZE, "--jpeg-quality", "90", "--threads", "2"], check=True, stdout=subprocess.DEVNULL)
    print("| lap | templates | experiences | links | graph nodes | file [MB] | memory [MB] | odometry | local view | pose cells, map [ms] |\n"
          "|---|---|---|---|---|---|---|---|---|---|")
    for lap in range(1, options.laps + 1):
        out = os.path.join(folder, f"lap_{lap}")
        words = [runner.find(), town, "--config", options.config, *REGION, "--odometry", "orb", "--out", out, "--save-map", store,
                 "--from-frame", str(frames * (lap - 1)), "--max-frames", str(frames)] + (["--load-map", store] if lap > 1 else [])
        with subprocess.Popen(words, stdout=subprocess.DEVNULL) as process:
            _, status, used = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status) if hasattr(os, "waitstatus_to_exitcode") else status
        if process.returncode:
            sys.exit(f"laps.py: lap {lap}: ratslam_run ended with {process.returncode}")
        with open(os.path.join(out, "summary.json"), encoding="utf-8") as file:
            summary = json.load(file)
        said = subprocess.run([os.path.join(programs, "ratslam_map"), "info", store], check=True, stdout=subprocess.PIPE, text=True).stdout
        (nodes,) = [line.split()[-1] for line in said.splitlines() if line.startswith("pose graph nodes")]
        counts = summary["counts"]
        took = {name: ms * counts["used_images"] / frames for name, ms in summary["timing"].items()}  # of this lap's frames alone
        print(f"| {lap} | {counts['templates']} | {counts['experiences']} | {counts['links']} | {nodes} | "
              f"{os.path.getsize(store) / 1e6:.1f} | {used.ru_maxrss / 1024:.0f} | {took['odometry']:.1f} | {took['local_view']:.2f} | "
              f"{took['pose_cells'] + took['experience_map']:.2f} |", flush=True)


if __name__ == "__main__":
    main()
