"""Definitions and invariants of the metrics, of alignment and of association."""

import numpy as np
import pytest

from ratslam_tools import evaluation
from ratslam_tools.evaluation import comparison, metrics
from ratslam_tools.trajectory import association, frames, geometry
from ratslam_tools.errors import InputError
from ratslam_tools.trajectory import Trajectory


def noisy(trajectory, seed=1, size=0.1):
    generator = np.random.default_rng(seed)
    wobble = [
        geometry.rotation_about_z(angle) for angle in generator.normal(size=len(trajectory), scale=0.02)
    ]
    return Trajectory(
        trajectory.positions + generator.normal(size=(len(trajectory), 3), scale=size),
        trajectory.rotations @ np.array(wobble),
        trajectory.stamps,
        "noisy",
    )


@pytest.mark.parametrize("angle", [0.0, 1e-9, 0.5, 2.0, np.pi - 1e-9, np.pi])
@pytest.mark.parametrize(
    "turn_about", [geometry.rotation_about_x, geometry.rotation_about_y, geometry.rotation_about_z]
)
def test_quaternions_and_angles_survive_every_angle(angle, turn_about, turn):
    rotation = (turn @ turn_about(angle) @ turn.T)[None]
    assert geometry.rotation_angles(rotation)[0] == pytest.approx(angle, abs=1e-9)
    assert np.linalg.norm(geometry.rotation_vectors(rotation)) == pytest.approx(angle, abs=1e-9)
    back = geometry.matrices_from_quaternions(geometry.quaternions_from_matrices(rotation))
    np.testing.assert_allclose(back, rotation, atol=1e-12)


def test_alignment_restores_a_known_similarity(drive, turn):
    truth = drive()
    moved = truth.transformed(turn, [5.0, -3.0, 2.0], 0.37)
    alignment = association.fit_alignment(truth, moved, align=True, correct_scale=True)
    assert alignment.scale == pytest.approx(1 / 0.37)
    np.testing.assert_allclose(alignment.rotation, turn.T, atol=1e-12)
    assert metrics.ape(truth, alignment.apply(moved), "full").max() < 1e-9


def test_alignment_never_mirrors(drive):
    truth = drive()
    mirrored = Trajectory(truth.positions * [1, -1, 1], truth.rotations, truth.stamps)
    alignment = association.fit_alignment(truth, mirrored, align=True, correct_scale=True)
    assert np.linalg.det(alignment.rotation) == pytest.approx(1.0)


def test_no_similarity_near_the_fit_is_better(drive):
    truth, estimate = drive(), noisy(drive(), size=2.0)
    best = association.fit_alignment(truth, estimate, align=True, correct_scale=True)

    def cost(rotation, translation, scale):
        return ((truth.positions - estimate.transformed(rotation, translation, scale).positions) ** 2).sum()

    least = cost(best.rotation, best.translation, best.scale)
    for small in (1e-3, -1e-3):
        assert cost(best.rotation, best.translation, best.scale + small) > least
        assert cost(best.rotation, best.translation + [small, 0, 0], best.scale) > least
        assert cost(geometry.rotation_about_z(small) @ best.rotation, best.translation, best.scale) > least


def test_n_to_align_fits_the_beginning_only(drive):
    truth = drive()
    bent = truth.transformed(np.eye(3), np.zeros(3))
    bent.positions = truth.positions + np.where(np.arange(len(truth)) < 50, 0.0, 30.0)[:, None]
    alignment = association.fit_alignment(truth, bent, True, False, n_to_align=50)
    errors = metrics.ape(truth, alignment.apply(bent))
    assert errors[:50].max() < 1e-9 and errors[50:].min() > 10


@pytest.mark.parametrize("relation", list(metrics.RELATIONS))
def test_rpe_does_not_see_the_world_frame(drive, turn, relation):
    truth, estimate = drive(), noisy(drive())
    pairs = metrics.frame_pairs(len(truth), 5, True)
    before = metrics.rpe(truth, estimate, *pairs, relation=relation)
    after = metrics.rpe(truth, estimate.transformed(turn, [9.0, 8.0, 7.0]), *pairs, relation=relation)
    np.testing.assert_allclose(after, before, atol=1e-9)


def test_equation_11_is_the_mean_over_all_steps_of_the_step_rmse(drive):
    truth, estimate = drive(12), noisy(drive(12))
    rmses = []
    for step in range(1, 12):
        squares = []
        for i in range(12 - step):
            q = np.linalg.inv(_matrix(truth, i)) @ _matrix(truth, i + step)
            p = np.linalg.inv(_matrix(estimate, i)) @ _matrix(estimate, i + step)
            squares.append(np.sum((np.linalg.inv(q) @ p)[:3, 3] ** 2))
        rmses.append(np.sqrt(np.mean(squares)))
    np.testing.assert_allclose(metrics.rmse_of_all_steps(truth, estimate), rmses, rtol=1e-12)


def _matrix(trajectory, row):
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = trajectory.rotations[row], trajectory.positions[row]
    return matrix


def test_kitti_drift_of_a_stretched_path_is_the_stretch(drive):
    truth = drive(400)
    rows = metrics.kitti_drift(truth, truth.scaled(1.05), lengths=(100, 200))
    assert [row["length_m"] for row in rows] == [100, 200]
    for row in rows:
        # The chord is shorter than the way, so the stretch shows up as less than 5 %.
        assert 1.0 < row["translation_percent"] < 5.2
        assert row["rotation_deg_per_100m"] == pytest.approx(0.0, abs=1e-5)
    with pytest.raises(InputError, match="needs more than 100 m"):
        metrics.kitti_drift(drive(50), drive(50))


