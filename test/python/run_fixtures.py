"""A run folder, and a stand-in for ratslam_run, for the tests of what reads and makes runs."""

import json
import stat
import sys

import numpy as np
import pytest

from ratslam_tools.trajectory import Trajectory, write_tum

FAKE = """#!{python}
import os, shutil, sys, time
words = sys.argv[1:]
out = words[words.index("--out") + 1]
values = dict(word.split("=") for before, word in zip(words, words[1:]) if before == "--set")
if os.path.basename(words[0]) == "recording":  # only the parameters are to be checked
    sys.exit("ratslam_run: nokey: no parameter has this name (from the command line)" if "nokey" in values else 1)
with open({log!r}, "a") as log:
    log.write(" ".join(words) + "\\n")
if values.get("fail") == "1":
    sys.exit("fail: 1 is not allowed: 0")
for word in filter(None, values.get("remark", "").split("+")):
    print("ratslam_run: remark " + word, file=sys.stderr)
time.sleep(float(values.get("sleep", 0)))
for name in os.listdir({run!r}):
    shutil.copy(os.path.join({run!r}, name), out)
bend = abs(float(values.get("pc_vt_inject_energy", 0.2)) - 0.2)
path = os.path.join(out, "trajectory_final.tum")
lines = [line.split() for line in open(path)]
with open(path, "w") as file:
    for line in lines:
        line[2] = str(float(line[2]) + bend * float(line[0]) ** 2)
        file.write(" ".join(line) + "\\n")
"""


@pytest.fixture
def folder(tmp_path, drive):
    """A run folder whose final trajectory is the truth, moved, and whose online one has drifted; and the
    truth.
    """
    path = tmp_path / "run"
    path.mkdir()
    known = drive()
    write_tum(tmp_path / "truth.tum", known)
    write_tum(path / "trajectory_final.tum", known.transformed(np.eye(3), [10.0, 0.0, 0.0]))
    drift = np.outer(known.stamps, [0.0, 0.3, 0.0])
    write_tum(
        path / "trajectory_online.tum", Trajectory(known.positions + drift, known.rotations, known.stamps)
    )
    with open(path / "map.yaml", "w", encoding="utf-8") as file:
        file.write("format: ratslam_experience_map 1\nexperiences:\n")
        for i, position in enumerate(known.positions):
            file.write(
                f"- {{id: {i}, x: {position[0] + 10:.9f}, y: {position[1]:.9f}, z: 0.0, yaw: 0.5, log_scale: 0.0}}\n"
            )
        file.write("links:\n")
        for i in range(len(known) - 1):
            file.write(_link(i, i, i + 1, "false"))
        file.write(_link(999, 150, 3, "true"))
    with open(path / "templates.csv", "w", encoding="utf-8") as file:
        file.write("stamp,template_id,error,relative_rad\n")
        file.writelines(f"{0.1 * i},{i if i < 150 else i - 150},{0.05 if i else -1},0\n" for i in range(200))
    with open(path / "actions.csv", "w", encoding="utf-8") as file:
        file.write("stamp,action,src_id,dest_id,x,y,th\n")
        file.writelines(
            f"{0.1 * i},{1 if i < 150 else 2},{i},{i if i < 150 else i - 150},5,6,7\n" for i in range(200)
        )
    with open(path / "pose_cells.csv", "w", encoding="utf-8") as file:
        file.write("stamp,layer,row,column,activity\n5.0,35,29,4,0.75\n5.0,0,29,4,0.25\n10.0,7,6,5,1\n")
    summary = {
        "version": "0.1.0",
        "parameters": {"pc_dim_xy": 30, "pc_dim_th": 36, "topic_root": "<kitti> & co"},
        "timing": {"local_view": {"mean_ms": 1.25}, "pose_cells": 2.5},
    }
    (path / "summary.json").write_text(json.dumps(summary))
    return path


def _link(number, start, end, recall):
    return (
        f"- {{id: {number}, from: {start}, to: {end}, distance: 0.8, heading_rad: 0.0, "
        f"facing_rad: 0.0, rise: 0.0, duration_s: 0.1, recall: {recall}}}\n"
    )


@pytest.fixture
def program(tmp_path, folder):
    """A stand-in for ratslam_run that copies the run folder and bends its final trajectory; and its log of
    calls.
    """
    path = tmp_path / "fake_run"
    path.write_text(FAKE.format(python=sys.executable, log=str(tmp_path / "calls"), run=str(folder)))
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return path


def calls(program):
    log = program.parent / "calls"
    return log.read_text().splitlines() if log.exists() else []


def sweep_words(program, tmp_path, *vary):
    """The words of a sweep with the stand-in."""
    words = [
        "input",
        "--config",
        "c.yaml",
        "--truth",
        str(tmp_path / "truth.tum"),
        "--out",
        str(tmp_path / "out"),
        "--ratslam_run",
        str(program),
        "--jobs",
        "2",
    ]
    return words + [word for text in vary for word in ("--vary", text)]


def merging(out, folders, *vary):
    """The words that put shards together."""
    return [*(word for text in vary for word in ("--vary", text)), "--out", str(out), "--merge", *map(str, folders)]
