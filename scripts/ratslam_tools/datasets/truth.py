"""Reads the ground truth of a run from a TUM or KITTI file, a KITTI folder, or a bag. The result is in base
convention.
"""

import os
from typing import Optional, Tuple

import numpy as np

from ratslam_tools.datasets import bags, kitti
from ratslam_tools.trajectory import frames
from ratslam_tools.errors import InputError, require_effect
from ratslam_tools.trajectory import Trajectory, has_stamps, read_table, read_trajectory

TRUTH_TOPIC = "ground_truth"


def find_times(path: str) -> Optional[str]:
    """times.txt that belongs to a KITTI file of poses: beside it, or in the benchmark's layout; None if there
    is none.
    """
    folder, name = os.path.split(os.path.abspath(path))
    sequence = os.path.join(os.path.dirname(folder), "sequences", os.path.splitext(name)[0])
    candidates = (os.path.join(folder, "times.txt"), os.path.join(sequence, "times.txt"))
    return next((candidate for candidate in candidates if os.path.isfile(candidate)), None)


def read_truth(path: str, times: Optional[str] = None) -> Trajectory:
    """Truth with stamps, x forward and z up.

    @param path a TUM or KITTI file, the folder of a KITTI sequence, or a bag with a topic named ground_truth.
    @param times times.txt of a KITTI file; if None it is searched beside the file.
    @throws InputError saying what is missing.
    """
    if os.path.isdir(path):
        poses = kitti.poses_file(path)
        if poses is None:
            raise InputError(f"{path}: no poses.txt, and none in ../../poses")
        return read_truth(poses, times or os.path.join(path, "times.txt"))
    if bags.is_bag(path):
        require_effect(False, f"{path} has stamps of its own", times=times)
        return frames.to_base(read_bag(path))
    is_kitti = read_table(path).shape[1] == 12
    require_effect(not has_stamps(path), f"{path} has stamps of its own", times=times)
    times = (times or find_times(path)) if is_kitti else None
    if is_kitti and times is None:
        raise InputError(
            f"{path}: KITTI poses have no stamps, and no times.txt lies beside them: give --times"
        )
    return frames.to_base(read_trajectory(path, times=times, allow_repeats=True))


def read_bag(path: str) -> Trajectory:
    """The poses of a bag's only topic named ground_truth, in their own axes. @throws InputError listing the topics"""
    return bags.read_trajectory_topic(path, _truth_topic(path), allow_repeats=True)


def read_plane_poses(path: str) -> Tuple[np.ndarray, np.ndarray]:
    """Planar truth for each frame from a KITTI file of poses, or a bag's ground_truth: positions (n, 2), x forward and y to
    the left [m], and headings (n,), counter-clockwise [rad]. @throws InputError naming the file.
    """
    if bags.is_bag(path):
        poses = read_truth(path)
        return poses.positions[:, :2], np.arctan2(poses.rotations[:, 1, 0], poses.rotations[:, 0, 0])
    columns = read_table(path).shape[1]
    if columns != 12:
        raise InputError(f"{path}: {columns} numbers a line; KITTI poses have 12")
    poses = read_trajectory(path, "kitti")
    positions, turns = poses.positions, poses.rotations
    return np.stack([positions[:, 2], -positions[:, 0]], axis=1), np.arctan2(-turns[:, 0, 2], turns[:, 2, 2])


def _truth_topic(path: str) -> str:
    with bags.reading(path) as bag:
        topics = sorted(bag.get_type_and_topic_info().topics)
    found = [topic for topic in topics if topic.split("/")[-1] == TRUTH_TOPIC]
    if len(found) != 1:
        raise InputError(
            f"{path}: {len(found)} topics named {TRUTH_TOPIC}; it has: {', '.join(topics) or 'none'}"
        )
    return found[0]
