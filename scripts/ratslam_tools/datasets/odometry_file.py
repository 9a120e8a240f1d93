"""Odometry in CSV files, as ratslam_run reads and leaves them (odometry.csv)."""

import csv
from typing import List

import numpy as np

from ratslam_tools import text_file
from ratslam_tools.errors import InputError

COLUMNS = ["frame", "stamp", "linear_x", "angular_z"]
NEEDED = COLUMNS[1:]
MAX_STAMP_S = 2.0**32


def read_odometry(path: str) -> np.ndarray:
    """Rows frame, stamp [s], linear_x [m/s], angular_z [rad/s] of a CSV file whose first line names its columns.

    Columns may stand in any order among others (a run's odometry.csv has poses as well); without a column
    `frame` the rows are counted. @throws InputError naming file and line.
    """
    lines = list(text_file.read_lines(path))
    names = split(lines[0][1]) if lines else []
    missing = [name for name in NEEDED if name not in names]
    if missing:
        hint = "; columns are parted by commas" if ";" in (lines[0][1] if lines else "") else ""
        raise InputError(
            f"{path}: its first line names no column {missing[0]}{hint}; it must name {', '.join(COLUMNS)}"
        )
    rows: List[list] = []
    for number, line in lines[1:]:
        words = split(line)
        if len(words) != len(names):
            hint = ""
            if len(words) > len(names) and "." not in line:
                hint = "; if decimals are written with commas, write them with points"
            raise InputError(f"{path}:{number}: {len(words)} values under {len(names)} columns{hint}")
        rows.append([_value(path, number, words, names, name, len(rows)) for name in COLUMNS])
        if not 0 <= rows[-1][1] < MAX_STAMP_S:
            raise InputError(f"{path}:{number}: stamp {rows[-1][1]:g} lies outside 0 to 2^32 s; stamps are in seconds")
        if len(rows) > 1 and rows[-1][1] <= rows[-2][1]:
            raise InputError(f"{path}:{number}: stamps must rise from line to line")
    if not rows:
        raise InputError(f"{path}: holds no odometry")
    return np.array(rows)


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
