"""Run folders: reading, pictures, report, sweep and the paper's figures, with a stand-in for ratslam_run."""

import os
import re
import shutil
import sys

import numpy as np
import pytest

from conftest import SCRIPTS
from run_fixtures import calls, folder, program  # noqa: F401  (fixtures)
from ratslam_tools import plotting
from ratslam_tools.cli import benchmark, plot_run, report, reproduce_paper
from ratslam_tools.datasets import truth
from ratslam_tools.runs import activity_figure, recorded_run, run_figures, run_folder, runner
from ratslam_tools.trajectory import frames
from ratslam_tools.errors import InputError
from ratslam_tools.trajectory import write_kitti


@pytest.mark.parametrize("width", [3.0, 4999.9999999999995, 5000.0, 1e-3])
def test_the_scale_bar_has_a_round_length_that_fits(width):
    _, axes = plotting.load().subplots()
    axes.set_xlim(0.0, width)
    plotting.scale_bar(axes)
    length = float(axes.artists[-1].txt_label.get_text().split()[0])
    assert 0.09 * width < length <= width / 5 and f"{length:e}"[0] in "125"


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
        ("x: 10.8", "x: far", "not a number"),
        ("- {id: 1,", "- {id: 0,", "twice"),
        ("yaw: 0.5", "jaw: 0.5", "has no yaw"),
        ("experiences:\n", "", "outside"),
        ("- {id: 1, x", "- {id: 1\n- {id: 1, x", "cut off"),
    ],
)
def test_broken_maps_are_named(folder, find, put, words):
    text = (folder / "map.yaml").read_text()
    assert find in text
    (folder / "map.yaml").write_text(text.replace(find, put))
    with pytest.raises(InputError, match=words):
        run_folder.read_map(str(folder / "map.yaml"))


@pytest.mark.parametrize(
    "name, content",
    [
        ("summary.json", '{"parameters": {"pc_dim_xy": NaN, "pc_dim_th": 36}}'),
        ("summary.json", '{"parameters": {"pc_dim_xy": "many", "pc_dim_th": 36}}'),
        ("summary.json", '{"parameters": {"pc_dim_xy": 1e12, "pc_dim_th": 1000000000}}'),
        ("summary.json", '{"parameters": [], "timing": 5, "counts": "x", "version": {}}'),
        ("map.yaml", None),
        ("actions.csv", "stamp,action,src_id,dest_id,x,y,th\n0.1,nan,0,0,0,0,0\n"),
        ("actions.csv", "stamp;action\n0.1;1\n"),
        ("templates.csv", "stamp,template_id,error,relative_rad\n0.1,0,inf,0\n"),
        ("templates.csv", "stamp,template_id\n0.1,0\n"),
        ("pose_cells.csv", "stamp,layer,row,column\n5.0,35,29,4\n"),
    ],
)
def test_a_run_that_is_none_is_drawn_or_refused_in_one_line(folder, name, content):
    (folder / name).unlink()
    if content is None:
        os.mkfifo(str(folder / name))  # a pipe would be waited for
    else:
        (folder / name).write_text(content)
    try:
        report.main([str(folder)])
    except InputError as error:
        assert name in str(error) and len(str(error)) < 300


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


@pytest.mark.parametrize("out", ["", "picture", "picture.doc"])
def test_plot_run_writes_the_file_that_it_names_or_none(folder, tmp_path, capsys, out):
    with pytest.raises(SystemExit):
        plot_run.main([str(folder), "--out", str(tmp_path / out)])
    assert str(tmp_path / out) in capsys.readouterr().err and not list(tmp_path.parent.glob(tmp_path.name + ".*"))


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


def test_folders_that_are_no_run(tmp_path):
    with pytest.raises(InputError, match="no trajectory_final.tum"):
        plot_run.main([str(tmp_path)])
    with pytest.raises(InputError, match="no such folder"):
        plot_run.main([str(tmp_path / "absent")])
    (tmp_path / "trajectory.tum").touch()
    with pytest.raises(InputError, match="trajectory.tum: it is a file, and a folder is needed"):
        plot_run.main([str(tmp_path / "trajectory.tum")])


