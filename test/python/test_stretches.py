"""Runs whose time went back, as in a loaded map: their trajectories go on in further files, which are read as well."""

import json
import re

import numpy as np
import pytest

from run_fixtures import calls, folder, program  # noqa: F401  (fixtures)
from ratslam_tools import plotting
from ratslam_tools.cli import plot_run, report, sweep
from ratslam_tools.datasets import truth
from ratslam_tools.errors import InputError
from ratslam_tools.evaluation import error_plots
from ratslam_tools.runs import recorded_run, run_figures, run_folder, runner
from ratslam_tools.trajectory import write_tum


@pytest.fixture
def second_day(folder, drive, tmp_path):
    """The run folder of a second drive in the map of a first one, whose stamps begin at 0 as well. The second drive was
    mapped badly, with errors of metres; the truth is of the second drive.
    """
    bent = drive(120)
    bent.positions[:, 1] += 5.0 * np.sin(bent.stamps)
    write_tum(folder / "trajectory_final_2.tum", bent)
    write_tum(folder / "trajectory_online_2.tum", bent)
    write_tum(tmp_path / "truth.tum", drive(120))
    count_beginnings(folder, 0)
    return folder


def count_beginnings(folder, number):
    summary = json.loads((folder / "summary.json").read_text())
    (folder / "summary.json").write_text(json.dumps({**summary, "counts": {"new_beginnings": number}}))


def test_all_stretches_are_read(second_day):
    run = run_folder.Run(str(second_day))
    assert [len(stretch) for stretch in run.final.stretches] == [200, 120]
    assert len(run.final) == len(run.online) == 320 and run.final.name == "final"
    assert [stretch.stamps[0] for stretch in run.final.stretches] == [0.0, 0.0]
    (second_day / "trajectory_final_2.tum").write_text("0 0\n")
    with pytest.raises(InputError, match="trajectory_final_2.tum: 2 columns"):
        run_folder.Run(str(second_day))


def test_the_truth_is_compared_with_the_stretch_of_its_recording(second_day, tmp_path, capsys):
    known = str(tmp_path / "truth.tum")
    aligned = run_figures.Aligned(run_folder.Run(str(second_day)), truth.read_truth(known))
    online, final = aligned.results
    assert len(final.errors) == len(online.errors) == 120 and final.errors.mean() > 1.0
    assert len(aligned.paths["final"]) == 320
    plot_run.main([str(second_day), "--truth", known, "--save_results", str(tmp_path / "r.json")])
    told = capsys.readouterr().out
    assert "evaluated: the last stretch of 2, this run's own; the 200 poses before are drawn and not evaluated" in told
    assert json.loads((tmp_path / "r.json").read_text())["stretches"] == {"evaluated": [2], "of": 2}
    report.main([str(second_day), "--truth", known])
    assert "evaluated: the last stretch of 2" in (second_day / "report.html").read_text()


def test_no_line_joins_two_stretches(second_day):
    run = run_folder.Run(str(second_day))
    path = run.final.with_gaps(run.final.positions)
    assert len(path) == 321 and np.flatnonzero(np.isnan(path[:, 0])).tolist() == [200]


def drawn(draw, *what):
    """The lines of a drawing, by label, as arrays of points (n, 2)."""
    figure, axes = plotting.load().subplots()
    draw(axes, *what)
    lines = {line.get_label(): line.get_xydata() for line in axes.lines}
    plotting.load().close(figure)
    return lines


def gaps(line):
    return np.flatnonzero(np.isnan(line[:, 1])).tolist()


def test_no_line_of_the_match_errors_goes_back_in_time(second_day):
    path = second_day / "templates.csv"
    path.write_text(path.read_text() + "0.0,7,0.05,0\n0.1,8,0.05,0\n")
    (line,) = drawn(run_figures.draw_template_errors, run_folder.Run(str(second_day))).values()
    assert gaps(line) == [199] and len(line) == 202  # the first view has nothing to be compared with


