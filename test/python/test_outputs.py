"""Files that the commands write: none that is read is overwritten, none is left half, and empty words are refused."""

import json
import os
import resource
import subprocess
import sys

import pytest

from conftest import SCRIPTS
from run_fixtures import folder  # noqa: F401  (fixture)
from ratslam_tools import text_file
from ratslam_tools.errors import InputError
from ratslam_tools.trajectory import frames, write_kitti, write_tum


def test_what_is_read_is_not_overwritten(tmp_path, drive, fails):
    write_tum(tmp_path / "a.tum", drive(5))
    (tmp_path / "irat.txt").write_text("[draw]\nvtrans_scale=1\n")
    for link in ("link.tum", "link.png"):
        os.symlink(tmp_path / "a.tum", tmp_path / link)
    track, before = tmp_path / "a.tum", (tmp_path / "a.tum").read_bytes()
    for words in (
        ("trajectory_convert", track, tmp_path / "link.tum"),
        ("trajectory_convert", track, tmp_path / "b.txt", "--to", "kitti", "--save_times", track),
        ("evaluate_ape", track, track, "--save_results", track),
        ("evaluate_rpe", track, track, "--save_plot", tmp_path / "link.png"),
        ("evaluate_kitti", track, track, "--save_results", track),
        ("ini_to_yaml", tmp_path / "irat.txt", tmp_path / "irat.txt"),
        ("suggest_parameters", tmp_path, "--config", track, "--yaml", track),
        ("suggest_parameters", tmp_path, "--config", "c.yaml", "--yaml", tmp_path / "irat.txt"),
        ("trajectory_convert", tmp_path, tmp_path / "irat.txt", "--from", "gps"),
    ):
        assert "is read as well and would be overwritten" in fails(*words)
    assert track.read_bytes() == before


def test_no_file_of_a_run_or_of_its_truth_is_overwritten(folder, tmp_path, drive, fails):
    known, sequence = tmp_path / "truth.tum", tmp_path / "sequence"
    sequence.mkdir()
    write_kitti(sequence / "poses.txt", frames.convert(drive(), "base", "camera"))
    (sequence / "times.txt").write_text("".join(f"{stamp}\n" for stamp in drive().stamps))
    os.symlink(folder / "map.yaml", tmp_path / "link.png")
    write_tum(tmp_path / "nodes_final.tum", drive())
    files = {path: path.read_bytes() for path in [known, *tmp_path.glob("*_final.tum"), *folder.iterdir(), *sequence.iterdir()]}
    for words in (
        ("report", folder, "--truth", sequence, "--out", sequence / "poses.txt"),
        ("plot_run", folder, "--out", tmp_path / "link.png"),
        ("plot_run", tmp_path / "nodes", "--truth", known, "--save_results", tmp_path / "nodes_final.tum"),
        ("evaluate_nees", folder, "--truth", known, "--save_results", known),
        ("evaluate_nees", folder, "--truth", known, "--save_results", folder / "map.yaml"),
    ):
        assert "is read as well and would be overwritten" in fails(*words)
    complaint = fails("plot_run", folder, "--truth", known, "--out", tmp_path / "x.png", "--save_results", tmp_path / "x.png")
    assert "x.png is written as well" in complaint
    assert all(path.read_bytes() == content for path, content in files.items())


def test_results_in_a_runs_folder_may_be_written_again(folder, tmp_path, run, fails):
    words = ("plot_run", folder, "--truth", tmp_path / "truth.tum", "--map_only", "--save_results")
    for _ in range(2):
        assert run(*words, folder / "errors.json").returncode == 0
    (folder / "odometry_2.csv").write_text("frame,stamp,linear_x,angular_z\n0,0,1,0\n")
    for name in ("odometry_2.csv", "summary.json"):
        assert f"{name} is read as well" in fails(*words, folder / name)


