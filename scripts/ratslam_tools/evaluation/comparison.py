"""One estimate against one reference: conversion, association, projection and alignment, in this order."""

from dataclasses import dataclass, replace
from typing import Optional

import numpy as np

from ratslam_tools.errors import InputError
from ratslam_tools.trajectory import Trajectory, association, frames


@dataclass(frozen=True)
class Settings:
    """How trajectories are compared; names and meanings are those of the command lines' options."""

    align: bool = False
    correct_scale: bool = False
    n_to_align: Optional[int] = None
    t_max_diff: float = association.MAX_STAMP_DIFFERENCE_S  # [s]
    t_offset: float = 0.0  # [s]
    ref_frame: Optional[str] = None  # base | camera; None: left as it is
    est_frame: Optional[str] = None
    plane: Optional[str] = None  # xy | xz | yz

    def describe(self, poses: int) -> str:
        """The alignment in words. @param poses that are matched at most."""
        words = {
            (False, False): "not aligned",
            (True, False): "aligned (rotation, translation)",
            (False, True): "scaled about the origin",
            (True, True): "aligned (rotation, translation, scale)",
        }
        text = words[self.align, self.correct_scale]
        if self.n_to_align is not None and self.n_to_align < poses and (self.align or self.correct_scale):
            text += f" by the first {self.n_to_align} poses"
        return text


@dataclass(frozen=True)
class Comparison:
    """Matched poses of a reference and of an estimate that has been aligned with it."""

    reference: Trajectory
    estimate: Trajectory
    alignment: association.Alignment
    reference_poses: int  # in the whole reference
    convention: Optional[str]  # of the reference, as compared

    @property
    def matched(self) -> int:
        """Number of the reference's poses that were matched; one that several stretches match counts once."""
        stamps = self.reference.stamps
        return len(self.reference) if stamps is None else len(np.unique(stamps))

    @property
    def coverage(self) -> float:
        """Share of the reference's poses that were matched, in [0, 1]."""
        return self.matched / self.reference_poses


def compare(
    reference: Trajectory, estimate: Trajectory, settings: Settings, needs_body: bool, world_matters: bool = False
) -> Comparison:
    """Converts, matches, projects and aligns.

    @param needs_body whether the errors depend on the body axes (RPE, or any rotation): both must then have the same
    ones.
    @param world_matters whether the errors depend on the rotation between the two worlds (rotations of APE; not RPE,
    which compares steps).
    @throws InputError if they cannot be compared, see association.associate and frames.require_same_axis.
    """
    if settings.ref_frame is not None:
        reference = frames.convert(reference, settings.ref_frame, "base")
    if settings.est_frame is not None:
        estimate = frames.convert(estimate, settings.est_frame, "base")
    if needs_body or not settings.align:
        frames.require_same_axis(reference, estimate)
    elif settings.plane is not None:
        # An aligned error is the same in any axes; a projection needs both grounds to be the same coordinate
        # plane.
        frames.require_same_axis(reference, estimate)
    convention = "base" if settings.ref_frame is not None else frames.convention(reference)
    matched, followed = association.associate(reference, estimate, settings.t_max_diff, settings.t_offset)
    if settings.plane is not None:
        matched, followed = frames.project(matched, settings.plane), frames.project(followed, settings.plane)
    alignment = association.fit_alignment(
        matched, followed, settings.align, settings.correct_scale, settings.n_to_align, not world_matters
    )
    return Comparison(matched, alignment.apply(followed), alignment, len(reference), convention)


def on_ground(compared: Comparison, settings: Settings, positions_only: bool = True) -> Optional[Comparison]:
    """The same comparison on the reference's ground plane; None if it has none or is projected already.

    The estimate is projected after its alignment (its own world may be tilted), and then fitted again within the
    plane. A flat estimate, which the alignment tilts to fit the reference's hills, is levelled first. Without an alignment its
    own world is that of the reference, and its tilt is no artefact.
    """
    if settings.plane is not None or compared.convention is None:
        return None
    plane = frames.GROUND[compared.convention]
    reference = frames.project(compared.reference, plane)
    levelled = frames.laid_level(compared.estimate, plane) if settings.align else compared.estimate
    estimate = frames.project(levelled, plane)
    try:
        alignment = association.fit_alignment(
            reference, estimate, settings.align, settings.correct_scale, settings.n_to_align, positions_only
        )
    except InputError:  # on the plane the path is a line or a point, so that its rotation is not determined
        return None
    return replace(compared, reference=reference, estimate=alignment.apply(estimate), alignment=alignment)
