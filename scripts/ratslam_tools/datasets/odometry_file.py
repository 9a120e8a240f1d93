"""Odometry in CSV files in the format of ratslam_run (odometry.csv)."""

import csv
from dataclasses import dataclass
from typing import List, Optional

import numpy as np

from ratslam_tools import text_file
from ratslam_tools.errors import InputError
from ratslam_tools.trajectory.poses import MAX_NUMBER, MAX_ROTATION_DEFECT

COLUMNS = ["frame", "stamp", "linear_x", "angular_z"]
NEEDED = COLUMNS[1:]
POSE = [f"r{i}{j}" if j < 4 else "xyz"[i - 1] for i in (1, 2, 3) for j in (1, 2, 3, 4)]
MAX_STAMP_S = 2.0**32
FASTEST = 1e6  # [m/s] and [rad/s]


def read_odometry(path: str) -> np.ndarray:
    """Rows frame, stamp [s], linear_x [m/s], angular_z [rad/s] of a CSV file whose first line names its columns.

    The columns may be in any order among others (a run's odometry.csv also has poses). Without a column `frame` the
    rows are counted. @throws InputError naming file and line.
    """
    lines = list(text_file.read_lines(path))
    names = split(lines[0][1]) if lines else []
    poses = POSE if POSE[0] in names else []
    missing = [name for name in [*NEEDED, *poses] if name not in names]
    if missing:
        hint = "; columns are parted by commas" if set(";\t") & set(lines[0][1] if lines else "") else ""
        pose_hint = f", and with {POSE[0]} also {', '.join(POSE[1:])}" if missing[0] in POSE else ""
        raise InputError(
            f"{path}: its first line names no column {missing[0]}{hint}; it must name {', '.join(COLUMNS)}{pose_hint}"
        )
    twice = next((name for name in COLUMNS if names.count(name) > 1), None)
    if twice is not None:
        raise InputError(f"{path}: its first line names column {twice} twice")
    rows: List[list] = []
    for number, line in lines[1:]:
        words = split(line)
        if len(words) != len(names):
            hint = ""
            if len(words) > len(names) and "." not in line:
                hint = "; if decimals are written with commas, write them with points"
            raise InputError(f"{path}:{number}: {len(words)} values under {len(names)} columns{hint}")
        rows.append([_value(path, number, words, names, name, len(rows)) for name in COLUMNS])
        pose = [_value(path, number, words, names, name, 0) for name in poses]
        impossible = _why_impossible(*rows[-1][2:], np.array(pose).reshape(-1, 4))
        if impossible:
            raise InputError(f"{path}:{number}: {impossible}")
        if not 0 <= rows[-1][1] < MAX_STAMP_S:
            raise InputError(f"{path}:{number}: stamp {rows[-1][1]:g} lies outside 0 to 2^32 s; stamps are in seconds")
        if len(rows) > 1 and rows[-1][1] <= rows[-2][1]:
            raise InputError(f"{path}:{number}: stamps must rise from line to line")
    if not rows:
        raise InputError(f"{path}: holds no odometry")
    return np.array(rows)


def _why_impossible(speed: float, rate: float, pose: np.ndarray) -> str:
    """Why ratslam_run would refuse a line (odometry/possible.h); empty if it would not. @param pose (3, 4), or empty"""
    values = [("the speed", speed, FASTEST, "m/s"), ("the yaw rate", rate, FASTEST, "rad/s")]
    values += [("the position", value, MAX_NUMBER, "m") for value in pose[:, 3]]
    for what, value, most, unit in values:
        if abs(value) > most:
            return f"{what} {value:g} {unit} is out of range: at most {most:g}"
    turn = pose[:, :3]
    if len(turn) and (np.abs(turn.T @ turn - np.eye(3)).max() > MAX_ROTATION_DEFECT or np.linalg.det(turn) < 0.0):
        return "r11 to r33 are no rotation matrix"
    return ""


@dataclass
class Motions:
    """Poses and covariances of a run's odometry.csv; missing values are NaN."""

    stamps: np.ndarray  # (n,) [s]
    positions: np.ndarray  # (n, 3) [m], of base_link in the odometry's frame
    rotations: np.ndarray  # (n, 3, 3)
    covariances: np.ndarray  # (n, 6, 6), of the twist (vx, vy, vz, wx, wy, wz) [m^2/s^2, rad^2/s^2]
    bridged: np.ndarray  # (n,) predicted, not measured
    corrected: np.ndarray  # (n,) with the motion over a predicted stretch


def read_motions(path: str) -> Optional[Motions]:
    """Poses and covariances of a run's odometry.csv; None if it has not both, as where another program measured. Only ORB
    odometry predicts and corrects, and has columns for it. @throws InputError naming file, line and column."""
    lines = list(text_file.read_lines(path))
    names = split(lines[0][1]) if lines else []
    covariance = [f"cov_{i}{j}" for i in range(1, 7) for j in range(1, 7)]
    missing = [name for name in ["stamp", *POSE, *covariance] if name not in names]
    if "stamp" not in missing and (POSE[0] in missing or set(covariance) <= set(missing)):
        return None
    if missing:
        raise InputError(f"{path}: its first line names no column {missing[0]}: poses and covariances are asked for")
    wanted = ["stamp", *POSE, *covariance, "bridged", "correction_from"]
    columns = {place: names.index(name) for place, name in enumerate(wanted) if name in names}
    table = np.full((len(lines) - 1, len(wanted)), np.nan)
    for row, (number, line) in enumerate(lines[1:]):
        words = split(line)
        if len(words) != len(names):
            raise InputError(f"{path}:{number}: {len(words)} values under {len(names)} columns")
        for place, column in columns.items():
            if words[column]:
                table[row, place] = _value(path, number, words, names, wanted[place], row)
    if len(table) == 0:
        raise InputError(f"{path}: holds no odometry")
    matrices = table[:, 1:13].reshape(-1, 3, 4)
    return Motions(
        table[:, 0],
        matrices[:, :, 3],
        matrices[:, :, :3],
        table[:, 13:49].reshape(-1, 6, 6),
        table[:, 49] == 1,
        np.isfinite(table[:, 50]),
    )


def split(line: str) -> List[str]:
    """Words between the commas of a line, without blanks and quotes around them."""
    try:
        return [word.strip() for word in next(csv.reader([line], skipinitialspace=True), [])]
    except csv.Error:
        return line.split(",")


def _value(path: str, number: int, words, names, name: str, row: int) -> float:
    if name not in names:
        return float(row)
    text = words[names.index(name)]
    try:
        return text_file.finite_number(text)
    except ValueError:
        raise InputError(f"{path}:{number}: {name}: '{text_file.shown(text)}' is not a finite number") from None
