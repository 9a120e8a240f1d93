"""Body and world conventions: base (x forward, y left, z up; REP-103) and camera (x right, y down, z
forward).

The body axis along which a trajectory moves shows its convention.
"""

from typing import Optional

import numpy as np

from ratslam_tools.trajectory import geometry
from ratslam_tools.errors import InputError
from ratslam_tools.trajectory import Trajectory

FRAMES = ("base", "camera")
PLANES = {"xy": 2, "xz": 1, "yz": 0}  # plane -> index of its normal
FORWARD = {"base": "x", "camera": "z"}
GROUND = {"base": "xy", "camera": "xz"}
# Share of the path that must lie along one body axis before a vehicle's convention is taken as known.
CERTAIN_SHARE = 0.8
# Thickness, as a share of its length, below which a trajectory counts as flat: a map's files have 9 digits.
FLAT = 1e-6


def moving_axis(trajectory: Trajectory) -> Optional[str]:
    """The body axis (x, y or z) of nearly all motion; None if there is none (a hand-held camera).
    """
    steps = np.diff(trajectory.positions, axis=0)
    in_body = geometry.rotate(geometry.transpose(trajectory.rotations[:-1]), steps)
    length = np.linalg.norm(steps, axis=1).sum()
    if length == 0:
        return None
    shares = np.abs(in_body).sum(axis=0) / length
    axis = int(np.argmax(shares))
    return "xyz"[axis] if shares[axis] >= CERTAIN_SHARE and np.delete(shares, axis).max() < 0.5 else None


def convention(trajectory: Trajectory) -> Optional[str]:
    """base or camera, from the body's motion; None if it is not clear."""
    axis = moving_axis(trajectory)
    return next((frame for frame, forward in FORWARD.items() if forward == axis), None)


def convert(trajectory: Trajectory, source: str, target: str) -> Trajectory:
    """World and body axes of `trajectory` changed from one convention to the other."""
    if source == target:
        return trajectory
    axes = geometry.CAMERA_TO_BASE if target == "base" else geometry.CAMERA_TO_BASE.T
    return trajectory.changed_axes(axes)


def to_base(trajectory: Trajectory) -> Trajectory:
    """The trajectory in base convention; unchanged unless it moves like a camera."""
    return convert(trajectory, "camera", "base") if convention(trajectory) == "camera" else trajectory


def require_same_axis(reference: Trajectory, estimate: Trajectory) -> None:
    """@throws InputError if both conventions are certain and differ: their body frames cannot be compared.
    """
    axes = [moving_axis(reference), moving_axis(estimate)]
    if None in axes or axes[0] == axes[1]:
        return
    names = {axis: f" (as {frame} frames do)" for frame, axis in FORWARD.items()}
    moves = [
        f"{trajectory.name} moves along its body's {axis} axis{names.get(axis, '')}"
        for trajectory, axis in zip((reference, estimate), axes)
    ]
    frames_of = {axis: frame for frame, axis in FORWARD.items()}
    advice = ""
    if all(axis in frames_of for axis in axes):
        advice = f"; give --ref_frame {frames_of[axes[0]]} --est_frame {frames_of[axes[1]]} to convert them"
    raise InputError(f"the body frames differ: {moves[0]}, {moves[1]}{advice}")


def laid_level(trajectory: Trajectory, plane: str) -> Trajectory:
    """Rotates a trajectory that lies in a plane into coordinate plane `plane`. Returns any other unchanged."""
    centred = trajectory.positions - trajectory.positions.mean(axis=0)
    _, extents, axes = np.linalg.svd(centred, full_matrices=False)
    if extents[2] > FLAT * extents[0] or extents[1] <= FLAT * extents[0]:
        return trajectory
    target = np.eye(3)[PLANES[plane]]
    normal = axes[2] if axes[2] @ target >= 0 else -axes[2]
    return trajectory.transformed(geometry.rotation_between(normal, target), np.zeros(3))


def project(trajectory: Trajectory, plane: str) -> Trajectory:
    """Projects a trajectory to a coordinate plane (xy, xz or yz): no offset along the normal, rotations about the
    normal only.
    """
    normal = PLANES[plane]
    positions = trajectory.positions.copy()
    positions[:, normal] = 0.0
    return Trajectory(
        positions, geometry.twist_about(trajectory.rotations, normal), trajectory.stamps, trajectory.name
    )
