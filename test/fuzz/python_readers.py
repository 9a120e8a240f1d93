#!/usr/bin/python3
"""Feeds mutated files to every reader of the Python tools: each input is read or refused with an InputError.

Usage: python_readers.py [--inputs N] [--seed S] [--keep DIR] [TARGET ...]
The inputs are a function of seed and number alone. Exits with 1 where a reader raises anything else, and leaves
the input under DIR (default: out/endurance/fuzz_python of the source tree).
"""

import argparse
import os
import random
import resource
import shutil
import sys
import tempfile
import time
import traceback
import warnings

SOURCE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.realpath(__file__))))
sys.path.insert(0, os.path.join(SOURCE, "scripts"))
from ratslam_tools.cli import ini_to_yaml, recorder_to_bag  # noqa: E402
from ratslam_tools.datasets import bags, calibration, donkey, flat_yaml, kitti, odometry_file, recorder  # noqa: E402
from ratslam_tools.errors import InputError  # noqa: E402
from ratslam_tools.runs.run_folder import Run  # noqa: E402
from ratslam_tools.trajectory import association, read_trajectory  # noqa: E402

POSE = "1 0 0 {0} 0 1 0 0 0 0 1 {0}"
TUM = "".join(f"{i}.5 {i} {i * i % 7} 0 0 0 0 1\n" for i in range(6))
ROS_CALIBRATION = """image_width: 64
image_height: 48
camera_matrix: {rows: 3, cols: 3, data: [50, 0, 31, 0, 51, 23, 0, 0, 1]}
distortion_model: plumb_bob
distortion_coefficients:
  data: [-0.2, 0, 0, 0, 0]
"""
RUN = {
    "trajectory_final.tum": TUM,
    "trajectory_online.tum": TUM,
    "map.yaml": "experiences:\n"
    "  - {id: 0, x: 0, y: 0, yaw: 0, stamp: 0, view_id: 0}\n  - {id: 1, x: 1, y: 0, yaw: 0, stamp: 1, view_id: 1}\n"
    "links:\n  - {id: 0, from: 0, to: 1, distance: 1, heading_rad: 0, facing_rad: 0, rise: 0, duration_s: 1, "
    "recall: false}\n",
    "templates.csv": "stamp,template_id,error,relative_rad\n0.5,0,0.1,0\n1.5,1,0.1,0\n",
    "actions.csv": "stamp,action,src_id,dest_id,x,y,th\n0.5,1,0,0,1,2,3\n",
    "pose_cells.csv": "stamp,layer,row,column,activity\n0.5,1,2,3,0.5\n",
    "summary.json": '{"version": "1", "counts": {"frames": 6}, "timing": {"odometry": 1.5}, "parameters": {"a": "b"}}\n',
}
RECORDING = {
    "data_image.txt": "".join(f"168375600000{i},images/{i}.jpeg\n" for i in range(4)),
    "data_imu.txt": "".join(f"168375600000{i},0.1,9.8,0.2,0.01,0.02,0.03\n" for i in range(4)),
    "data_gps.txt": "".join(f"168375600{i}000,55.{i},82.9,110,4.0,90,5.5,gps\n" for i in range(4)),
    **{f"images/{i}.jpeg": "" for i in range(4)},
}
SEQUENCE = {
    "times.txt": "0.0\n0.1\n0.2\n",
    "calib.txt": "P0: 50 0 31 0 0 51 23 0 0 0 1 0\nP1: 50 0 31 -9 0 51 23 0 0 0 1 0\n",
    "poses.txt": "".join(POSE.format(i) + "\n" for i in range(3)),
    **{f"image_0/{i}.png": "" for i in range(3)},
}
RAW = {
    "drive/image_00/timestamps.txt": "".join(f"2011-09-26 13:02:2{i}.964389445\n" for i in range(3)),
    "drive/oxts/timestamps.txt": "".join(f"2011-09-26 13:02:2{i}.864389445\n" for i in range(3)),
    "calib_cam_to_cam.txt": "calib_time: now\nP_rect_00: 50 0 31 0 0 51 23 0 0 0 1 0\nR_rect_00: 1 0 0 0 1 0 0 0 1\n",
    "calib_imu_to_velo.txt": "R: 1 0 0 0 1 0 0 0 1\nT: 0 0 1\n",
    "calib_velo_to_cam.txt": "R: 0 -1 0 0 0 -1 1 0 0\nT: 0 0 1\n",
    **{f"drive/image_00/data/{i}.png": "" for i in range(3)},
    **{f"drive/oxts/data/{i}.txt": f"49.{i} 8.4 116 0 0 0.5 1 2 3\n" for i in range(3)},
}
TUB = {
    "catalog_0.catalog": "".join(
        f'{{"_index": {i}, "_timestamp_ms": 100{i}, "user/angle": 0.1, "user/throttle": 0.2, '
        f'"cam/image_array": "{i}.jpg"}}\n'
        for i in range(4)
    ),
    "manifest.json": '["a"]\n{"created_at": 1.5}\n{"paths": ["catalog_0.catalog"], "deleted_indexes": [2]}\n',
}
TOKENS = [
    b"nan", b"-inf", b"1e999", b"-1", b"0", b"9" * 25, b"9223372036854775808", b"1e-320", b"\xc2\xb2", b"\xff\xfe", b"\0",
    b"\xef\xbb\xbf", b'"', b"'", b"[", b"{", b"}", b"]", b"- ", b": ", b"&a ", b"*a", b"!!python/tuple ", b"%YAML 9",
    b"../", b"/", b"\n", b"\r", b"\n\n", b",", b",,,,", b";", b"#", b"\t", b"_", b"$", b"null", b"true", b"\xe2\x80\xa8",
    b"-" * 300, b"[" * 3000,
]  # fmt: skip


