"""APE, RPE and KITTI's drift, as defined in docs/evaluation.md; equations (7)-(11) of the source paper.

Q is the reference, P the estimate, both matched pose by pose.
"""

from typing import Dict, List, Tuple

import numpy as np

from ratslam_tools.trajectory import geometry
from ratslam_tools.errors import InputError
from ratslam_tools.trajectory import Trajectory

RELATIONS = {"trans_part": "m", "angle_deg": "deg", "angle_rad": "rad", "full": "unit-less"}
STATISTICS = ("max", "mean", "median", "min", "rmse", "std", "sse")
KITTI_LENGTHS = tuple(range(100, 801, 100))  # [m]
KITTI_FIRST_FRAME_STEP = 10
PATH_TOLERANCE = 0.1  # largest error of the length of an overlapping pair, as a share of the requested length


def statistics(errors: np.ndarray) -> Dict[str, float]:
    """The figures of one error array (n,)."""
    sse = float(errors @ errors)
    return {
        "max": float(errors.max()),
        "mean": float(errors.mean()),
        "median": float(np.median(errors)),
        "min": float(errors.min()),
        "rmse": float(np.sqrt(sse / len(errors))),
        "std": float(errors.std()),
        "sse": sse,
    }


def _reduce(rotations: np.ndarray, translations: np.ndarray, relation: str) -> np.ndarray:
    """One number for each error pose (rotations (n, 3, 3), translations (n, 3))."""
    if relation == "trans_part":
        return np.linalg.norm(translations, axis=1)
    if relation == "full":
        deviation = ((rotations - np.eye(3)) ** 2).sum(axis=(1, 2))
        return np.sqrt(deviation + (translations**2).sum(axis=1))
    angles = geometry.rotation_angles(rotations)
    return np.degrees(angles) if relation == "angle_deg" else angles


def ape(reference: Trajectory, estimate: Trajectory, relation: str = "trans_part") -> np.ndarray:
    """Absolute pose errors (7), F_i = Q_i^-1 P_i of an estimate already aligned: (n,) in the relation's
    unit.
    """
    inverse = geometry.transpose(reference.rotations)
    return _reduce(
        inverse @ estimate.rotations,
        geometry.rotate(inverse, estimate.positions - reference.positions),
        relation,
    )


