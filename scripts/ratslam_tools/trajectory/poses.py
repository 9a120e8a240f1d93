"""Trajectories: stamped (TUM) or numbered (KITTI) poses, their files, and the checks every reader makes.

TUM line: `stamp x y z qx qy qz qw`; KITTI line: the 12 numbers of a row-major 3x4 pose matrix. `#` starts a
comment.
"""

import itertools
import math
import os
import re
import sys
from typing import List, Optional

import numpy as np

from ratslam_tools import text_file
from ratslam_tools.errors import InputError
from ratslam_tools.trajectory import geometry

COLUMNS = {"tum": 8, "kitti": 12}
MAX_TIME_S = 2.0**32  # what a stamp of ROS can hold
# A rotation matrix written with few digits has errors of about 1e-6. With more than this it is another kind of file.
MAX_ROTATION_DEFECT = 1e-2
# Bound on positions [m]; squares and sums of such numbers do not overflow.
MAX_NUMBER = 1e12


def breaks_of(stamps: np.ndarray, silence: float = math.inf) -> np.ndarray:
    """Rows before which time went back, or more than `silence` [s] passed."""
    steps = np.diff(stamps)
    return np.flatnonzero((steps <= 0) | (steps > silence)) + 1


class Trajectory:
    """Poses world <- body: positions (n, 3) [m], rotations (n, 3, 3), stamps (n,) [s] or None where poses are
    numbered.
    """

    def __init__(self, positions, rotations, stamps=None, name: str = "trajectory"):
        self.positions = np.asarray(positions, dtype=float)
        self.rotations = np.asarray(rotations, dtype=float)
        self.stamps = None if stamps is None else np.asarray(stamps, dtype=float)
        self.name = name

    def __len__(self) -> int:
        return len(self.positions)

    def select(self, rows) -> "Trajectory":
        """The poses at the given rows (index array, mask or slice)."""
        return Trajectory(
            self.positions[rows],
            self.rotations[rows],
            None if self.stamps is None else self.stamps[rows],
            self.name,
        )

    @property
    def breaks(self) -> np.ndarray:
        """Rows of the poses where time went back, as on another day's drive whose clock began anew. Most trajectories have
        none.
        """
        return np.zeros(0, dtype=int) if self.stamps is None else breaks_of(self.stamps)

    @property
    def stretches(self) -> List["Trajectory"]:
        """The parts between breaks, within which stamps ascend."""
        limits = [0, *self.breaks, len(self)]
        return [self.select(slice(start, end)) for start, end in zip(limits, limits[1:])]

    def with_gaps(self, values, rows=None) -> np.ndarray:
        """Values (m, ...) of the poses at ascending `rows` (None: all), with NaN at each break: no line joins stretches,
        because no drive does."""
        rows = np.arange(len(self)) if rows is None else rows
        return np.insert(np.asarray(values, dtype=float), np.searchsorted(rows, self.breaks), np.nan, axis=0)

    def transformed(self, rotation, translation, scale: float = 1.0) -> "Trajectory":
        """The same path in another world: p' = scale R p + t, R_body' = R R_body."""
        return Trajectory(
            scale * self.positions @ np.asarray(rotation).T + translation,
            rotation @ self.rotations,
            self.stamps,
            self.name,
        )

    def scaled(self, scale: float) -> "Trajectory":
        """Positions multiplied by `scale`, orientations kept."""
        return Trajectory(self.positions * scale, self.rotations, self.stamps, self.name)

    def changed_axes(self, axes) -> "Trajectory":
        """World and body axes both replaced: T' = A T A^-1 with v' = A v (A a rotation (3, 3))."""
        axes = np.asarray(axes)
        return Trajectory(self.positions @ axes.T, axes @ self.rotations @ axes.T, self.stamps, self.name)

    def path_length(self) -> np.ndarray:
        """Length of the path up to each pose, (n,) [m]."""
        return geometry.path_length(self.positions)

    def check(self, allow_repeats: bool = False) -> "Trajectory":
        """Returns itself. @throws InputError naming the first pose that is not finite or whose stamp does not
        increase.

        @param allow_repeats whether equal stamps are allowed (references by motion capture have some); decreasing
        ones never are.
        """
        values = [self.positions, self.rotations.reshape(len(self), -1)]
        if self.stamps is not None:
            values.append(self.stamps[:, None])
        bad = np.flatnonzero(~np.isfinite(np.hstack(values)).all(axis=1))
        if len(bad):
            raise InputError(f"{self.name}: pose {bad[0] + 1} has a NaN or infinite value")
        if self.stamps is not None:
            steps = np.diff(self.stamps)
            bad = np.flatnonzero(steps < 0 if allow_repeats else steps <= 0)
            if len(bad):
                what = "repeats" if steps[bad[0]] == 0 else "goes back"
                raise InputError(
                    f"{self.name}: the stamp of pose {bad[0] + 2} ({self.stamps[bad[0] + 1]:.9f}) {what}; "
                    "stamps must increase"
                )
        return self


