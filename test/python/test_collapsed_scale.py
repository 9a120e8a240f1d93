"""Maps whose parts are not joined: no one scale fits them to the truth, and the tools say so."""

import numpy as np
import pytest

from run_fixtures import calls, folder, program, sweep_words  # noqa: F401  (fixtures)
from ratslam_tools.cli import plot_run, report, sweep
from ratslam_tools.datasets import truth
from ratslam_tools.runs import run_figures, run_folder
from ratslam_tools.trajectory import Trajectory, association, write_tum


def torn(trajectory, distance):
    """The path with its second half far off, as a map has it that found nothing of the first half."""
    positions = trajectory.positions.copy()
    positions[len(positions) // 2 :] += [-distance, distance, 0.0]
    return Trajectory(positions, trajectory.rotations, trajectory.stamps, "torn")


@pytest.fixture
def torn_run(folder, drive):
    """The run folder with an online path that is not joined; the final one is right."""
    write_tum(folder / "trajectory_online.tum", torn(drive(), 2000.0))
    return folder


@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e3])
def test_a_scale_has_collapsed_whatever_the_units_of_the_map(drive, unit):
    whole, apart = drive().scaled(unit), torn(drive(), 2000.0).scaled(unit)
    assert not association.fit_alignment(drive(), whole, True, True).collapsed
    assert association.fit_alignment(drive(), apart, True, True).collapsed
    assert not association.fit_alignment(drive(), apart, True, False).collapsed


def test_a_poor_map_is_no_collapsed_one(drive):
    bent = drive()
    bent.positions[:, 1] += 0.3 * np.ptp(bent.positions, axis=0).max() * np.sin(bent.stamps)
    assert not association.fit_alignment(drive(), bent, True, True).collapsed


def test_what_is_not_joined_is_drawn_without_scale_and_told(torn_run, tmp_path, capsys):
    known = str(tmp_path / "truth.tum")
    aligned = run_figures.Aligned(run_folder.Run(str(torn_run)), truth.read_truth(known))
    online, final = aligned.results
    assert online.compared.alignment.scale == 1.0 and final.compared.alignment.scale == pytest.approx(1.0)
    assert np.ptp(aligned.paths["online"], axis=0).max() > 1000.0 and online.errors.mean() > 500.0
    plot_run.main([str(torn_run), "--truth", known])
    told = [line for line in capsys.readouterr().out.splitlines() if line.startswith("note: ")]
    assert len(told) == 1 and "no scale fits online" in told[0] and "not joined" in told[0]
    report.main([str(torn_run), "--truth", known])
    assert "no scale fits online" in (torn_run / "report.html").read_text()


def test_a_sweep_remarks_on_what_no_scale_fits(torn_run, program, tmp_path, capsys):
    sweep.main(sweep_words(program, tmp_path, "pc_vt_inject_energy=0.2,0.2001"))
    assert "2 of 2 runs: no scale fits online to the truth; its errors are without scale" in capsys.readouterr().err
    assert len(calls(program)) == 2


@pytest.mark.parametrize("tool", ["evaluate_ape", "evaluate_rpe", "evaluate_kitti"])
def test_evaluations_warn_and_print_what_was_asked_for(torn_run, tmp_path, run, tool):
    words = (tmp_path / "truth.tum", torn_run / "trajectory_online.tum")
    warned, silent = run(tool, "-as", *words), run(tool, "-a", *words)
    assert warned.returncode == silent.returncode == 0 and silent.stderr == ""
    assert warned.stderr.startswith("note: no scale fits trajectory_online.tum") and warned.stderr.count("\n") == 1
    assert "trajectory_online.tum" in warned.stdout