def _relative(trajectory: Trajectory, starts: np.ndarray, ends: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """T_start^-1 T_end of each pair."""
    inverse = geometry.transpose(trajectory.rotations[starts])
    return (
        inverse @ trajectory.rotations[ends],
        geometry.rotate(inverse, trajectory.positions[ends] - trajectory.positions[starts]),
    )


def rpe(
    reference: Trajectory,
    estimate: Trajectory,
    starts: np.ndarray,
    ends: np.ndarray,
    relation: str = "trans_part",
) -> np.ndarray:
    """Relative pose errors (9), (Q_i^-1 Q_j)^-1 (P_i^-1 P_j), of the pairs (starts, ends)."""
    reference_rotations, reference_steps = _relative(reference, starts, ends)
    estimate_rotations, estimate_steps = _relative(estimate, starts, ends)
    inverse = geometry.transpose(reference_rotations)
    return _reduce(
        inverse @ estimate_rotations, geometry.rotate(inverse, estimate_steps - reference_steps), relation
    )


def frame_pairs(count: int, step: int, overlapping: bool) -> Tuple[np.ndarray, np.ndarray]:
    """Pairs of poses `step` poses apart: starting at every pose, or one after another."""
    starts = np.arange(0, count - step, 1 if overlapping else step)
    return starts, starts + step


def path_pairs(trajectory: Trajectory, length: float, overlapping: bool) -> Tuple[np.ndarray, np.ndarray]:
    """Pairs of poses `length` metres of path apart.

    One after another: between the poses that complete the length, the first of which is the first pose to
    have travelled it.
    Overlapping: from every pose to the pose whose distance along the path is nearest to the length, if within
    10% of it.
    """
    path = trajectory.path_length()
    if not overlapping:
        ends: List[int] = []
        steps = np.diff(path)
        travelled = 0.0
        for index, step in enumerate(steps, 1):
            travelled += step
            if travelled >= length:
                ends.append(index)
                travelled = 0.0
        return np.array(ends[:-1], dtype=int), np.array(ends[1:], dtype=int)
    targets = path + length
    after = np.clip(np.searchsorted(path, targets), 1, len(path) - 1)
    before = after - 1
    ends_ = np.where(np.abs(path[before] - targets) <= np.abs(path[after] - targets), before, after)
    starts = np.arange(len(path))
    keep = (np.abs(path[ends_] - targets) <= PATH_TOLERANCE * length) & (ends_ > starts)
    return starts[keep], ends_[keep]


def pose_pairs(
    trajectory: Trajectory, delta: float, unit: str, overlapping: bool
) -> Tuple[np.ndarray, np.ndarray]:
    """Pairs for RPE over `delta` frames (unit f) or metres (unit m). @throws InputError if there are none."""
    if not np.isfinite(delta) or delta <= 0 or (unit == "f" and delta != int(delta)):
        raise InputError(
            f"--delta: {delta:g} is not allowed: a positive {'whole ' if unit == 'f' else ''}number"
        )
    if unit == "f":
        starts, ends = frame_pairs(len(trajectory), int(delta), overlapping)
    else:
        starts, ends = path_pairs(trajectory, delta, overlapping)
    if len(starts) == 0:
        name = "frames" if unit == "f" else "m"
        raise InputError(
            f"{trajectory.name}: no two of its {len(trajectory)} matched poses "
            f"({trajectory.path_length()[-1]:.6g} m) are {delta:g} {name} apart"
        )
    return starts, ends


def rmse_of_all_steps(
    reference: Trajectory, estimate: Trajectory, relation: str = "trans_part"
) -> np.ndarray:
    """RMSE of the RPE over each step of 1 ... n-1 frames, overlapping pairs: (n-1,). Its mean is equation
    (11).
    """
    count = len(reference)
    results = np.empty(count - 1)
    for step in range(1, count):
        errors = rpe(reference, estimate, *frame_pairs(count, step, True), relation=relation)
        results[step - 1] = np.sqrt(np.mean(errors**2))
    return results


def kitti_drift(reference: Trajectory, estimate: Trajectory, lengths=KITTI_LENGTHS) -> List[Dict[str, float]]:
    """KITTI's drift over sub-sequences of given lengths [m], started at every tenth pose of the reference.

    A sub-sequence ends at the first pose farther than the length along the reference.
    Returns one dict for each length that fits: length_m, count, translation_percent, rotation_deg_per_100m
    (means). @throws InputError if not even the shortest fits.
    Source: Geiger, Lenz, Urtasun, Are we ready for autonomous driving?, CVPR 2012, and the benchmark's
    description.
    """
    path = reference.path_length()
    rows = []
    for length in lengths:
        starts = np.arange(0, len(path), KITTI_FIRST_FRAME_STEP)
        ends = np.searchsorted(path, path[starts] + length, side="right")
        starts, ends = starts[ends < len(path)], ends[ends < len(path)]
        if len(starts) == 0:
            continue
        translation = rpe(reference, estimate, starts, ends, "trans_part") / length
        rotation = rpe(reference, estimate, starts, ends, "angle_deg") / length
        rows.append(
            {
                "length_m": length,
                "count": len(starts),
                "translation_percent": 100 * float(translation.mean()),
                "rotation_deg_per_100m": 100 * float(rotation.mean()),
            }
        )
    if not rows:
        raise InputError(
            f"{reference.name}: {path[-1]:.6g} m of matched path; KITTI's drift needs more than "
            f"{lengths[0]} m"
        )
    return rows


def kitti_average(rows: List[Dict[str, float]]) -> Dict[str, float]:
    """Average over all sub-sequences of `kitti_drift`, whatever their length."""
    count = sum(row["count"] for row in rows)
    return {
        key: sum(row[key] * row["count"] for row in rows) / count
        for key in ("translation_percent", "rotation_deg_per_100m")
    }
