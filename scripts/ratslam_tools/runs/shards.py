"""A sweep divided among machines: its shards, and their results put together."""

import os
from typing import Dict, List, Tuple

from ratslam_tools.errors import InputError
from ratslam_tools.runs import run_folder
from ratslam_tools.runs.grid import RESULT, folder_name


def shard(points, text: str):
    """The points of shard K of N, 1 <= K <= N: every Nth of the grid. @throws InputError for another form."""
    first, _, second = text.partition("/")
    if not (first.isdigit() and second.isdigit() and 1 <= int(first) <= int(second)):
        raise InputError(f"--shard: '{text}' is not allowed: K/N with K from 1 to N, such as 3/8")
    return points[int(first) - 1 :: int(second)]


def merge(folders: List[str], points):
    """Results by index of the point, from the shards' folders, and the points that no shard has. @throws InputError for what
    is no result, was judged by another truth than the others, or is of another command or recording
    """
    found, first = {}, None
    for index, point in enumerate(points):
        paths = (os.path.join(folder, "runs", folder_name(point), RESULT) for folder in folders)
        path = next(filter(os.path.isfile, paths), None)
        if path is not None:
            record = _read(path)
            found[index] = record["figures"]
            first = first or (path, record)
            _require_equal(*first, path, record)
    return found, [folder_name(point) for index, point in enumerate(points) if index not in found]


def _read(path: str) -> dict:
    """@throws InputError unless it is what a sweep leaves of a run"""
    record = run_folder.read_json(path)
    figures = record.get("figures")
    if not isinstance(figures, dict) or not all(isinstance(value, (int, float)) for value in figures.values()):
        raise InputError(f"{path}: not the result of a run: its figures are not numbers by name")
    words, inputs, settings = (record.get(key) for key in ("command", "inputs", "settings"))
    if not isinstance(words, list) or not isinstance(inputs, dict) or not isinstance(settings, dict):
        raise InputError(f"{path}: not the result of a run: command, inputs and settings are not there")
    return record


def _require_equal(path: str, record: dict, other: str, compared: dict) -> None:
    """@throws InputError unless two results may stand in one table"""
    if record.get("judged_by") != compared.get("judged_by"):
        raise InputError(f"--merge: {other} and {path} were judged by different truths, or matched with another --t_max_diff")
    here, there = _made_by(record), _made_by(compared)
    if here == there:
        return
    ends = [("", "")]
    one, two = next(pair for pair in zip(here + ends, there + ends) if pair[0] != pair[1])
    shown = [f"'{word}'" if word else "nothing" for word, _ in (two, one)]
    what = " and ".join(shown) if shown[0] != shown[1] else f"{shown[0]}, whose content differs"
    raise InputError(f"--merge: {other} and {path} are results of different runs: {what}; merge those of one command")


def _made_by(record: dict) -> List[Tuple[str, str]]:
    """What the figures depend on but for the varied settings: each word of the command with the content of the file that it
    names, then the program's libraries. A file's own place does not count, since machines may keep it elsewhere; nor does
    the odometry that a sweep has computed once for its runs."""
    inputs: Dict[str, str] = record["inputs"]
    varied = {f"{key}={value}" for key, value in record["settings"].items()}
    made, named, before, place = [], set(), "", None
    for word in record["command"]:
        named.add(word)
        if before == "--out":
            place = _folder_above(word)
        if before == "--odometry" and os.path.basename(word) == "odometry.csv" and _folder_above(word) == place:
            word = "odometry.csv"  # beside the runs
        if before != "--out" and not (before == "--set" and word in varied):
            made.append((word, inputs.get(word, "")))
        before = word
    return made + sorted(item for item in inputs.items() if item[0] not in named)


def _folder_above(path: str) -> str:
    """The folder that has the folder of a path: of a run's folder and of the odometry of all runs, the sweep's."""
    return os.path.dirname(os.path.dirname(path))