def read_pair(folder):
    reference, estimate = (read_trajectory(os.path.join(folder, name)) for name in ("a.txt", "b.txt"))
    matched = association.associate(reference, estimate)
    association.fit_alignment(*matched, True, True).apply(matched[1]).path_length()


def read_drive(folder):
    drive = kitti.read_drive(folder).select(0, None)
    if drive.truth is not None:
        for _ in bags.ground_truth_messages(drive.truth, drive.truth_stamps_ns):
            pass


def read_recording(folder):
    recording = recorder.read(folder)
    rows = recorder.good_fixes(recording, 20.0)
    recorder_to_bag.other_messages(recording, recorder.gps_track(recording, rows) if len(rows) else None)


def make_bag(folder):
    with bags.writing(os.path.join(folder, "a.bag")) as bag:
        for index in range(3):
            stamp = (index + 1) * 10**9
            message = bags.odometry_message(bags.header(stamp, "odom"), "base", (index, 0, 0), (0, 0, 0, 1), (1, 0, 0), (0, 0, 0))
            bags.write(bag, "/odom", message, stamp)


# Name of a target: its files (name -> text, or a function that makes them in a folder) and what reads the folder.
TARGETS = {
    "tum": ({"a.txt": TUM, "b.txt": TUM}, read_pair),
    "kitti_poses": ({name: "".join(POSE.format(i) + "\n" for i in range(4)) for name in ("a.txt", "b.txt")}, read_pair),
    "sequence": (SEQUENCE, read_drive),
    "raw_drive": (RAW, lambda folder: read_drive(os.path.join(folder, "drive"))),
    "odometry": (
        {"a.csv": "frame,stamp,linear_x,angular_z\n" + "".join(f"{i},{i}.5,1,0.1\n" for i in range(4))},
        lambda folder: odometry_file.read_odometry(os.path.join(folder, "a.csv")),
    ),
    "ini": (
        {"a.txt": "[general]\ntopic_root=x\n[ratslam]\nexp_loops = 20 # many\n[draw]\na=1\n"},
        lambda folder: ini_to_yaml.convert(os.path.join(folder, "a.txt")),
    ),
    "yaml": ({"a.yaml": "# c\na: 1\nb: [1, 2]\nc: {d: e}\n"}, lambda folder: flat_yaml.load(os.path.join(folder, "a.yaml"))),
    "calibration": (
        {"a.yaml": "image_width: 64\nimage_height: 48\nfx: 50\nfy: 51\ncx: 31\ncy: 23\nk1: -0.2\n"},
        lambda folder: calibration.read(os.path.join(folder, "a.yaml")),
    ),
    "calibration_of_ros": ({"a.yaml": ROS_CALIBRATION}, lambda folder: calibration.read(os.path.join(folder, "a.yaml"))),
    "recorder": (RECORDING, read_recording),
    "donkey": (TUB, donkey.read),
    "run": (RUN, Run),
    "bag": (make_bag, lambda folder: bags.read_trajectory_topic(os.path.join(folder, "a.bag"), "/odom")),
}