@pytest.mark.parametrize(
    "content, what",
    [(b"#ROSBAG V2.0\nrest", "a recording"), (b"\x89MCAP0\r\n", "a recording"), (b"SQLite format 3\0", "a map or another database")],
)
def test_no_recording_and_no_map_is_replaced_by_an_output(folder, tmp_path, drive, fails, content, what):
    track, kept, link = tmp_path / "a.tum", tmp_path / "k2.bag", tmp_path / "link.png"
    write_tum(track, drive())
    kept.write_bytes(content)
    os.symlink(kept, link)
    for words in (
        ("trajectory_convert", track, kept),
        ("trajectory_convert", track, tmp_path / "b.txt", "--to", "kitti", "--save_times", kept),
        ("evaluate_ape", track, track, "--save_results", kept),
        ("evaluate_rpe", track, track, "--save_plot", link),
        ("report", folder, "--out", kept),
        ("plot_run", folder, "--out", link),
        ("evaluate_places", folder, folder, "--csv", kept),
        ("suggest_parameters", folder, "--config", track, "--yaml", kept),
    ):
        output = words[-1]
        assert fails(*words) == f"error: {output}: cannot be written: it is {what} and is not overwritten\n"
    assert kept.read_bytes() == content and not list(tmp_path.glob("*.part"))


def test_a_figure_takes_the_place_of_another_only_when_it_is_complete(folder, tmp_path, run):
    picture, linked = tmp_path / "a.png", tmp_path / "b.tum"
    linked.write_text("of somebody else\n")
    os.link(linked, picture)
    assert run("plot_run", folder, "--out", picture).returncode == 0
    assert picture.read_bytes()[:4] == b"\x89PNG" and linked.read_text() == "of somebody else\n"
    before = picture.read_bytes()
    full = run("plot_run", folder, "--out", picture, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000)))
    assert full.returncode == 1 and f"{picture}: the figure cannot be written: File too large\n" in full.stderr
    assert picture.read_bytes() == before and not (tmp_path / "a.png.part").exists()


def test_a_file_of_the_users_own_beside_an_output_is_not_touched(folder, tmp_path, drive, run):
    pytest.importorskip("rosbag")
    from ratslam_tools.datasets import bags

    outputs = {"b.tum": tmp_path / "b.tum.part", "c.png": tmp_path / "c.png.part", "d.bag": tmp_path / "d.bag.part"}
    write_tum(outputs["b.tum"], drive())  # it is even what is read
    before = outputs["b.tum"].read_bytes()
    for own in outputs.values():
        own.write_bytes(before)
    assert run("trajectory_convert", outputs["b.tum"], tmp_path / "b.tum").returncode == 0
    assert run("plot_run", folder, "--out", tmp_path / "c.png").returncode == 0
    with bags.writing(str(tmp_path / "d.bag")):
        pass
    assert all(own.read_bytes() == before for own in outputs.values())
    assert {path.name for path in tmp_path.iterdir()} == {*outputs, *(own.name for own in outputs.values()), "run", "truth.tum"}


def test_two_writers_of_one_output_do_not_mix_and_leave_one(tmp_path):
    path = tmp_path / "a.txt"
    with text_file.writing(str(path)) as first, text_file.writing(str(path)) as second:
        first.write("first\n")
        second.write("2\n")
    assert path.read_text() == "first\n" and os.listdir(tmp_path) == ["a.txt"]
    (tmp_path / "plain").write_text("")
    assert path.stat().st_mode == (tmp_path / "plain").stat().st_mode


def test_an_output_that_fails_leaves_nothing(tmp_path):
    with pytest.raises(KeyboardInterrupt), text_file.writing(str(tmp_path / "a.txt")) as file:
        file.write("half\n")
        raise KeyboardInterrupt
    assert os.listdir(tmp_path) == []
    with pytest.raises(InputError, match="nowhere/a.txt: cannot be written: No such file or directory"):
        with text_file.writing(str(tmp_path / "nowhere" / "a.txt")):
            pass