def test_report_holds_everything_and_fetches_nothing(folder, tmp_path):
    report.main([str(folder), "--truth", str(tmp_path / "truth.tum")])
    text = (folder / "report.html").read_text()
    assert text.count("data:image/png;base64,") == 8
    assert not re.search(r"(src|href)=\"(?!data:)", text) and "@import" not in text and "url(" not in text
    assert "&lt;kitti&gt; &amp; co" in text and "<kitti>" not in text
    assert "pc_dim_xy" in text and "100.0 %" in text and "@media print" in text


def test_no_file_of_a_run_or_its_truth_is_overwritten(folder, tmp_path, fails):
    run, known = folder, tmp_path / "truth.tum"
    for words in (
        ("report", run, "--out", run / "templates.csv"),
        ("report", run, "--truth", known, "--out", known),
        ("plot_run", run, "--truth", known, "--save_results", run / "trajectory_final.tum"),
    ):
        assert "is read as well and would be overwritten" in fails(*words)
    assert "--t_max_diff: -1 is not allowed" in fails("report", run, "--truth", known, "--t_max_diff", "-1")


def test_options_about_the_truth_need_one(folder, tmp_path, fails):
    known, times = tmp_path / "truth.tum", tmp_path / "times.txt"
    for tool in ("plot_run", "report"):
        assert f"--times: {times} has no effect: there is no --truth" in fails(tool, folder, "--times", times)
        assert "--t_max_diff: 0.02 has no effect" in fails(tool, folder, "--t_max_diff", "0.02")
        assert f"--times: {times} has no effect: {known} has stamps" in fails(tool, folder, "--truth", known, "--times", times)
    assert "--save_results: no.json has no effect" in fails("plot_run", folder, "--save_results", "no.json")
    assert not (folder / "run.png").exists() and not (folder / "report.html").exists()


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


def test_truth_by_the_frame_is_seen_from_above_and_names_what_is_none(tmp_path):
    path = tmp_path / "poses.txt"
    # The camera looks along z; 3 m ahead, 2 m to the right, turned left by a quarter.
    path.write_text("0 0 -1 2 0 1 0 0 1 0 0 3\n")
    positions, headings = truth.read_plane_poses(str(path))
    np.testing.assert_allclose(positions, [[3.0, -2.0]])
    np.testing.assert_allclose(headings, [np.pi / 2])
    for text, reason in (
        ("1 2 3\n", "KITTI poses have 12"),
        ("north\n", "poses.txt:1: not a number"),
        ("", "no poses"),
        ("# truth\n0 0 -1 2 0 1 0 0 1 0 0 3\n0 0 -1 nan 0 1 0 0 1 0 0 3\n", "poses.txt:3: a NaN or infinite value"),
        ("0 0 -1 2 0 1 0 0 1 0 0 inf\n", "poses.txt:1: a NaN or infinite value"),
        ("0 0 0 2 0 0 0 0 0 0 0 3\n", "pose 1 holds no rotation matrix"),
    ):
        path.write_text(text)
        with pytest.raises(InputError, match=reason):
            truth.read_plane_poses(str(path))


def test_runner_is_looked_for_and_its_absence_explained(tmp_path, monkeypatch, program):
    monkeypatch.setenv("PATH", str(tmp_path))
    program.rename(tmp_path / "ratslam_run")
    assert runner.find() == str(tmp_path / "ratslam_run")
    with pytest.raises(InputError, match="not an executable file"):
        runner.find(str(tmp_path / "truth.tum"))


def test_a_folder_of_somebody_else_is_not_replaced_by_a_run(program, tmp_path):
    """An output folder that is that of the data set would name the sequences themselves."""
    sequence = tmp_path / "sequences" / "05"
    sequence.mkdir(parents=True)
    (sequence / "times.txt").write_text("0\n0.1\n")
    words = runner.command(str(program), "in", "c.yaml", str(sequence))
    with pytest.raises(InputError, match="05: not replaced by a run: .* give another --out"):
        runner.run_once(words, str(sequence))
    assert (sequence / "times.txt").exists()

    out = tmp_path / "out" / "05"
    out.mkdir(parents=True)
    with pytest.raises(InputError, match="exit status"):  # ... and may be tried again
        runner.run_once(["/bin/false"], str(out))
    for _ in range(2):
        runner.run_once(["/bin/true"], str(out))