def read_table(path: str) -> np.ndarray:
    """Finite numbers of a text file, one row a line, separated by blanks or commas. @throws InputError naming the
    line.
    """
    rows, width = [], None
    for number, line in text_file.read_lines(path):
        text = line.split("#", 1)[0]
        if not text.strip():
            continue
        words = text.replace(",", " ").split()
        try:
            row = [text_file.number(word) for word in words]
        except ValueError:
            raise InputError(f"{path}:{number}: not a number: '{text_file.shown(line)}'") from None
        if _has_decimal_commas(text):
            raise InputError(
                f"{path}:{number}: decimals are written with commas: '{text_file.shown(line)}'; write them with points"
            )
        if not all(map(math.isfinite, row)):
            raise InputError(f"{path}:{number}: a NaN or infinite value: '{text_file.shown(line)}'")
        if width is not None and len(row) != width:
            raise InputError(f"{path}:{number}: {len(row)} columns where the lines before have {width}")
        width = len(row)
        rows.append(row)
    if not rows:
        raise InputError(f"{path}: holds no poses")
    return np.array(rows)


def has_stamps(path: str, form: str = "auto") -> bool:
    """Whether the poses of a file have stamps of their own: whether its first line is one of a TUM file."""
    texts = (line.split("#", 1)[0] for _, line in text_file.read_lines(path))
    first = next((text for text in texts if text.strip()), "")
    return form == "tum" or (form == "auto" and len(first.replace(",", " ").split()) == COLUMNS["tum"])


def _has_decimal_commas(line: str) -> bool:
    """Whether numbers have decimal commas, with blanks, tabs or semicolons between numbers: `0,1 2,5`."""
    words = line.split()
    return len(words) > 1 and any(re.fullmatch(r"[-+]?[0-9]+,[0-9]+([eE][-+]?[0-9]+)?", word) for word in words)


def read_times(path: str) -> np.ndarray:
    """Stamps (n,) [s] of a KITTI times.txt, which has no comments."""
    for number, line in text_file.read_lines(path):
        if "#" in line:
            raise InputError(f"{path}:{number}: '{text_file.shown(line)}' is not a time in seconds")
    table = read_table(path)
    if table.shape[1] != 1:
        commas = "; write decimals with points, not commas" if table.shape[1] == 2 else ""
        raise InputError(f"{path}: {table.shape[1]} columns; a file of times has one, in seconds{commas}")
    times = table[:, 0]
    wrong = np.flatnonzero((times < 0) | (times >= MAX_TIME_S))
    if len(wrong):
        raise InputError(
            f"{path}: time {wrong[0] + 1} ({times[wrong[0]]:g} s) lies outside 0 to 2^32 s; times are in seconds"
        )
    return times


def _in_order_of_time(trajectory: Trajectory, times: str) -> Trajectory:
    """Sorts by stamp the poses of a recording in which a few images came late."""
    back = np.count_nonzero(np.diff(trajectory.stamps) < 0)
    if back == 0 or 2 * back > len(trajectory):
        return trajectory
    print(f"{times}: {back} times lie before the one before; poses are taken in the order of time", file=sys.stderr)
    return trajectory.select(np.argsort(trajectory.stamps, kind="stable"))


