"""The evaluation command lines: inputs of every form, outputs, and bad input."""

import json

import numpy as np
import pytest

from ratslam_tools.datasets.truth import read_truth
from ratslam_tools.trajectory import frames
from ratslam_tools.trajectory import Trajectory, read_trajectory, write_kitti, write_tum


@pytest.fixture
def files(drive, tmp_path, turn):
    """truth.tum and est.tum (moved, scaled, with 10 cm of noise), and the truth as KITTI poses with times."""
    truth = drive()
    noise = np.random.default_rng(3).normal(size=truth.positions.shape, scale=0.1)
    estimate = Trajectory(truth.positions + noise, truth.rotations, truth.stamps).transformed(
        turn, [1, 2, 3], 2.0
    )
    write_tum(tmp_path / "truth.tum", truth)
    write_tum(tmp_path / "est.tum", estimate)
    write_kitti(tmp_path / "poses.txt", frames.convert(truth, "base", "camera"))
    np.savetxt(tmp_path / "times.txt", truth.stamps, fmt="%e")
    return tmp_path


def test_table_json_and_figures(files, run):
    result = run(
        "evaluate_ape",
        "-as",
        files / "truth.tum",
        files / "est.tum",
        files / "truth.tum",
        "--save_results",
        files / "a.json",
        "--save_plot",
        files / "a.png",
    )
    assert result.returncode == 0, result.stderr
    assert "100.0 %" in result.stdout and "ground (xy)" in result.stdout
    record = json.loads((files / "a.json").read_text())
    noisy, perfect = record["results"]
    assert noisy["alignment"]["scale"] == pytest.approx(0.5, rel=0.01)
    assert noisy["stats"]["rmse"] == pytest.approx(0.1 * np.sqrt(3), rel=0.1)
    assert perfect["stats"]["max"] < 1e-6
    assert noisy["ground"]["stats"]["rmse"] == pytest.approx(0.1 * np.sqrt(2), rel=0.1)
    assert (files / "a.png").read_bytes()[:4] == b"\x89PNG"
    assert (
        run(
            "evaluate_rpe", "-as", files / "truth.tum", files / "est.tum", "--save_plot", files / "r.pdf"
        ).returncode
        == 0
    )
    assert (files / "r.pdf").read_bytes()[:4] == b"%PDF"


def test_a_few_poses_far_off_do_not_take_the_scale_from_all_others():
    """An odometry that has just started is off by metres for a moment."""
    import types

    from ratslam_tools.evaluation import error_plots

    usual = np.linspace(0.0, 0.1, 600)
    spiked = usual.copy()
    spiked[:3] = 2.2
    results = [types.SimpleNamespace(errors=errors) for errors in (spiked, usual)]
    assert 0.1 < error_plots.top_of_scale(results) < 0.15
    assert error_plots.top_of_scale(results[1:]) == usual.max()
    grows = [types.SimpleNamespace(errors=np.linspace(0.0, 50.0, 600))]
    assert error_plots.top_of_scale(grows) == 50.0
    standing = [types.SimpleNamespace(errors=np.array([0.0] * 99 + [1.0]))]
    assert error_plots.top_of_scale(standing) == 1.0


def test_coverage_tells_half_a_trajectory(files, run, drive):
    write_tum(files / "half.tum", drive().select(slice(0, 100)))
    run("evaluate_ape", files / "truth.tum", files / "half.tum", "--save_results", files / "h.json")
    assert json.loads((files / "h.json").read_text())["results"][0]["coverage"] == 0.5


def test_kitti_truth_with_times(files, run):
    result = run(
        "evaluate_rpe",
        "-as",
        files / "poses.txt",
        files / "est.tum",
        "--times",
        files / "times.txt",
        "--ref_frame",
        "camera",
        "--est_frame",
        "base",
    )
    assert result.returncode == 0, result.stderr
    assert "REF from camera" in result.stdout


def test_kitti_pair_by_index(files, run):
    result = run("evaluate_kitti", files / "poses.txt", files / "poses.txt")
    assert result.returncode == 0, result.stderr
    assert "average" in result.stdout


def test_all_deltas_prints_equation_11(files, run):
    result = run("evaluate_rpe", "-as", files / "truth.tum", files / "est.tum", "--all_deltas")
    assert "equation (11)" in result.stdout


def bad(files, change):
    """A copy of est.tum whose lines went through `change`."""
    lines = (files / "est.tum").read_text().splitlines()
    (files / "bad.tum").write_text("\n".join(change(lines)) + "\n")
    return files / "bad.tum"


