"""Consistency of an estimate: the normalised estimation error squared (NEES).

NEES = e^T P^-1 e for an error e with stated covariance P. If both are right and Gaussian, it is
chi-squared distributed with as many degrees of freedom as e has components (Bar-Shalom, Li and Kirubarajan 2001,
5.4): nineteen of twenty lie within the 95 % band, and their mean is the number of components.
"""

import math
from typing import Dict

import numpy as np

from ratslam_tools.datasets import odometry_file
from ratslam_tools.errors import InputError
from ratslam_tools.trajectory import Trajectory, association, geometry

BAND = 0.95
MAX_CHI_SQUARED = 1e4
# Upper triangle of the covariance of x, y, z, yaw in pose_covariance.csv.
COVARIANCE_COLUMNS = (("xx", "xy", "xz", "xyaw"), ("yy", "yz", "yyaw"), ("zz", "zyaw"), ("yawyaw",))
POSE_COLUMNS = ("stamp", "x", "y", "z", "yaw", *(name for line in COVARIANCE_COLUMNS for name in line))
GREATEST_SHIFT = 1.0  # of the NEES, whose mean is 4, by the alignment


def chi_squared_quantile(share: float, freedom: int) -> float:
    """x with P(chi-squared <= x) = share, for an even number of degrees of freedom (a sum in closed form)."""
    if freedom < 2 or freedom % 2:
        raise ValueError(f"{freedom} degrees of freedom: only even numbers have a closed form")

    def below(x: float) -> float:
        terms = (math.exp(k * math.log(x / 2) - math.lgamma(k + 1) - x / 2) for k in range(freedom // 2))
        return 1.0 - sum(terms)

    low, high = 1e-12, MAX_CHI_SQUARED
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if below(middle) < share else (low, middle)
    return 0.5 * (low + high)


def nees(errors: np.ndarray, covariances: np.ndarray) -> np.ndarray:
    """e^T P^-1 e, (n,), of errors (n, k) and covariances (n, k, k). @throws InputError for a singular P."""
    try:
        solved = np.linalg.solve(covariances, errors[:, :, None])[:, :, 0]
    except np.linalg.LinAlgError:
        raise InputError("a covariance is singular: an error that was said to be impossible has no NEES") from None
    return np.einsum("ij,ij->i", errors, solved)


def summary(values: np.ndarray, freedom: int) -> Dict[str, float]:
    """Summary of NEES (n,) relative to their 95 % band."""
    low = chi_squared_quantile((1 - BAND) / 2, freedom)
    high = chi_squared_quantile((1 + BAND) / 2, freedom)
    return {
        "count": len(values),
        "freedom": freedom,
        "mean": float(values.mean()),
        "median": float(np.median(values)),
        "band": [low, high],
        "percent_in_band": float(100 * np.mean((values >= low) & (values <= high))),
        "percent_below": float(100 * np.mean(values < low)),
        "percent_above": float(100 * np.mean(values > high)),
        "percent_to_95": float(100 * np.mean(values <= chi_squared_quantile(BAND, freedom))),
    }


def motion_nees(odometry: odometry_file.Motions, truth: Trajectory) -> np.ndarray:
    """NEES, 6 degrees of freedom, of the motion from each sample to the next: error of translation and rotation in
    the axes of base_link at its end, with the covariance of the twist times dt^2.

    Samples that were predicted (bridged), or have no covariance or no true pose, are left out. @throws InputError if
    none is left.
    """
    rows, partners = association.match_stamps(odometry.stamps, truth.stamps, association.MAX_STAMP_DIFFERENCE_S)
    true_row = np.full(len(odometry.stamps), -1)
    true_row[rows] = partners
    known = np.isfinite(odometry.covariances).all(axis=(1, 2)) & odometry.covariances.any(axis=(1, 2))
    known &= np.isfinite(odometry.positions).all(axis=1) & ~odometry.bridged & (true_row >= 0)
    ends = np.flatnonzero(known[1:] & known[:-1] & ~odometry.corrected[1:]) + 1
    if len(ends) == 0:
        raise InputError("no sample of the odometry has pose, covariance and a true pose")

    def motions(positions, rotations, before, after):
        turned = np.swapaxes(rotations[before], 1, 2)
        moved = np.einsum("nij,nj->ni", turned, positions[after] - positions[before])
        return moved, turned @ rotations[after]

    moved, turned = motions(odometry.positions, odometry.rotations, ends - 1, ends)
    true_moved, true_turned = motions(truth.positions, truth.rotations, true_row[ends - 1], true_row[ends])
    back = np.swapaxes(true_turned, 1, 2)
    errors = np.hstack(
        [np.einsum("nij,nj->ni", back, moved - true_moved), geometry.rotation_vectors(back @ turned)]
    )
    dt = (odometry.stamps[ends] - odometry.stamps[ends - 1])[:, None, None]
    return nees(errors, odometry.covariances[ends] * dt**2)


def pose_nees(poses: Dict[str, np.ndarray], path: Trajectory, truth: Trajectory) -> np.ndarray:
    """NEES, 4 degrees of freedom (x, y, z, yaw), of the robot's poses in the map.

    The truth is aligned with the first pose that has a true one, by all three angles: a map is level where it begins, and
    the axes of a truth may be tilted, as those of KITTI's first camera are. That pose must be all but exact in the map, as at
    the beginning of a new map, because its error goes into all others.
    @param poses POSE_COLUMNS of pose_covariance.csv
    @param path trajectory_online.tum of the same run, for the roll and pitch of the first pose
    @throws InputError if the first pose is uncertain or not on the path, or fewer than two poses have a true one
    """
    rows, partners = association.match_stamps(poses["stamp"], truth.stamps, association.MAX_STAMP_DIFFERENCE_S)
    if len(rows) < 2:
        raise InputError("fewer than two poses of the map have a true pose")
    first, on_path = association.match_stamps(poses["stamp"][rows[:1]], path.stamps, association.MAX_STAMP_DIFFERENCE_S)
    if len(first) == 0:
        raise InputError(f"the pose at {poses['stamp'][rows[0]]:.6f} s is not in {path.name}")
    estimates = np.stack([poses[name][rows] for name in ("x", "y", "z", "yaw")], axis=1)
    turn = path.rotations[on_path[0]] @ truth.rotations[partners[0]].T
    turned = turn @ truth.rotations[partners]
    expected = np.empty_like(estimates)
    expected[:, :3] = estimates[0, :3] + (truth.positions[partners] - truth.positions[partners[0]]) @ turn.T
    expected[:, 3] = np.arctan2(turned[:, 1, 0], turned[:, 0, 0])
    errors = estimates - expected
    errors[:, 3] = np.arctan2(np.sin(errors[:, 3]), np.cos(errors[:, 3]))
    covariances = np.empty((len(rows), 4, 4))
    for row, line in enumerate(COVARIANCE_COLUMNS):
        for offset, name in enumerate(line):
            covariances[:, row, row + offset] = covariances[:, row + offset, row] = poses[name][rows]
    found = nees(errors[1:], covariances[1:])
    _require_exact_start(poses["stamp"][rows[0]], covariances, expected[:, :2] - expected[0, :2])
    return found


def _require_exact_start(stamp: float, covariances: np.ndarray, ways: np.ndarray) -> None:
    """@throws InputError if the first pose is so uncertain that the alignment with it shifts the NEES of the others.

    An error e0 of the first pose, turned about it, adds J e0 to every other one, where J has the way to it as the lever of the
    yaw. With P0 = E(e0 e0^T) the NEES shifts by trace(P^-1 J P0 J^T): up if the errors are independent, down if they have e0
    in common. @param ways from the first pose to each (n, 2) [m]
    """
    levers = np.tile(np.eye(4), (len(ways), 1, 1))
    levers[:, 0, 3], levers[:, 1, 3] = -ways[:, 1], ways[:, 0]
    added = (levers @ covariances[0] @ np.swapaxes(levers, 1, 2))[1:]
    shift = np.median(np.trace(np.linalg.solve(covariances[1:], added), axis1=1, axis2=2))
    if shift > GREATEST_SHIFT:
        place = math.sqrt(max(0.0, *np.linalg.eigvalsh(covariances[0, :3, :3])))
        yaw = math.sqrt(max(0.0, covariances[0, 3, 3]))
        raise InputError(
            f"the pose at {stamp:.6f} s, with which the truth is aligned, has a sigma of {place:.3g} m and {yaw:.3g} rad in the "
            "map, and its error would be that of all others; right is a run that begins its own map, with the truth from its "
            "first pose on"
        )