def read_trajectory(
    path: str, form: str = "auto", times: Optional[str] = None, allow_repeats: bool = False
) -> Trajectory:
    """Reads a TUM or KITTI file. Without `form` the number of columns decides.

    @param times a times.txt that gives the poses of a KITTI file their stamps.
    @param allow_repeats as in Trajectory.check.
    @throws InputError for an unreadable, malformed or degenerate file.
    """
    table = read_table(path)
    columns = table.shape[1]
    if form == "auto":
        form = next((name for name, count in COLUMNS.items() if count == columns), "auto")
    if COLUMNS.get(form) != columns:
        expected = f"{COLUMNS[form]} ({form.upper()})" if form in COLUMNS else "8 (TUM) or 12 (KITTI)"
        raise InputError(f"{path}: {columns} columns; {expected} are expected")
    if form == "tum":
        bad = np.flatnonzero((np.abs(table) > MAX_NUMBER).any(axis=1))
        if len(bad):
            raise InputError(f"{path}: pose {bad[0] + 1} has an immense value")
        if (np.linalg.norm(table[:, 4:], axis=1) < 1e-6).any():
            raise InputError(f"{path}: a quaternion of length zero")
        rotations = geometry.matrices_from_quaternions(table[:, 4:])
        return Trajectory(table[:, 1:4], rotations, table[:, 0], path).check(allow_repeats)
    if (np.abs(table) > MAX_NUMBER).any():
        raise InputError(f"{path}: a pose has an immense value")
    poses = table.reshape(-1, 3, 4)
    trajectory = Trajectory(poses[:, :, 3], poses[:, :, :3], None, path).check()
    defect = np.abs(geometry.transpose(trajectory.rotations) @ trajectory.rotations - np.eye(3)).max(
        axis=(1, 2)
    )
    if defect.max() > MAX_ROTATION_DEFECT:
        raise InputError(f"{path}: pose {np.argmax(defect) + 1} holds no rotation matrix")
    if times is not None:
        stamps = read_times(times)
        if len(stamps) < len(trajectory):
            raise InputError(f"{times}: {len(stamps)} times for the {len(trajectory)} poses of {path}")
        if len(stamps) > len(trajectory):
            told = f"{len(stamps)} times for the {len(trajectory)} poses of {path}: the first {len(trajectory)} are taken"
            print(f"note: {times}: {told}", file=sys.stderr)
        trajectory.stamps = stamps[: len(trajectory)]
        trajectory = _in_order_of_time(trajectory, times)
    return trajectory.check(allow_repeats)


def later_files(path: str) -> List[str]:
    """The files in which a run's trajectory goes on where its time went back: of a.tum a_2.tum, a_3.tum ..."""
    base, ending = os.path.splitext(path)
    numbers = itertools.takewhile(lambda n: os.path.exists(f"{base}_{n}{ending}"), itertools.count(2))
    return [f"{base}_{number}{ending}" for number in numbers]


def read_stretches(path: str) -> Trajectory:
    """All stretches of a run's trajectory behind one another (Trajectory.stretches). @throws InputError as
    read_trajectory.
    """
    parts = [read_trajectory(path)]
    if parts[0].stamps is not None:  # poses without stamps are all in one file
        parts += [read_trajectory(each, "tum") for each in later_files(path)]
    names = ("positions", "rotations") if parts[0].stamps is None else ("positions", "rotations", "stamps")
    return Trajectory(*(np.concatenate([getattr(part, name) for part in parts]) for name in names), name=path)


def _text(value: float) -> str:
    """A number with nine digits; a large one, such as a coordinate of a whole country's grid, to a tenth of a millimetre."""
    before_the_point = math.floor(math.log10(abs(value))) + 1 if abs(value) >= 1.0 else 0
    return f"{value:.{max(9, before_the_point + 4)}g}"


def write_tum(path: str, trajectory: Trajectory) -> None:
    """Writes `stamp x y z qx qy qz qw` lines. @throws InputError if the poses have no stamps."""
    if trajectory.stamps is None:
        raise InputError(f"{trajectory.name}: its poses have no stamps; give --times")
    quaternions = geometry.quaternions_from_matrices(trajectory.rotations)
    with text_file.writing(path) as file:
        for stamp, position, quaternion in zip(trajectory.stamps, trajectory.positions, quaternions):
            file.write(
                f"{stamp:.9f} " + " ".join(map(_text, (*position, *quaternion))) + "\n"
            )


def write_kitti(path: str, trajectory: Trajectory) -> None:
    """Writes the 12 numbers of each pose matrix, one pose a line."""
    matrices = np.concatenate([trajectory.rotations, trajectory.positions[:, :, None]], axis=2)
    with text_file.writing(path) as file:
        for matrix in matrices.reshape(-1, 12):
            file.write(" ".join(map(_text, matrix)) + "\n")
