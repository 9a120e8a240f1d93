"""Sources of trajectories for the evaluation commands: files, or topics of a bag."""

import os
import sys
from typing import List, Optional

from ratslam_tools.datasets import bags, truth
from ratslam_tools.errors import InputError, require_effect
from ratslam_tools.trajectory import Trajectory, has_stamps, later_files, read_trajectory


def read_reference(path: str, form: str, times: Optional[str], bag: Optional[str]) -> Trajectory:
    """The reference: a file, a bag with a topic named ground_truth, or with `bag` a topic. Its stamps may repeat (see
    association.associate).
    """
    if bag is not None:
        return read_topic(bag, path, allow_repeats=True)
    if bags.is_bag(path):
        return truth.read_bag(path)
    return read_trajectory(path, form, times, allow_repeats=True)


def require_effects(paths: List[str], form: str, times: Optional[str], bag: Optional[str]) -> None:
    """@throws InputError for options that have no effect on any of the trajectories."""
    require_effect(bag is None, "poses of a --bag have stamps of their own", times=times)
    require_effect(bag is None, "of a --bag topics are read", format=None if form == "auto" else form)
    unstamped = times is None or not all(bags.is_bag(path) or has_stamps(path, form) for path in paths)
    require_effect(unstamped, "only KITTI poses have no stamps of their own, and no file has such", times=times)


def read_estimates(paths: List[str], form: str, times: Optional[str], bag: Optional[str]) -> List[Trajectory]:
    """The estimates, with distinct names."""
    for path in paths if bag is None else ():
        if bags.is_bag(path):
            raise InputError(f"{path}: which topic of the bag is the estimate? give --bag {path} REF_TOPIC EST_TOPIC")
    trajectories = [
        read_topic(bag, path) if bag is not None else read_trajectory(path, form, times) for path in paths
    ]
    for path in paths if bag is None else ():
        tell_later_files(path, paths)
    for trajectory, label in zip(trajectories, labels(paths)):
        trajectory.name = label
    return trajectories


def tell_later_files(path: str, read=()) -> None:
    """Prints a note if a run's trajectory goes on in further files that are not among those read."""
    if not os.path.splitext(path)[0].endswith(("_final", "_online", "_odometry")):
        return  # only these names show that a file is one of a run
    missing = [later for later in later_files(path) if later not in read]
    if missing:
        print(f"note: {path}: only this stretch is evaluated; the trajectory goes on in {', '.join(missing)}", file=sys.stderr)


def labels(paths: List[str]) -> List[str]:
    """Short distinct names of files: the last parts of their paths, as many as it takes."""
    parts = [os.path.normpath(path).split(os.sep) for path in paths]
    for depth in range(1, max(map(len, parts)) + 1):
        names = [os.path.join(*part[-depth:]) for part in parts]
        if len(set(names)) == len(names):
            return names
    return [f"{path} ({number})" for number, path in enumerate(paths, 1)]


def read_topic(bag: str, topic: str, allow_repeats: bool = False) -> Trajectory:
    """Poses of one topic of a bag (Odometry, PoseStamped, PoseWithCovarianceStamped, TransformStamped, or the
    last Path). @param allow_repeats as in Trajectory.check.
    """
    return bags.read_trajectory_topic(bag, topic, allow_repeats)
