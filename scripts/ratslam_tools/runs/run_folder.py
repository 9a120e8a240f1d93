"""The result folder of ratslam_run: trajectories, map, templates, actions and summary.

A figure needs only its own files. Every reader names the file and line of an error.
"""

import json
import math
import os
import re
import zipfile
import zlib
from typing import Dict, List, Optional, Sequence

import numpy as np

from ratslam_tools import text_file
from ratslam_tools.errors import InputError, one_line, require_folder
from ratslam_tools.trajectory import Trajectory, later_files, read_stretches

EXPERIENCE_KEYS = ("id", "x", "y", "z", "yaw", "log_scale")
LINK_KEYS = ("id", "from", "to", "distance", "heading_rad", "facing_rad", "rise", "duration_s")
# Columns that are read of each file; a file may have more.
TEMPLATE_COLUMNS = ("stamp", "template_id", "error")
ACTION_COLUMNS = ("stamp", "action", "dest_id", "x", "y", "th")
ACTIVITY_COLUMNS = ("stamp", "layer", "row", "column", "activity")
RARE = 5  # usual steps of time: a longer one is a silence
ENTRY = re.compile(r"^\s*-\s*\{(.*)\}\s*$")


class Map:
    """An experience map: `nodes` and `links` are dicts of arrays, one entry an experience or link.

    nodes: EXPERIENCE_KEYS, poses in the map's frame [m, rad]; links: LINK_KEYS and `recall` (bool: the link was made
    by a recall and not with a new experience). `ends` gives the rows of each link's two experiences, (links, 2).
    """

    def __init__(self, nodes: Dict[str, np.ndarray], links: Dict[str, np.ndarray], name: str):
        self.nodes, self.links = nodes, links
        rows = {int(node): row for row, node in enumerate(nodes["id"])}
        if len(rows) != len(nodes["id"]):
            raise InputError(f"{name}: an experience's id occurs twice")
        try:
            pairs = [(rows[int(a)], rows[int(b)]) for a, b in zip(links["from"], links["to"])]
        except KeyError as error:
            raise InputError(f"{name}: a link names experience {error.args[0]}, which is not there") from None
        self.ends = np.array(pairs, dtype=int).reshape(-1, 2)

    @property
    def loop_ends(self) -> np.ndarray:
        """Rows of the two experiences of each link by recall, (loops, 2)."""
        return self.ends[self.links["recall"]]


def read_map(path: str) -> Map:
    """Reads map.yaml, one experience or link a line in flow style (docs/evaluation.md has the format)."""
    entries: Dict[str, list] = {"experiences": [], "links": []}
    section = None
    for number, line in text_file.read_lines(path):
        match = ENTRY.match(line)
        if match is None:
            name = line.split(":", 1)[0].strip()
            if name in entries:
                section = name
            elif line.startswith("-"):
                raise InputError(f"{path}:{number}: an entry that is cut off: {text_file.shown(line)}")
            continue
        if section is None:
            raise InputError(f"{path}:{number}: an entry outside experiences and links")
        pairs = (item.partition(":") for item in match.group(1).split(","))
        entries[section].append({key.strip(): value.strip() for key, _, value in pairs})
    if not entries["experiences"]:
        raise InputError(f"{path}: no experiences")
    nodes = {key: _column(path, entries["experiences"], key) for key in EXPERIENCE_KEYS}
    links = {key: _column(path, entries["links"], key) for key in LINK_KEYS}
    links["recall"] = np.array([entry.get("recall") == "true" for entry in entries["links"]], dtype=bool)
    return Map(nodes, links, path)


def _column(path: str, entries: list, key: str) -> np.ndarray:
    """One key of all entries as numbers. Keys of maps with scale may be missing and count as 0.
    """
    optional = key in ("z", "log_scale")
    try:
        column = np.array([text_file.number(entry.get(key, "0") if optional else entry[key]) for entry in entries])
    except KeyError:
        raise InputError(f"{path}: an entry has no {key}") from None
    except ValueError as error:
        raise InputError(f"{path}: {key}: {error}") from None
    if not np.isfinite(column).all():
        raise InputError(f"{path}: {key}: a value is NaN or infinite")
    return column


def read_columns(path: str, needed: Sequence[str]) -> Dict[str, np.ndarray]:
    """A CSV file with a head as a dict of number arrays. @throws InputError if one of the columns `needed` is missing"""
    lines = [(number, line.split(",")) for number, line in text_file.read_lines(path)]
    if not lines:
        raise InputError(f"{path}: empty")
    names = [name.strip() for name in lines[0][1]]
    absent = [name for name in needed if name not in names]
    if absent:
        raise InputError(f"{path}: no column {absent[0]}; needed are {', '.join(needed)}, parted by commas")
    rows = []
    for number, words in lines[1:]:
        if len(words) != len(names):
            raise InputError(f"{path}:{number}: {len(words)} columns under a head of {len(names)}")
        try:
            rows.append([text_file.finite_number(word) for word in words])
        except ValueError as error:
            raise InputError(f"{path}:{number}: {error}") from None
    table = np.array(rows).reshape(len(rows), len(names))
    return {name: table[:, column] for column, name in enumerate(names)}