@pytest.mark.parametrize(
    "change, words",
    [
        (lambda lines: lines[:2], "2 poses match"),
        (lambda lines: [], "holds no poses"),
        (lambda lines: [*lines[:6], lines[6].replace(lines[6].split()[1], "nan"), *lines[7:]], ":7: a NaN or infinite value"),
        (lambda lines: [lines[5]] + lines, "goes back"),
        (lambda lines: [lines[0]] + lines, "repeats"),
        (lambda lines: [line + " 1" for line in lines], "9 columns"),
        (lambda lines: lines[:9] + [lines[9] + " 1"], "where the lines before have 8"),
        (lambda lines: [line.split()[0] + " 1 2 3 0 0 0 1" for line in lines], "one point"),
        (lambda lines: [" ".join(line.split()[:4]) + " 0 0 0 0" for line in lines], "length zero"),
        (lambda lines: lines[:3] + ["a b c d e f g h"], "not a number"),
    ],
)
def test_degenerate_input_gets_one_line_and_no_figure(files, fails, change, words):
    for tool in ("evaluate_ape", "evaluate_rpe"):
        message = fails(
            tool,
            "-as",
            files / "truth.tum",
            bad(files, change),
            "--save_plot",
            files / "no.png",
            "--save_results",
            files / "no.json",
        )
        assert words in message
        assert not (files / "no.png").exists() and not (files / "no.json").exists()


def test_other_bad_input(files, fails):
    assert "no such file" in fails("evaluate_ape", files / "absent", files / "est.tum").lower()
    assert "--times" in fails("evaluate_ape", "-a", files / "poses.txt", files / "est.tum")
    lines = (files / "poses.txt").read_text().splitlines()
    (files / "short.txt").write_text("\n".join(lines[:50]) + "\n")
    assert "equally long" in fails("evaluate_ape", "-a", files / "poses.txt", files / "short.txt")
    (files / "scaled.txt").write_text("\n".join("2 " + line.partition(" ")[2] for line in lines) + "\n")
    assert "no rotation matrix" in fails("evaluate_ape", files / "poses.txt", files / "scaled.txt")
    assert "--n_to_align" in fails(
        "evaluate_ape", "-a", "--n_to_align", 2, files / "truth.tum", files / "est.tum"
    )
    assert "add -a" in fails("evaluate_ape", "--n_to_align", 9, files / "truth.tum", files / "est.tum")
    assert "--topic" in fails("trajectory_convert", files / "drive.bag", files / "out.tum")
    assert "--delta" in fails("evaluate_rpe", "-d", 0, files / "truth.tum", files / "est.tum")
    assert "body frames differ" in fails(
        "evaluate_rpe", "-as", files / "poses.txt", files / "est.tum", "--times", files / "times.txt"
    )


def test_a_repeated_stamp_in_the_truth_matters_only_where_it_is_matched(files, run, fails):
    lines = (files / "truth.tum").read_text().splitlines()
    (files / "twice.tum").write_text("\n".join(lines[:100] + [lines[99]] + lines[100:]) + "\n")
    assert "ambiguous" in fails("evaluate_ape", "-as", files / "twice.tum", files / "est.tum")
    part = bad(files, lambda rows: rows[:50])
    assert run("evaluate_ape", "-as", files / "twice.tum", part).returncode == 0


def test_a_repeated_stamp_in_a_bags_truth_is_judged_like_one_in_a_file(files, run, fails):
    rosbag = pytest.importorskip("rosbag")
    from geometry_msgs.msg import PoseStamped
    from rospy import Time

    def message(line):
        pose, numbers = PoseStamped(), [float(word) for word in line.split()]
        pose.header.stamp = Time.from_sec(numbers[0] + 1.0)
        pose.pose.position.x, pose.pose.position.y, pose.pose.position.z = numbers[1:4]
        pose.pose.orientation.w = 1.0
        return pose

    truth, whole = ((files / name).read_text().splitlines() for name in ("truth.tum", "est.tum"))
    path = str(files / "drive.bag")
    shift = [f"{float(line.split()[0]) + 1.0:.9f} {line.split(maxsplit=1)[1]}" for line in whole[:50]]
    (files / "part.tum").write_text("\n".join(shift) + "\n")
    with rosbag.Bag(path, "w") as bag:
        for topic, lines in (("/ground_truth", truth[:100] + truth[99:]), ("/whole", whole), ("/part", whole[:50])):
            for number, line in enumerate(lines):
                bag.write(topic, message(line), Time(1 + number))
    assert "ambiguous" in fails("evaluate_ape", "-as", "/ground_truth", "/whole", "--bag", path)
    assert run("evaluate_ape", "-as", "/ground_truth", "/part", "--bag", path).returncode == 0
    assert "repeats" in fails("evaluate_ape", "-as", "/whole", "/ground_truth", "--bag", path)
    assert len(read_truth(path)) == len(truth) + 1
    assert "50/201" in run("evaluate_ape", "-as", path, files / "part.tum").stdout  # as plot_run takes it
    assert f"give --bag {path} REF_TOPIC EST_TOPIC" in fails("evaluate_rpe", "-as", files / "truth.tum", path)