def test_a_break_in_which_nothing_was_measured_is_no_street(folder, drive):
    """The robot slept for 8 s and woke up elsewhere."""
    summary = json.loads((folder / "summary.json").read_text())
    slept = drive().select(np.r_[0:80, 160:200])
    for name in ("online", "final"):
        write_tum(folder / f"trajectory_{name}.tum", slept)

    def gaps_with(**parameters):
        (folder / "summary.json").write_text(json.dumps({**summary, "parameters": parameters}))
        lines = drawn(run_figures.draw_map, run_figures.Aligned(run_folder.Run(str(folder))))
        return gaps(lines["online"]), gaps(lines["final"])

    assert gaps_with(odometry_gap=2.0) == ([80], [80])
    assert gaps_with(odometry_gap=9.0) == gaps_with() == ([], [])
    for name in ("online", "final"):  # of which every step is longer than odometry_gap
        write_tum(folder / f"trajectory_{name}.tum", drive().select(slice(0, 200, 30)))
    assert gaps_with(odometry_gap=2.0) == ([], [])


def test_all_stretches_of_a_looped_recording_are_compared(second_day, tmp_path):
    count_beginnings(second_day, 1)
    run = run_folder.Run(str(second_day))
    write_tum(tmp_path / "truth.tum", run_figures.of_this_run(run, run.final).stretches[0])
    final = run_figures.Aligned(run, truth.read_truth(str(tmp_path / "truth.tum"))).results[-1]
    assert len(final.errors) == 320 and final.compared.coverage == 1.0
    assert run_figures.stretch_words(run) == "evaluated: all 2 stretches of this run, whose time went back"


def test_no_line_of_the_errors_joins_two_stretches(second_day, drive, tmp_path):
    count_beginnings(second_day, 1)
    run = run_folder.Run(str(second_day))
    result = run_figures.Aligned(run, drive(200)).results[-1]
    record = result.record()
    assert (record["matched"], record["errors"], record["coverage"]) == (200, 320, 1.0)
    figure = error_plots.errors_figure(plotting.load(), [result], "", "APE [m]")
    plan, over_time = figure.axes[0], figure.axes[-1]
    for line in (plan.lines[0], over_time.lines[0]):
        assert np.flatnonzero(np.isnan(line.get_ydata())).tolist() == [200]
    coloured = plan.collections[0]
    assert len(coloured.get_segments()) == len(coloured.get_array()) == 199 + 119
    lengths = [np.linalg.norm(np.diff(segment, axis=0), axis=1).max() for segment in coloured.get_segments()]
    assert max(lengths) < 5.0
    plotting.load().close(figure)


def test_stretches_of_the_nodes_files_are_read(second_day, tmp_path):
    for number in ("", "_2"):
        (second_day / f"trajectory_final{number}.tum").rename(tmp_path / f"nodes_final{number}.tum")
    run = recorded_run.open_run(str(tmp_path / "nodes"))
    assert len(run.final.stretches) == 2
    assert re.match("evaluated: the last stretch of 2; the 200 poses", run_figures.stretch_words(run))


def test_evaluating_one_stretch_alone_tells_of_the_others(second_day, tmp_path, run):
    first, second = second_day / "trajectory_final.tum", second_day / "trajectory_final_2.tum"
    alone = run("evaluate_ape", "-as", tmp_path / "truth.tum", first)
    assert alone.returncode == 0 and f"only this stretch is evaluated; the trajectory goes on in {second}" in alone.stderr
    assert run("evaluate_ape", "-as", tmp_path / "truth.tum", first, second).stderr == ""


def test_a_sweep_of_a_drive_whose_time_goes_back_shares_no_odometry(program, folder, tmp_path):
    """odometry.csv would then hold the first stretch alone."""
    write_tum(tmp_path / "truth.tum", run_folder.Run(str(folder)).final)
    (folder / "odometry.csv").write_text("frame,stamp,linear_x,angular_z\n0,0,1,0\n")
    (folder / "odometry_2.csv").write_text("frame,stamp,linear_x,angular_z\n0,0,1,0\n")
    config = tmp_path / "c.yaml"
    config.write_text("")
    words = [str(tmp_path), "--config", str(config), "--vary", "pc_vt_inject_energy=0.1,0.2", "--out", str(tmp_path / "out")]
    sweep.main([*words, "--truth", str(tmp_path / "truth.tum"), "--ratslam_run", str(program), "--odometry", "orb"])
    assert sum("--odometry orb" in call for call in calls(program)) == 3
    assert runner.shared_odometry(str(folder), "orb") == "orb"
    (folder / "odometry_2.csv").unlink()
    assert runner.shared_odometry(str(folder), "orb") == str(folder / "odometry.csv")
