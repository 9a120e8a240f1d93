"""Run folders: reading, pictures, report, sweep and the paper's figures, with a stand-in for ratslam_run."""

import csv
import json
import os
import re
import signal
import stat
import subprocess
import sys
import time

import numpy as np
import pytest

from conftest import SCRIPTS
from ratslam_tools.cli import benchmark, plot_run, plot_scale, report, reproduce_paper, sweep
from ratslam_tools.datasets import truth
from ratslam_tools.runs import activity_figure, grid, recorded_run, run_figures, run_folder, runner
from ratslam_tools.trajectory import frames
from ratslam_tools.errors import InputError
from ratslam_tools.trajectory import Trajectory, write_kitti, write_tum

FAKE = """#!{python}
import os, shutil, sys, time
words = sys.argv[1:]
out = words[words.index("--out") + 1]
values = dict(word.split("=") for before, word in zip(words, words[1:]) if before == "--set")
with open({log!r}, "a") as log:
    log.write(" ".join(words) + "\\n")
if values.get("fail") == "1":
    sys.exit("fail: 1 is not allowed: 0")
time.sleep(float(values.get("sleep", 0)))
for name in os.listdir({run!r}):
    shutil.copy(os.path.join({run!r}, name), out)
bend = abs(float(values.get("pc_vt_inject_energy", 0.2)) - 0.2)
path = os.path.join(out, "trajectory_final.tum")
lines = [line.split() for line in open(path)]
with open(path, "w") as file:
    for line in lines:
        line[2] = str(float(line[2]) + bend * float(line[0]) ** 2)
        file.write(" ".join(line) + "\\n")
"""


@pytest.fixture
def folder(tmp_path, drive):
    """A run folder whose final trajectory is the truth, moved, and whose online one has drifted; and the
    truth.
    """
    path = tmp_path / "run"
    path.mkdir()
    known = drive()
    write_tum(tmp_path / "truth.tum", known)
    write_tum(path / "trajectory_final.tum", known.transformed(np.eye(3), [10.0, 0.0, 0.0]))
    drift = np.outer(known.stamps, [0.0, 0.3, 0.0])
    write_tum(
        path / "trajectory_online.tum", Trajectory(known.positions + drift, known.rotations, known.stamps)
    )
    with open(path / "map.yaml", "w", encoding="utf-8") as file:
        file.write("format: ratslam_experience_map 1\nexperiences:\n")
        for i, position in enumerate(known.positions):
            file.write(
                f"- {{id: {i}, x: {position[0] + 10:.9f}, y: {position[1]:.9f}, z: 0.0, yaw: 0.5, log_scale: 0.0}}\n"
            )
        file.write("links:\n")
        for i in range(len(known) - 1):
            file.write(_link(i, i, i + 1, "false"))
        file.write(_link(999, 150, 3, "true"))
    with open(path / "templates.csv", "w", encoding="utf-8") as file:
        file.write("stamp,template_id,error,relative_rad\n")
        file.writelines(f"{0.1 * i},{i if i < 150 else i - 150},{0.05 if i else -1},0\n" for i in range(200))
    with open(path / "actions.csv", "w", encoding="utf-8") as file:
        file.write("stamp,action,src_id,dest_id,x,y,th\n")
        file.writelines(
            f"{0.1 * i},{1 if i < 150 else 2},{i},{i if i < 150 else i - 150},5,6,7\n" for i in range(200)
        )
    with open(path / "pose_cells.csv", "w", encoding="utf-8") as file:
        file.write("stamp,layer,row,column,activity\n5.0,35,29,4,0.75\n5.0,0,29,4,0.25\n10.0,7,6,5,1\n")
    summary = {
        "version": "0.1.0",
        "parameters": {"pc_dim_xy": 30, "pc_dim_th": 36, "topic_root": "<kitti> & co"},
        "timing": {"local_view": {"mean_ms": 1.25}, "pose_cells": 2.5},
    }
    (path / "summary.json").write_text(json.dumps(summary))
    return path


