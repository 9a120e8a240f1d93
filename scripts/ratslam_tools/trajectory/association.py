"""Matching of an estimate's poses with those of the reference, and alignment.
"""

from typing import Optional, Tuple

import numpy as np

from ratslam_tools.trajectory import geometry
from ratslam_tools.errors import InputError, require_effect
from ratslam_tools.trajectory import Trajectory

MIN_MATCHES = 3
MAX_STAMP_DIFFERENCE_S = 0.01
# Share of a path's length. A path nearer to a line than the rounding of files counts as a line.
LINE_WIDTH = 1e-6
# Shortest that an alignment may make the streets of a map, as a share of the true ones. An odometry whose unit drifts, or that
# is too slow on fast stretches, leaves them half or a third as long; parts that are not joined, hundredths.
LEAST_LENGTH = 0.2
PARTS = 50  # of a path, whose lengths are compared


def match_stamps(
    first: np.ndarray, second: np.ndarray, max_difference: float
) -> Tuple[np.ndarray, np.ndarray]:
    """Index arrays of matching stamps (both lists sorted): nearest, within `max_difference` [s], one to one.

    Each stamp of the shorter list is matched with the nearest one of the longer list. If two have the same one, the
    nearer gets it.
    """
    if len(first) > len(second):
        second_rows, first_rows = match_stamps(second, first, max_difference)
        return first_rows, second_rows
    after = np.clip(np.searchsorted(second, first), 1, max(len(second) - 1, 1))
    before = after - 1
    after = np.minimum(after, len(second) - 1)
    nearest = np.where(np.abs(second[before] - first) <= np.abs(second[after] - first), before, after)
    difference = np.abs(second[nearest] - first)
    rows = np.flatnonzero(difference <= max_difference)
    rows = rows[np.lexsort((rows, difference[rows], nearest[rows]))]
    _, winners = np.unique(nearest[rows], return_index=True)
    rows = np.sort(rows[winners])
    return rows, nearest[rows]


def associate(
    reference: Trajectory,
    estimate: Trajectory,
    max_difference: float = MAX_STAMP_DIFFERENCE_S,
    offset: float = 0.0,
) -> Tuple[Trajectory, Trajectory]:
    """The matched poses of both, of equal length: by stamp, or by number if neither has stamps. Each of several
    stretches of the estimate is matched by itself.

    @param offset [s] added to the estimate's stamps.
    @throws InputError when they cannot be matched, match in fewer than 3 poses, or all lie at one point; and
        when a match falls on a stamp that the reference has twice (elsewhere in the reference a repeated
        stamp changes nothing).
    """
    if (reference.stamps is None) != (estimate.stamps is None):
        missing, other = (reference, estimate) if reference.stamps is None else (estimate, reference)
        raise InputError(
            f"{missing.name} has no stamps and {other.name} has: give --times, the file with their times"
        )
    if reference.stamps is None:
        why = f"{reference.name} and {estimate.name} have no stamps"
        require_effect(offset == 0.0, why, t_offset=offset)
        require_effect(max_difference == MAX_STAMP_DIFFERENCE_S, why, t_max_diff=max_difference)
        if len(reference) != len(estimate):
            raise InputError(
                f"{reference.name} has {len(reference)} poses and {estimate.name} {len(estimate)}: files "
                f"without "
                "stamps are matched line by line and must be equally long"
            )
    else:
        matches, begin = [], 0
        for stretch in estimate.stretches:
            rows, other_rows = match_stamps(reference.stamps, stretch.stamps + offset, max_difference)
            matches.append((rows, begin + other_rows))
            begin += len(stretch)
        rows, other_rows = (np.concatenate(found) for found in zip(*matches))
        count = len(rows)
        if count < MIN_MATCHES:
            raise InputError(
                f"{estimate.name}: {count} poses match {reference.name} within {max_difference:g} s; at "
                f"least {MIN_MATCHES} "
                f"are needed (stamps {estimate.stamps.min() + offset:.3f} to "
                f"{estimate.stamps.max() + offset:.3f} against "
                f"{reference.stamps[0]:.3f} to {reference.stamps[-1]:.3f})"
            )
        repeated = rows[np.isin(reference.stamps[rows], reference.stamps[1:][np.diff(reference.stamps) == 0])]
        if len(repeated):
            raise InputError(
                f"{reference.name}: the stamp {reference.stamps[repeated[0]]:.9f} repeats, so that the pose "
                f"to "
                f"compare with {estimate.name} is ambiguous"
            )
        reference, estimate = reference.select(rows), estimate.select(other_rows)
    if len(reference) < MIN_MATCHES:
        raise InputError(f"{estimate.name}: {len(reference)} poses; at least {MIN_MATCHES} are needed")
    for trajectory in (reference, estimate):
        if np.ptp(trajectory.positions, axis=0).max() < 1e-9:
            raise InputError(f"{trajectory.name}: all matched poses lie at one point")
    return reference, estimate