def mutated(chance: random.Random, data: bytes) -> bytes:
    """One to four changes, of the kinds that disks, editors and people make."""
    content = bytearray(data)
    for _ in range(chance.randint(1, 4)):
        at = chance.randint(0, len(content))
        until = min(len(content), at + chance.choice([1, 2, 4, 8, 40, 400]))
        kind = chance.randrange(7)
        if kind == 0 and content:
            content[at % len(content)] ^= 1 << chance.randrange(8)
        elif kind == 1:
            content[at:until] = b""
        elif kind == 2:
            content[at:at] = chance.choice(TOKENS)
        elif kind == 3:
            content[at:until] = chance.choice(TOKENS)
        elif kind == 4:
            content[at:at] = content[at:until]
        elif kind == 5:
            lines = bytes(content).split(b"\n")
            chance.shuffle(lines)
            content = bytearray(b"\n".join(lines))
        elif chance.random() < 0.2:
            content = content[:at]
        elif content:
            content[at % len(content)] = chance.randrange(256)
    return bytes(content)


class Target:
    """A folder of whole files of which one at a time is mutated."""

    def __init__(self, name: str, folder: str):
        files, self.read = TARGETS[name]
        self.name, self.folder = name, folder
        if callable(files):
            files(folder)
        else:
            for file, text in files.items():
                path = os.path.join(folder, file)
                os.makedirs(os.path.dirname(path), exist_ok=True)
                with open(path, "w", encoding="utf-8") as stream:
                    stream.write(text)
        found = (os.path.join(above, file) for above, _, inside in os.walk(folder) for file in inside)
        self.whole = {}
        for path in sorted(found):
            with open(path, "rb") as stream:
                self.whole[path] = stream.read()
        self.mutable = [path for path, data in self.whole.items() if data]
        self.latest = self.mutable[0]
        self.read(folder)  # the files are right as they are

    def attempt(self, seed: int, number: int):
        """Reads one mutated input. Returns None, or the traceback of an exception that is none of ours."""
        chance = random.Random(f"{self.name} {seed} {number}")
        path = self.latest = chance.choice(self.mutable)
        with open(path, "wb") as stream:
            stream.write(mutated(chance, self.whole[path]))
        try:
            self.read(self.folder)
        except InputError as error:
            if "\n" in str(error):
                return f"a message of more than one line: {error!r}"
        except Exception:  # whatever it is: it is what is looked for
            return traceback.format_exc()
        return None

    def restore(self) -> None:
        """The mutated file as it was."""
        with open(self.latest, "wb") as stream:
            stream.write(self.whole[self.latest])


def fuzz(name: str, inputs: int, seed: int, keep=None) -> list:
    """Feeds a target; returns (number of the input, traceback) of each finding."""
    findings = []
    memory = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None  # a disk would be the slowest part
    with tempfile.TemporaryDirectory(dir=memory) as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # numbers near the end of their range
        target = Target(name, folder)
        for number in range(inputs):
            trace = target.attempt(seed, number)
            if trace is not None:
                findings.append((number, trace))
                if keep is not None:
                    kept = os.path.join(keep, f"{name}_{seed}_{number}")
                    shutil.rmtree(kept, ignore_errors=True)
                    shutil.copytree(folder, kept)
            target.restore()
    return findings


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("targets", nargs="*", metavar="TARGET", help=f"of {', '.join(TARGETS)} (default: all)")
    parser.add_argument("--inputs", type=int, default=10000, help="of each target (default %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="default %(default)s")
    parser.add_argument("--keep", default=os.path.join(SOURCE, "out", "endurance", "fuzz_python"), metavar="DIR",
                        help="folder for findings (default %(default)s)")
    arguments = parser.parse_args()
    unknown = [name for name in arguments.targets if name not in TARGETS]
    if unknown:
        parser.error(f"{unknown[0]}: no target; they are {', '.join(TARGETS)}")
    # A file of some kilobytes must not lead to gigabytes.
    resource.setrlimit(resource.RLIMIT_AS, (4 << 30, 4 << 30))
    failed = 0
    for name in arguments.targets or TARGETS:
        begin = time.monotonic()
        findings = fuzz(name, arguments.inputs, arguments.seed, arguments.keep)
        failed += len(findings)
        print(f"{name}: {arguments.inputs} inputs, {len(findings)} findings, {time.monotonic() - begin:.0f} s", flush=True)
        for number, trace in findings[:3]:
            print(f"  input {number}: {trace.strip()}", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