@pytest.mark.parametrize("sink", ["| cat > out.txt", "> out.txt", ">> out.txt"])
def test_what_is_written_to_stdout_is_all_there_in_its_order(sink, tmp_path, drive):
    write_tum(tmp_path / "a.tum", drive(5))
    (tmp_path / "out.txt").write_text("before\n" if ">>" in sink else "")
    command = f"'{sys.executable}' '{SCRIPTS}/evaluate_ape' a.tum a.tum --save_results /dev/stdout"
    done = subprocess.run(f"{command} {sink}", shell=True, cwd=tmp_path, stderr=subprocess.PIPE, check=False)
    assert done.stderr == b""
    told, mark, record = (tmp_path / "out.txt").read_text().partition("{")
    assert told.startswith("before\nAPE" if ">>" in sink else "APE") and "a.tum" in told
    assert json.loads(mark + record)["metric"] == "ape"
    command = f"'{sys.executable}' '{SCRIPTS}/trajectory_convert' a.tum /dev/stdout"
    assert subprocess.run(f"{command} {sink}", shell=True, cwd=tmp_path, check=False).returncode == 0
    lines = (tmp_path / "out.txt").read_text().splitlines()
    assert lines[-6:-1] == (tmp_path / "a.tum").read_text().splitlines() and lines[-1].startswith("/dev/stdout: 5 poses")


def test_a_pipe_is_written_in_place(tmp_path, drive, run):
    write_tum(tmp_path / "a.tum", drive(5))
    os.mkfifo(tmp_path / "pipe.tum")
    with subprocess.Popen(["cat", tmp_path / "pipe.tum"], stdout=subprocess.PIPE) as reader:
        assert run("trajectory_convert", tmp_path / "a.tum", tmp_path / "pipe.tum").returncode == 0
        assert reader.communicate()[0] == (tmp_path / "a.tum").read_bytes()
    full = run("trajectory_convert", tmp_path / "a.tum", "/dev/full")
    assert full.returncode == 1 and full.stderr == "error: /dev/full: cannot be written: No space left on device\n"


def test_a_figure_is_written_under_the_name_that_is_given_or_not_at_all(tmp_path, drive, run):
    track = tmp_path / "a.tum"
    write_tum(track, drive())
    done = run("evaluate_ape", track, track, "--save_plot", tmp_path / "plot")
    assert done.returncode == 2 and "a picture ends in" in done.stderr and os.listdir(tmp_path) == ["a.tum"]
    done = run("evaluate_ape", track, track, "--save_plot", tmp_path / "nowhere" / "plot.png")
    assert done.returncode == 1 and done.stderr.endswith("the figure cannot be written: No such file or directory\n")


@pytest.mark.parametrize(
    "words, complaint",
    [
        (("kitti_to_bag", "seq", "x.bag", "--odometry", ""), "error: --odometry: the word behind it is empty\n"),
        (("reproduce_records", "seq", "--config="), "error: --config: its value is empty\n"),
        (("report", ""), "error: the first argument is empty\n"),
        (("trajectory_convert", "a.tum", ""), "error: a.tum: the word behind it is empty\n"),
    ],
)
def test_an_empty_word_is_not_taken_for_an_option_that_is_not_given(fails, words, complaint):
    assert fails(*words) == complaint


def test_a_command_works_without_an_output_stream(tmp_path, drive):
    write_tum(tmp_path / "a.tum", drive())
    words = f"'{sys.executable}' '{SCRIPTS}/evaluate_ape' '{tmp_path}/a.tum' '{tmp_path}/a.tum' --save_results '{tmp_path}/a.json'"
    done = subprocess.run(f"{words} >&-", shell=True, stderr=subprocess.PIPE, check=False)
    assert done.returncode == 0 and done.stderr == b"" and (tmp_path / "a.json").exists()