def test_round_trips(files, run, drive):
    truth = drive()
    for words in (
        ("--to", "kitti", "--save_times", files / "t.txt", "--from_frame", "base", "--to_frame", "camera"),
    ):
        assert run("trajectory_convert", files / "truth.tum", files / "k.txt", *words).returncode == 0
    result = run(
        "trajectory_convert",
        files / "k.txt",
        files / "back.tum",
        "--times",
        files / "t.txt",
        "--from_frame",
        "camera",
        "--to_frame",
        "base",
    )
    assert result.returncode == 0, result.stderr
    back = read_trajectory(str(files / "back.tum"))
    np.testing.assert_allclose(back.positions, truth.positions, atol=1e-6)
    np.testing.assert_allclose(back.rotations, truth.rotations, atol=1e-7)
    np.testing.assert_allclose(back.stamps, truth.stamps, atol=1e-9)


def test_a_title_tells_by_how_many_poses_was_aligned(files, run):
    for tool in ("evaluate_ape", "evaluate_rpe", "evaluate_kitti"):
        told = {n: run(tool, "-a", files / "truth.tum", files / "est.tum", "--n_to_align", n).stdout for n in ("50", "100000")}
        assert "aligned (rotation, translation) by the first 50 poses" in told["50"]
        assert "aligned (rotation, translation)" in told["100000"] and "by the first" not in told["100000"]


def test_large_coordinates_keep_their_millimetres(tmp_path, drive):
    """As those of UTM. Small numbers have nine digits."""
    grid = drive(2).transformed(np.eye(3), [412345.678, 5412345.678, 0.123456789123])
    grid.positions[1] = [99999.123456, -0.5, 0.0]
    write_tum(tmp_path / "utm.tum", grid)
    rows = [line.split()[1:4] for line in (tmp_path / "utm.tum").read_text().splitlines()]
    assert rows == [["412345.678", "5412345.678", "0.123456789"], ["99999.1235", "-0.5", "0"]]
    write_kitti(tmp_path / "utm.kitti", grid)
    assert (tmp_path / "utm.kitti").read_text().split()[7] == "5412345.678"


def test_conversion_needs_stamps_for_tum(files, fails):
    assert "--times" in fails("trajectory_convert", files / "poses.txt", files / "no.tum")
    assert not (files / "no.tum").exists()


@pytest.mark.parametrize(
    "tool",
    [
        "evaluate_ape",
        "evaluate_rpe",
        "evaluate_kitti",
        "plot_run",
        "plot_scale",
        "report",
        "sweep",
        "reproduce_paper",
        "kitti_to_bag",
        "recorder_to_bag",
        "trajectory_convert",
        "ini_to_yaml",
        "donkey_to_kitti",
    ],
)
def test_help_has_examples(run, tool):
    result = run(tool, "--help")
    assert result.returncode == 0 and "examples:" in result.stdout


@pytest.mark.parametrize(
    "words, complaint",
    [
        (("evaluate_ape", "-a", "truth.tum", "est.tum", "--times", "times.txt"), "--times: times.txt has no effect"),
        (("evaluate_rpe", "truth.tum", "est.tum", "--format", "tum", "--times", "x"), "--times: x has no effect"),
        (("evaluate_kitti", "--bag", "x.bag", "/a", "/b", "--times", "times.txt"), "--times: times.txt has no effect"),
        (("evaluate_ape", "--bag", "x.bag", "/a", "/b", "--format", "tum"), "--format: tum has no effect"),
        (("evaluate_kitti", "truth.tum", "short.tum"), "KITTI's drift needs more than 100 m"),
        (("evaluate_ape", "poses.txt", "poses.txt", "--t_offset", "1"), "--t_offset: 1 has no effect"),
        (("evaluate_rpe", "poses.txt", "poses.txt", "--t_max_diff", "0.5"), "--t_max_diff: 0.5 has no effect"),
        (("trajectory_convert", "truth.tum", "out.txt", "--to", "kitti", "--save_times", "out.txt"), "out.txt is written as well"),
        (("evaluate_ape", "-a", "truth.tum", "est.tum", "--save_results", "a.png", "--save_plot", "a.png"), "a.png is written as well"),
        (("trajectory_convert", "truth.tum", "out.txt", "--times", "times.txt"), "--times: times.txt has no effect"),
        (("trajectory_convert", "truth.tum", "out.txt", "--max_accuracy", "5"), "--max_accuracy: 5 has no effect"),
        (("trajectory_convert", "x.bag", "out.txt", "--topic", "/a", "--from", "kitti"), "--from: kitti has no effect"),
        (("trajectory_convert", "poses.txt", "out.txt", "--to", "kitti", "--save_times", "a.txt"), "--save_times: poses.txt has no"),
    ],
)
def test_options_without_effect_are_refused(files, fails, monkeypatch, words, complaint):
    monkeypatch.chdir(files)
    (files / "short.tum").write_text("".join((files / "truth.tum").read_text().splitlines(True)[:20]))
    assert complaint in fails(*words)
    assert not (files / "out.txt").exists() and not (files / "a.png").exists()


def test_times_of_more_poses_than_there_are_are_told(files, run):
    with open(files / "times.txt", "a", encoding="utf-8") as file:
        file.write("1000\n")
    done = run("evaluate_ape", "-a", files / "poses.txt", files / "est.tum", "--times", files / "times.txt")
    assert done.returncode == 0 and "times.txt: 201 times for the 200 poses of" in done.stderr, done.stderr