# Files of ratslam_em, <trajectory_file>_online.tum, ..., by their names in a run folder.
NODE_FILES = {"trajectory_online.tum": "_online.tum", "trajectory_final.tum": "_final.tum", "map.yaml": "_map.yaml"}
# What a run leaves in its folder; behind `_2`, `_3`, ... its further stretches.
RUN_FILES = re.compile(
    r"(trajectory_(online|final|odometry)\.tum|(odometry|pose_covariance|templates|actions|pose_cells)\.csv|map\.yaml"
    r"|pose_cells\.npz|(summary|command|result)\.json)"
)


def files_of_run(run: str) -> List[str]:
    """Paths of the files that the run in a folder has left, or that the nodes have with their trajectory_file."""
    if not os.path.isdir(run):
        known = [run + ending for ending in NODE_FILES.values()]
        return [path for first in known for path in (first, *later_files(first))]
    return [os.path.join(run, name) for name in os.listdir(run) if RUN_FILES.fullmatch(re.sub(r"_\d+(?=\.\w+$)", "", name))]


class Run:
    """Content of a run folder. Missing parts are None (the summary: empty).

    A trajectory whose time went back, as in a looped bag or where the run went on in a loaded map, has all its stretches
    behind one another (Trajectory.stretches).

    For a run of the nodes the value of their parameter trajectory_file replaces the folder.
    """

    def __init__(self, folder: str):
        self._of_nodes = not os.path.isdir(folder) and os.path.isfile(folder + NODE_FILES["trajectory_final.tum"])
        if not self._of_nodes:
            require_folder(folder)
        self.folder = folder
        self.name = os.path.basename(os.path.abspath(folder))
        self.final: Optional[Trajectory] = self._read("trajectory_final.tum", read_stretches)
        self.online: Optional[Trajectory] = self._read("trajectory_online.tum", read_stretches)
        self.odometry: Optional[Trajectory] = self._read("trajectory_odometry.tum", read_stretches)
        self.map: Optional[Map] = self._read("map.yaml", read_map)
        self.templates = self._read("templates.csv", read_columns, TEMPLATE_COLUMNS)
        self.actions = self._read("actions.csv", read_columns, ACTION_COLUMNS)
        self.activity = self._read("pose_cells.csv", read_columns, ACTIVITY_COLUMNS)
        self.pose_cells: Optional[Dict[str, np.ndarray]] = self._read("pose_cells.npz", read_arrays)
        self.summary = self._read("summary.json", read_json) or {}
        if self.final is None:
            raise InputError(f"{folder}: no trajectory_final.tum: not a folder that ratslam_run left")
        labels = ((self.final, "final"), (self.online, "online"), (self.odometry, "odometry"))
        for trajectory, label in labels:
            if trajectory is not None:
                trajectory.name = label

    def _read(self, name: str, reader, *more):
        if self._of_nodes and name not in NODE_FILES:
            return None
        path = self.folder + NODE_FILES[name] if self._of_nodes else os.path.join(self.folder, name)
        return reader(path, *more) if os.path.exists(path) else None

    @property
    def trajectories(self) -> list:
        """The online (if there) and final trajectory."""
        return [trajectory for trajectory in (self.online, self.final) if trajectory is not None]

    def own_stretches(self, trajectory: Trajectory) -> range:
        """Which stretches of a trajectory, from 0, are of the recording that this run read: the last one, and those before
        it as often as time went back within the run (summary.json counts it). Earlier ones came with a loaded map.
        """
        counts = self.summary.get("counts")
        beginnings = counts.get("new_beginnings", 0) if isinstance(counts, dict) else 0
        again = int(beginnings) if isinstance(beginnings, (int, float)) and 0 <= beginnings < 1e9 else 0
        count = len(trajectory.stretches)
        return range(max(0, count - 1 - again), count)

    def silence(self, stamps: np.ndarray) -> float:
        """Time [s] between two stamps of the run for which it says nothing of the way: no line of a figure bridges it. It is the
        parameter odometry_gap, or more where images are rare; infinite where the summary does not state it."""
        parameters = self.summary.get("parameters")
        stated = parameters.get("odometry_gap") if isinstance(parameters, dict) else None
        if not isinstance(stated, (int, float)) or len(stamps) < 2:
            return math.inf
        return max(float(stated), RARE * float(np.median(np.abs(np.diff(stamps)))))

    @property
    def timing(self) -> Dict[str, float]:
        """Time of each module from the summary's `timing`: numbers, or the `mean_ms` of objects."""
        entries = self.summary.get("timing", {})
        times = {}
        for name, value in entries.items() if isinstance(entries, dict) else ():
            if isinstance(value, dict):
                value = value.get("mean_ms")
            if isinstance(value, (int, float)) and not isinstance(value, bool):
                times[name] = float(value)
        return times


def read_arrays(path: str) -> Dict[str, np.ndarray]:
    """Arrays of an .npz file: of the pose cells `stamps` [ns] and `activity` (snapshots, headings, rows, columns)."""
    if not os.path.isfile(path):  # opening a pipe would block
        raise InputError(f"{path}: not arrays of numpy: it is no regular file")
    try:
        with np.load(path, allow_pickle=False) as arrays:
            return dict(arrays)
    except (OSError, ValueError, EOFError, RuntimeError, TypeError, zipfile.BadZipFile, zlib.error) as error:
        raise InputError(f"{path}: not arrays of numpy: {one_line(error)}") from None


def read_json(path: str) -> dict:
    """A JSON object."""
    try:
        value = json.loads(text_file.read_text(path))
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: not JSON: {one_line(error)}") from None
    if not isinstance(value, dict):
        raise InputError(f"{path}: not a JSON object")
    return value