def _link(number, start, end, recall):
    return (
        f"- {{id: {number}, from: {start}, to: {end}, distance: 0.8, heading_rad: 0.0, "
        f"facing_rad: 0.0, rise: 0.0, duration_s: 0.1, recall: {recall}}}\n"
    )


@pytest.fixture
def program(tmp_path, folder):
    """A stand-in for ratslam_run that copies the run folder and bends its final trajectory; and its log of
    calls.
    """
    path = tmp_path / "fake_run"
    path.write_text(FAKE.format(python=sys.executable, log=str(tmp_path / "calls"), run=str(folder)))
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return path


def calls(program):
    log = program.parent / "calls"
    return log.read_text().splitlines() if log.exists() else []


def test_map_is_read_whole(folder):
    found = run_folder.read_map(str(folder / "map.yaml"))
    assert len(found.nodes["id"]) == 200 and len(found.ends) == 200
    np.testing.assert_array_equal(found.loop_ends, [[150, 3]])
    assert found.nodes["x"][1] == pytest.approx(10.8, abs=0.05) and found.links["duration_s"][0] == 0.1


@pytest.mark.parametrize(
    "find, put, words",
    [
        ("to: 3,", "to: 777,", "experience 777, which is not there"),
        ("z: 0.0", "z: nan", "NaN"),
        ("x: 10.8", "x: far", "could not"),
        ("- {id: 1,", "- {id: 0,", "twice"),
        ("yaw: 0.5", "jaw: 0.5", "has no yaw"),
        ("experiences:\n", "", "outside"),
    ],
)
def test_broken_maps_are_named(folder, find, put, words):
    text = (folder / "map.yaml").read_text()
    assert find in text
    (folder / "map.yaml").write_text(text.replace(find, put))
    with pytest.raises(InputError, match=words):
        run_folder.read_map(str(folder / "map.yaml"))


def test_picture_is_aligned_to_the_truth(folder, tmp_path):
    aligned = run_figures.map_picture(
        str(folder), str(tmp_path / "map.png"), truth.read_truth(str(tmp_path / "truth.tum"))
    )
    online, final = aligned.results
    assert final.errors.max() < 1e-5 and online.errors.mean() > 0.1
    np.testing.assert_allclose(aligned.paths["final"], aligned.truth.positions, atol=1e-4)
    np.testing.assert_allclose(aligned.nodes[:, :2], aligned.truth.positions[:, :2], atol=0.2)
    assert (tmp_path / "map.png").read_bytes()[:4] == b"\x89PNG"


def test_activity_is_read_and_laid_out_as_the_live_picture(folder):
    moments = activity_figure.activities(run_folder.Run(str(folder)))
    assert [stamp for stamp, _ in moments] == [5.0, 10.0]
    first = moments[0][1]
    assert first.shape == (36, 30, 30) and first[35, 29, 4] == 0.75 and first.sum() == 1.0
    picture = activity_figure.mosaic(first)
    assert picture[38 + 29, 4] == 1.0, "y over x: all of it at column 4, row 29"
    assert picture[38 + 29, 32 + 35] == 1.0 and picture[38 + 29, 32] == pytest.approx(np.sqrt(1 / 3))
    assert picture[35, 4] == 1.0 and np.isnan(picture[0, 40]), "heading over x; the corner stays empty"
    with open(folder / "pose_cells.csv", "a", encoding="utf-8") as file:
        file.write("11.0,36,0,0,1\n")
    with pytest.raises(InputError, match="outside the network of 30x30x36"):
        activity_figure.activities(run_folder.Run(str(folder)))


def test_plot_run_without_truth_and_with_half_the_files(folder, capsys):
    for name in ("summary.json", "actions.csv", "map.yaml", "trajectory_online.tum"):
        (folder / name).unlink()
    plot_run.main([str(folder)])
    assert (folder / "run.png").stat().st_size > 10000 and "APE" not in capsys.readouterr().out