@pytest.fixture
def paper_words(program, tmp_path, drive):
    """The words of reproduce_paper with the stand-in for a benchmark of one sequence, 00."""
    sequence = tmp_path / "kitti" / "sequences" / "00"
    sequence.mkdir(parents=True)
    (tmp_path / "kitti" / "poses").mkdir()
    write_kitti(tmp_path / "kitti" / "poses" / "00.txt", frames.convert(drive(), "base", "camera"))
    np.savetxt(sequence / "times.txt", drive().stamps)
    for name in ("kitti.yaml", "kitti_orb.yaml"):
        (tmp_path / name).write_text("")
    return [
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


def test_paper_table_and_figures(program, tmp_path, paper_words, capsys):
    words = paper_words
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


def test_a_paper_whose_sweep_failed_in_part_is_made_and_says_so(program, tmp_path, paper_words, capsys):
    failing = tmp_path / "failing_run"
    failing.write_text(f'#!/bin/sh\ncase "$*" in *pc_cell_x_size=2*) exit 3;; esac\nexec {program} "$@"\n')
    failing.chmod(0o755)
    paper_words[paper_words.index("--ratslam_run") + 1] = str(failing)
    with pytest.raises(InputError, match="^1 runs of the sweeps failed; the first: pc_cell_x_size=2: .*exit status 3"):
        reproduce_paper.main(paper_words)
    assert "fig7_00_orb.png" in capsys.readouterr().out and (tmp_path / "paper" / "fig7_00_orb.png").exists()


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


def test_figures_of_two_runs_of_the_nodes_lie_beside_each(folder, tmp_path):
    for name in ("drive.1", "drive.2"):
        for own, ending in run_folder.NODE_FILES.items():
            shutil.copy(folder / own, tmp_path / (name + ending))
        plot_run.main([str(tmp_path / name), "--map_only"])
        report.main([str(tmp_path / name)])
    assert {"drive.1_run.png", "drive.2_run.png", "drive.1_report.html", "drive.2_report.html"} <= set(os.listdir(tmp_path))


def test_loop_links_of_a_recorded_bag_may_lead_to_newer_experiences(tmp_path):
    rosbag = pytest.importorskip("rosbag")
    sys.path.append(os.path.join(os.path.dirname(SCRIPTS), "devel", "lib", "python3", "dist-packages"))
    messages = pytest.importorskip("ratslam_ros.msg")
    from geometry_msgs.msg import PoseStamped
    from rospy import Time

    # Round a loop; back at 1 a short cut to 3 is recalled. To 4, made while the robot was lost, no way leads.
    links = [(0, 1), (1, 2), (2, 3), (3, 1), (1, 3), (4, 5), (5, 0), (0, 4)]
    path = str(tmp_path / "recorded.bag")
    with rosbag.Bag(path, "w") as bag:
        graph = messages.TopologicalMap()
        for number in range(6):
            graph.node.append(messages.TopologicalNode(id=number))
        for number, (start, end) in enumerate(links):
            graph.edge.append(messages.TopologicalEdge(id=number, source_id=start, destination_id=end))
        for second in (100, 101):
            pose = PoseStamped()
            pose.header.stamp, pose.pose.orientation.w = Time(second), 1.0
            bag.write("/ExperienceMap/RobotPose", pose, Time(second))
        bag.write("/ExperienceMap/Map", graph, Time(120))
    run = recorded_run.open_run(path)
    assert run.map.loop_ends.tolist() == [[3, 1], [1, 3], [5, 0], [0, 4]]
    # Without the pose cells' decisions the path is the online one.
    assert (run.online.name, run.final.name) == ("online", "final") and run.final.stamps.tolist() == [100.0, 101.0]
    plot_run.main([path])
    report.main([path])
    assert {"recorded_run.png", "recorded_report.html"} <= {file.name for file in tmp_path.iterdir()}


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