class Alignment:
    """Transformation of an estimate to the reference: p' = scale R p + translation.

    `length`: how long the fitted scale makes parts of the path, as a share of the reference's (median); 1 if none was fitted.
    """

    def __init__(self, rotation, translation, scale: float, length: float = 1.0):
        self.rotation, self.translation, self.scale, self.length = rotation, translation, scale, length

    @property
    def collapsed(self) -> bool:
        """Whether the scale shrinks the path to no map of the same world, as where two parts of it are not joined and lie far
        apart."""
        return self.length < LEAST_LENGTH

    def apply(self, trajectory: Trajectory) -> Trajectory:
        """The trajectory in the reference's world."""
        return trajectory.transformed(self.rotation, self.translation, self.scale)


def on_a_line(positions: np.ndarray) -> bool:
    """Whether positions (n, 3) lie on one line."""
    spread = np.linalg.svd(positions - positions.mean(axis=0), compute_uv=False)
    return bool(spread[1] <= LINE_WIDTH * spread[0])


def fit_alignment(
    reference: Trajectory,
    estimate: Trajectory,
    align: bool,
    correct_scale: bool,
    n_to_align: Optional[int] = None,
    positions_only: bool = True,
) -> Alignment:
    """Alignment of matched trajectories: rigid (align), similarity (both), scale about the origin
    (correct_scale), or none.

    @param n_to_align number of first poses that are used; None: all.
    @param positions_only whether only the positions of these poses are evaluated after the alignment.
    @throws InputError if the used poses lie on one line, which leaves the rotation about it undetermined, and
    something depends on that rotation.
    """
    if not align and not correct_scale:
        return Alignment(np.eye(3), np.zeros(3), 1.0)
    if n_to_align is not None and n_to_align < MIN_MATCHES:
        raise InputError(f"--n_to_align: {n_to_align} is not allowed: at least {MIN_MATCHES}")
    rows = slice(0, n_to_align)
    for trajectory in (reference, estimate):
        if np.ptp(trajectory.positions[rows], axis=0).max() < 1e-9:
            raise InputError(
                f"{trajectory.name}: the poses to align by lie at one point"
            )
    lines = [trajectory.name for trajectory in (reference, estimate) if on_a_line(trajectory.positions[rows])]
    all_on_it = len(lines) == 2 and all(on_a_line(each.positions) for each in (reference, estimate))
    if align and lines and not (positions_only and all_on_it):
        which = "matched poses" if n_to_align is None else f"first {min(n_to_align, len(estimate))} matched poses"
        raise InputError(
            f"{lines[0]}: the {which} lie on one line: the rotation about it is not determined, and with it the "
            f"alignment"
        )
    rotation, translation, scale = geometry.umeyama(
        reference.positions[rows], estimate.positions[rows], correct_scale
    )
    length = 1.0
    if correct_scale:
        length = scale * _relative_length(reference.positions[rows], estimate.positions[rows])
    if not align:
        rotation, translation = np.eye(3), np.zeros(3)
    return Alignment(rotation, translation, scale, length)


def _relative_length(reference: np.ndarray, estimate: np.ndarray) -> float:
    """Median of length of the estimate / length of the reference over the parts of the path; positions (n, 3). A jump between two
    parts of a map has no effect on it. Of the parts the longer half counts, because the robot may have stood still in others.
    """
    ends = np.unique(np.linspace(0, len(reference) - 1, PARTS + 1).round().astype(int))
    true, found = (np.diff(geometry.path_length(positions)[ends]) for positions in (reference, estimate))
    driven = (true >= np.median(true)) & (true > 0.0)
    return float(np.median(found[driven] / true[driven]))