def test_plot_run_draws_the_timing_alone_and_says_where_there_is_none(folder, tmp_path):
    path = tmp_path / "timing.png"
    plot_run.main([str(folder), "--timing_only", "--out", str(path)])
    assert path.read_bytes()[:4] == b"\x89PNG"
    (folder / "summary.json").unlink()
    with pytest.raises(InputError, match="has no timing"):
        plot_run.main([str(folder), "--timing_only"])


def test_local_scale_is_the_ratio_of_lengths_along_the_way():
    way = np.linspace(0.0, 200.0, 401)
    true = np.column_stack([way, 0 * way, 0 * way])
    stretched = true.copy()
    stretched[way > 100.0, 0] = 100.0 + 1.5 * (way[way > 100.0] - 100.0)
    middles, ratio = plot_scale.local_scale(true, stretched, window=20.0)
    np.testing.assert_allclose(ratio[middles < 90.0], 1.0)
    np.testing.assert_allclose(ratio[middles > 110.0], 1.5)
    with pytest.raises(InputError, match="60 m are needed"):
        plot_scale.local_scale(true[:100], stretched[:100])


def test_plot_scale_draws_two_runs_over_the_truth(folder, tmp_path, capsys):
    (folder / "trajectory_odometry.tum").write_bytes((folder / "trajectory_online.tum").read_bytes())
    picture = tmp_path / "scale.png"
    known = str(tmp_path / "truth.tum")
    plot_scale.main([str(folder), str(folder), "--truth", known, "--out", str(picture)])
    assert picture.read_bytes()[:4] == b"\x89PNG"
    assert "map with scale" in capsys.readouterr().out


def test_folders_that_are_no_run(tmp_path):
    with pytest.raises(InputError, match="no trajectory_final.tum"):
        plot_run.main([str(tmp_path)])
    with pytest.raises(InputError, match="no such folder"):
        plot_run.main([str(tmp_path / "absent")])


def test_report_holds_everything_and_fetches_nothing(folder, tmp_path):
    report.main([str(folder), "--truth", str(tmp_path / "truth.tum")])
    text = (folder / "report.html").read_text()
    assert text.count("data:image/png;base64,") == 8
    assert not re.search(r"(src|href)=\"(?!data:)", text) and "@import" not in text and "url(" not in text
    assert "&lt;kitti&gt; &amp; co" in text and "<kitti>" not in text
    assert "pc_dim_xy" in text and "100.0 %" in text and "@media print" in text


@pytest.mark.parametrize("layout", ["beside", "benchmark"])
def test_truth_finds_its_times(tmp_path, drive, layout):
    known = drive()
    poses = tmp_path / ("poses.txt" if layout == "beside" else "poses/04.txt")
    times = tmp_path / ("times.txt" if layout == "beside" else "sequences/04/times.txt")
    for path in (poses, times):
        path.parent.mkdir(parents=True, exist_ok=True)
    write_kitti(poses, frames.convert(known, "base", "camera"))
    np.savetxt(times, known.stamps)
    found = truth.read_truth(str(poses))
    np.testing.assert_allclose(found.positions, known.positions, atol=1e-6)
    times.unlink()
    with pytest.raises(InputError, match="give --times"):
        truth.read_truth(str(poses))


@pytest.mark.parametrize(
    "text, values",
    [
        ("k=0.05:0.2:0.05", ["0.05", "0.1", "0.15", "0.2"]),
        ("k=1:1:3", ["1"]),
        ("k=a,b", ["a", "b"]),
        ("k=0:1:0.3", None),
    ],
)
def test_ranges(text, values):
    found = grid.parse_vary(text)[1]
    assert found == (values or ["0", "0.3", "0.6", "0.9"])