def test_path_pairs_span_the_asked_length(drive):
    trajectory = drive(100)
    path = trajectory.path_length()
    starts, ends = metrics.path_pairs(trajectory, 10.0, overlapping=False)
    np.testing.assert_array_equal(starts[1:], ends[:-1])
    assert ((path[ends] - path[starts] >= 10.0) & (path[ends] - path[starts] < 10.81)).all()
    starts, ends = metrics.path_pairs(trajectory, 10.0, overlapping=True)
    assert (np.abs(path[ends] - path[starts] - 10.0) <= 1.0).all() and len(starts) > 80


@pytest.mark.parametrize(
    "delta, unit", [(0, "f"), (-1, "m"), (1.5, "f"), (float("nan"), "m"), (200, "f"), (1e6, "m")]
)
def test_steps_that_cannot_be_are_refused(drive, delta, unit):
    with pytest.raises(InputError):
        metrics.pose_pairs(drive(20), delta, unit, False)


def test_association_is_nearest_and_one_to_one():
    first = np.array([0.0, 0.1, 0.2, 0.3, 0.4])
    second = np.array([0.004, 0.006, 0.197, 0.2005, 0.391, 0.52, 0.6, 0.7])
    rows, others = association.match_stamps(first, second, 0.01)
    np.testing.assert_array_equal(rows, [0, 2, 4])
    np.testing.assert_array_equal(others, [0, 3, 4])
    others_again, rows_again = association.match_stamps(second, first, 0.01)
    np.testing.assert_array_equal(rows_again, rows)
    np.testing.assert_array_equal(others_again, others)


def test_two_seekers_of_one_stamp_do_not_both_get_it():
    rows, others = association.match_stamps(np.array([0.000, 0.006]), np.array([0.005, 1.0, 2.0]), 0.01)
    np.testing.assert_array_equal((rows, others), ([1], [0]))


def test_offset_shifts_the_estimate(drive):
    truth, late = drive(), drive()
    late.stamps = late.stamps + 0.05
    with pytest.raises(InputError, match="0 poses match"):
        association.associate(truth, late)
    matched, _ = association.associate(truth, late, offset=-0.05)
    assert len(matched) == len(truth)


def test_body_frames_are_told_apart(drive):
    base = drive()
    camera = frames.convert(base, "base", "camera")
    assert (frames.convention(base), frames.convention(camera)) == ("base", "camera")
    np.testing.assert_allclose(frames.convert(camera, "camera", "base").rotations, base.rotations, atol=1e-15)
    handheld = Trajectory(
        np.random.default_rng(0).normal(size=(50, 3)), np.repeat(np.eye(3)[None], 50, axis=0)
    )
    assert frames.convention(handheld) is None


def test_different_body_frames_are_named_not_measured(drive):
    base, camera = drive(), frames.convert(drive(), "base", "camera")
    settings = comparison.Settings(align=True)
    with pytest.raises(InputError, match="--ref_frame camera --est_frame base"):
        evaluation.evaluate_rpe(camera, [base], settings)
    with pytest.raises(InputError, match="body frames differ"):
        evaluation.evaluate_ape(camera, [base], settings, "angle_deg")
    with pytest.raises(InputError, match="body frames differ"):
        evaluation.evaluate_ape(camera, [base], comparison.Settings())
    assert evaluation.evaluate_ape(camera, [base], settings)[0].errors.max() < 1e-9
    converted = comparison.Settings(align=True, ref_frame="camera", est_frame="base")
    assert evaluation.evaluate_rpe(camera, [base], converted)[0].errors.max() < 1e-9
    # What would have been reported: an "error" of about sqrt(2) steps from a perfect estimate.
    starts, ends = metrics.frame_pairs(len(base), 1, True)
    assert metrics.rpe(camera, base, starts, ends).mean() == pytest.approx(0.8 * np.sqrt(2), rel=0.05)


@pytest.mark.parametrize("convention, plane", [("base", "xy"), ("camera", "xz")])
def test_ground_error_leaves_height_out(drive, turn, convention, plane):
    truth, flat = drive(), drive()
    flat.positions = flat.positions * [1, 1, 0]
    flat = flat.transformed(turn, [3, 2, 1])
    (result,) = evaluation.evaluate_ape(
        frames.convert(truth, "base", convention), [flat], comparison.Settings(align=True)
    )
    assert result.ground_plane == plane
    assert result.errors.max() > 0.05
    assert result.ground_errors.max() < 1e-6


def test_without_alignment_a_perfect_estimate_has_no_ground_error():
    """A flat drive in a world that is tilted."""
    angles = np.linspace(0.0, 2 * np.pi, 200, endpoint=False)
    positions = 100.0 * np.column_stack([np.cos(angles), np.sin(angles), 0.0 * angles])
    rotations = np.array([geometry.rotation_about_z(angle + np.pi / 2) for angle in angles])
    level = Trajectory(positions, rotations, np.arange(200.0))
    tilted = level.transformed(geometry.rotation_about_x(np.radians(8)), np.zeros(3))
    for scale in (False, True):
        (result,) = evaluation.evaluate_ape(tilted, [tilted], comparison.Settings(correct_scale=scale))
        assert result.ground_plane == "xy" and result.ground_errors.max() < 1e-9


def test_projection_keeps_only_turns_in_the_plane(drive):
    flat = frames.project(drive(), "xy")
    assert np.abs(flat.positions[:, 2]).max() == 0
    np.testing.assert_allclose(flat.rotations[:, 2], np.tile([0, 0, 1], (len(flat), 1)), atol=1e-12)