@pytest.mark.parametrize(
    "text",
    [
        "k",
        "=1",
        "k=",
        "k=1,,2",
        "k=1,1",
        "k=1:2",
        "k=2:1:0.1",
        "k=1:2:0",
        "k=1:2:-1",
        "k=0:1:x",
        "k=0:1:1e-9",
        "k=0:inf:1",
    ],
)
def test_ranges_that_are_none(text):
    with pytest.raises(InputError, match="--vary"):
        grid.parse_vary(text)


def sweep_words(program, tmp_path, *vary):
    words = [
        "input",
        "--config",
        "c.yaml",
        "--truth",
        str(tmp_path / "truth.tum"),
        "--out",
        str(tmp_path / "out"),
        "--ratslam_run",
        str(program),
        "--jobs",
        "2",
    ]
    return words + [word for text in vary for word in ("--vary", text)]


def test_sweep_finds_the_optimum_and_does_not_repeat_itself(program, tmp_path, capsys):
    words = sweep_words(program, tmp_path, "pc_vt_inject_energy=0.1:0.3:0.1", "other=1,2")
    sweep.main(words)
    assert len(calls(program)) == 6
    assert all("--config c.yaml" in call and "--set other=" in call for call in calls(program))
    assert "pc_vt_inject_energy=0.2" in capsys.readouterr().out
    with open(tmp_path / "out" / "sweep.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 6 and {row["ape.final.coverage"] for row in rows} == {"1.0"}
    assert min(rows, key=lambda row: float(row["ape.final.mean"]))["pc_vt_inject_energy"] == "0.2"
    assert {row["counts.recalls"] for row in rows} == {"1.0"}
    for key in ("pc_vt_inject_energy", "other"):
        assert (tmp_path / "out" / f"ape_over_{key}.png").exists()
    sweep.main(words[:-1] + ["other=1,2,3"])
    assert len(calls(program)) == 9


@pytest.mark.parametrize("key, runs_from_images", [("pc_vt_inject_energy", 1), ("camera_height", 2)])
def test_sweep_computes_orb_odometry_once_where_nothing_varied_can_change_it(
    program, tmp_path, key, runs_from_images
):
    sweep.main(sweep_words(program, tmp_path, f"{key}=0.1,0.2") + ["--odometry", "orb"])
    assert sum("--odometry orb" in call for call in calls(program)) == runs_from_images
    from_file = f"--odometry {tmp_path / 'out' / 'odometry' / 'odometry.csv'}"
    assert sum(from_file in call for call in calls(program)) == (2 if runs_from_images == 1 else 0)


def test_among_equals_none_is_the_best(program, tmp_path, capsys):
    sweep.main(sweep_words(program, tmp_path, "other=1,2"))
    assert "all have the same ape.final.mean" in capsys.readouterr().out
    sweep.main(sweep_words(program, tmp_path, "pc_vt_inject_energy=0.1:0.2:0.1", "other=1,2"))
    told = capsys.readouterr().out
    assert "2 share the best ape.final.mean" in told and "other=1" in told and "other=2" in told


def test_any_figure_may_be_the_goal_and_needs_no_truth(program, tmp_path, capsys):
    words = sweep_words(program, tmp_path, "other=1,2")
    at = words.index("--truth")
    del words[at : at + 2]
    with pytest.raises(InputError, match="ape.final.mean needs --truth"):
        sweep.main(words)
    sweep.main(words + ["--goal", "counts.recalls", "--largest"])
    assert "same counts.recalls, 1" in capsys.readouterr().out
    assert (tmp_path / "out" / "counts.recalls_over_other.png").exists()
    with pytest.raises(InputError, match="no run has counts.birds; there are .*counts.recalls"):
        sweep.main(words + ["--goal", "counts.birds"])


def test_shards_put_together_are_the_whole_sweep(program, tmp_path, capsys):
    vary = ("pc_vt_inject_energy=0.1:0.3:0.1", "other=1,2")
    whole = sweep_words(program, tmp_path, *vary)
    sweep.main(whole)
    expected = (tmp_path / "out" / "sweep.csv").read_text()
    told = capsys.readouterr().out
    parts = []
    for number in (1, 2, 3, 4):
        part = str(tmp_path / f"part{number}")
        parts.append(part)
        words = [part if word == str(tmp_path / "out") else word for word in whole]
        sweep.main(words + ["--shard", f"{number}/4"])
        assert not os.path.exists(os.path.join(part, "sweep.csv"))
    assert len(calls(program)) == 12
    capsys.readouterr()
    merged = [str(tmp_path / "merged") if word == str(tmp_path / "out") else word for word in whole]
    sweep.main(merged + ["--merge", *parts])
    assert len(calls(program)) == 12
    assert (tmp_path / "merged" / "sweep.csv").read_text() == expected
    assert capsys.readouterr().out.splitlines()[0] == told.splitlines()[0]
    with pytest.raises(InputError, match="2 of 6 runs failed.*no shard has left it"):
        sweep.main(merged + ["--merge", *parts[:1], *parts[2:]])
    for bad in ("0/4", "5/4", "1", "a/b"):
        with pytest.raises(InputError, match="K/N"):
            sweep.main(whole + ["--shard", bad])


def test_sweep_goes_on_after_failures_and_says_so(program, tmp_path):
    with pytest.raises(InputError, match="1 of 2 runs failed.*fail: 1 is not allowed: 0"):
        sweep.main(sweep_words(program, tmp_path, "fail=0,1"))
    assert len((tmp_path / "out" / "sweep.csv").read_text().splitlines()) == 2
    with pytest.raises(InputError, match="all 1 runs failed"):
        sweep.main(sweep_words(program, tmp_path, "fail=1"))


def test_interrupted_sweep_keeps_what_is_done_and_only_that(program, tmp_path):
    words = sweep_words(program, tmp_path, "sleep=0,0.01,60,61")
    process = subprocess.Popen(
        [sys.executable, os.path.join(SCRIPTS, "sweep"), *words], stderr=subprocess.PIPE
    )
    runs = tmp_path / "out" / "runs"
    deadline = time.monotonic() + 60
    while len(calls(program)) < 4 or not (runs / "sleep=0.01" / "result.json").exists():
        assert time.monotonic() < deadline and process.poll() is None
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    _, messages = process.communicate(timeout=30)
    assert process.returncode == 130 and b"Traceback" not in messages
    assert sorted(path.parent.name for path in runs.glob("*/result.json")) == ["sleep=0", "sleep=0.01"]


def test_runner_is_looked_for_and_its_absence_explained(tmp_path, monkeypatch, program):
    monkeypatch.setenv("PATH", str(tmp_path))
    program.rename(tmp_path / "ratslam_run")
    assert runner.find() == str(tmp_path / "ratslam_run")
    with pytest.raises(InputError, match="not an executable file"):
        runner.find(str(tmp_path / "truth.tum"))


def test_paper_table_and_figures(program, tmp_path, drive, capsys):
    sequence = tmp_path / "kitti" / "sequences" / "00"
    sequence.mkdir(parents=True)
    (tmp_path / "kitti" / "poses").mkdir()
    write_kitti(tmp_path / "kitti" / "poses" / "00.txt", frames.convert(drive(), "base", "camera"))
    np.savetxt(sequence / "times.txt", drive().stamps)
    for name in ("kitti.yaml", "kitti_orb.yaml"):
        (tmp_path / name).write_text("")
    words = [
        str(tmp_path / "kitti"),
        "--sequences",
        "00",
        "--out",
        str(tmp_path / "paper"),
        "--ratslam_run",
        str(program),
        "--config_dir",
        str(tmp_path),
        "--inject_energy",
        "0.1,0.2",
        "--cell_size",
        "1,2",
    ]
    reproduce_paper.main(words)
    table = capsys.readouterr().out
    assert "42.17" in table and "39.81" in table and "coverage" in table
    for name in ("table.txt", "fig5_00.png", "fig6_00_orb.png", "fig7_00_orb.png"):
        assert (tmp_path / "paper" / name).exists()
    assert sum("--odometry orb" in call for call in calls(program)) == 1
    shared = os.path.join("00", "orb", "odometry.csv")
    assert sum(f"{shared} " in call for call in calls(program)) == 4, "the odometry is computed once"
    assert sum("--odometry profile" in call for call in calls(program)) == 1
    reproduce_paper.main(words)
    assert len(calls(program)) == 6
    with pytest.raises(InputError, match="--sequences: 09"):
        reproduce_paper.main([words[0], "--sequences", "09"] + words[3:])


def test_shipped_files_are_found_from_the_package():
    assert os.path.isfile(runner.find_config("kitti.yaml"))
    assert os.path.isfile(os.path.join(SCRIPTS, "sweep"))
    assert os.path.isfile(os.path.join(benchmark.SOURCES, "CMakeLists.txt"))


def test_plot_of_what_the_nodes_leave_shows_its_loop_links(folder, tmp_path):
    for name, ending in run_folder.NODE_FILES.items():
        (folder / name).rename(tmp_path / ("nodes" + ending))
    run = recorded_run.open_run(str(tmp_path / "nodes"))
    assert len(run.map.loop_ends) == 1 and run.templates is None and len(run.final) == 200
    plot_run.main([str(tmp_path / "nodes"), "--truth", str(tmp_path / "truth.tum")])
    assert (tmp_path / "nodes_run.png").exists()


def test_plot_of_a_recorded_bag(tmp_path):
    """Topics of a run of the nodes, as rosbag record leaves them."""
    rosbag = pytest.importorskip("rosbag")
    sys.path.append(os.path.join(os.path.dirname(SCRIPTS), "devel", "lib", "python3", "dist-packages"))
    messages = pytest.importorskip("ratslam_ros.msg")
    from geometry_msgs.msg import PoseStamped
    from rospy import Time

    path = str(tmp_path / "recorded.bag")
    with rosbag.Bag(path, "w") as bag:
        graph = messages.TopologicalMap()
        for i in range(5):
            at, turn = Time(100 + i), i * np.pi / 2
            view = messages.ViewTemplate(current_id=i % 4)
            action = messages.TopologicalAction(action=1 if i < 4 else 2, src_id=max(0, i - 1), dest_id=i % 4)
            pose = PoseStamped()
            pose.pose.position.x, pose.pose.position.y = np.cos(turn), np.sin(turn)
            pose.pose.orientation.w = 1.0
            if i < 4:
                graph.node.append(messages.TopologicalNode(id=i, pose=pose.pose))
            if i > 0:
                graph.edge.append(messages.TopologicalEdge(id=i - 1, source_id=i - 1, destination_id=i % 4))
            topics = {"LocalView/Template": view, "PoseCell/TopologicalAction": action, "ExperienceMap/RobotPose": pose}
            for topic, message in {**topics, "ExperienceMap/Map": graph}.items():
                message.header.stamp = at
                bag.write("/irat_red/" + topic, message, at)
    run = recorded_run.open_run(path)
    assert run.map.loop_ends.tolist() == [[3, 0]]
    assert len(run.online) == 5 and len(run.final) == 4 and run.final.stamps[0] == 100
    assert run.templates["template_id"].tolist() == [0, 1, 2, 3, 0]
    plot_run.main([path])
    assert (tmp_path / "recorded_run.png").exists()
    empty = str(tmp_path / "empty.bag")
    with rosbag.Bag(empty, "w") as bag:
        bag.write("/other", PoseStamped(), Time(1))
    with pytest.raises(InputError, match="ExperienceMap/Map"):
        recorded_run.open_run(empty)
