"""What ratslam_run, ratslam_places and ratslam_map say of options that contradict each other, and do not destroy."""

import json
import os
import shutil
import subprocess

import numpy as np
import pytest
from test_run_endings import program, run, short  # noqa: F401  (program and short are fixtures)


def said_by(*words):
    return subprocess.run(
        list(map(str, words)), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True, check=False
    )


def beside(program, name):  # noqa: F811
    return os.path.join(os.path.dirname(program), name)


@pytest.mark.parametrize(
    "words, why",
    [
        (["--set", "image_crop_y_max=2000"], "none of its images could be used"),
        (["--max-frames", "1", "--set", "pc_vt_inject_energy=0"], "nothing was mapped"),
    ],
)
def test_a_run_in_vain_leaves_the_map_that_was_there(program, short, tmp_path, words, why):  # noqa: F811
    drive_map = tmp_path / "drive.db"
    assert run(program, short, tmp_path / "out", "--save-map", drive_map).returncode == 0
    before = drive_map.read_bytes()
    vain = run(program, short, tmp_path / "again", "--save-map", drive_map, *words)
    assert vain.returncode == 1 and why in vain.stdout, vain.stdout
    assert f"{drive_map} stays as it was" in vain.stdout, vain.stdout
    assert drive_map.read_bytes() == before


def test_a_run_in_vain_leaves_no_empty_map(program, short, tmp_path):  # noqa: F811
    vain = run(program, short, tmp_path / "out", "--save-map", tmp_path / "new.db", "--set", "image_crop_y_max=2000")
    assert vain.returncode == 1 and f"{tmp_path / 'new.db'} is not written" in vain.stdout, vain.stdout
    assert [name for name in os.listdir(tmp_path) if name.startswith("new.db")] == []


def test_no_file_is_written_where_another_is(program, short, tmp_path):  # noqa: F811
    drive_map = tmp_path / "drive.db"
    assert run(program, short, tmp_path / "out", "--save-map", drive_map).returncode == 0
    os.symlink(tmp_path / "out" / "odometry.csv", tmp_path / "link.csv")
    os.symlink(drive_map, tmp_path / "run.avi")
    kept = drive_map.read_bytes()
    for words, option in (
        (["--video", tmp_path / "a.avi", "--save-map", tmp_path / "a.avi"], "--video: value .*a.avi"),
        (["--load-map", drive_map, "--video", tmp_path / "run.avi"], "--video: value .*run.avi"),
        (["--odometry", tmp_path / "link.csv"], "--out: value"),
    ):
        refused = run(program, short, tmp_path / "out", *words)
        assert refused.returncode == 1 and refused.stdout.count("\n") == 1, refused.stdout
        assert "would take the place of" in refused.stdout, (option, refused.stdout)
    assert drive_map.read_bytes() == kept
    assert run(program, short, tmp_path / "on", "--load-map", drive_map, "--save-map", drive_map).returncode == 0


def test_places_are_not_written_over_what_is_read(program, short, tmp_path):  # noqa: F811
    places = beside(program, "ratslam_places")
    recording = tmp_path / "recording"
    shutil.copytree(str(short), str(recording))
    config = tmp_path / "view.yaml"
    config.write_text("template_x_size: 20\ntemplate_y_size: 6\nvt_shift_match: 2\n")
    times = (recording / "times.txt").read_text()
    for out in (recording / "times.txt", config):
        refused = said_by(places, recording, "--min-gap", "5", "--config", config, "--out", out)
        assert refused.returncode == 1 and "--out: value" in refused.stdout, refused.stdout
    assert (recording / "times.txt").read_text() == times and config.read_text().startswith("template")
    often = said_by(places, recording, recording, "--starts", "31", "--config", config, "--out", tmp_path / "starts.csv")
    assert often.returncode == 1 and "--starts: value 31 is not allowed" in often.stdout, often.stdout
    vain = said_by(places, recording, "--min-gap", "30", "--config", config, "--out", tmp_path / "places.csv")
    assert vain.returncode == 1 and "it has 30 images" in vain.stdout, vain.stdout
    assert not (tmp_path / "places.csv").exists()


@pytest.mark.parametrize(
    "assignment, instead",
    [
        ("stamp_source=arrival", "a recording has the stamps of its images"),
        ("localise_only=true", "--localise-only"),
        ("map_dir=/nowhere", "--load-map and --save-map"),
        ("trajectory_file=/nowhere/run", "--out"),
        ("trajectory_format=kitti", "trajectory_convert"),
    ],
)
def test_what_is_for_nodes_is_said_to_be(program, short, tmp_path, assignment, instead):  # noqa: F811
    done = run(program, short, tmp_path / "out", "--set", assignment)
    key, value = assignment.split("=")
    assert done.returncode == 0
    assert f"{key}: value {value} is for nodes and has no effect here" in done.stdout, done.stdout
    assert instead in done.stdout, done.stdout


@pytest.mark.parametrize("assignment", ["publish_tf=perhaps", "image_queue_size=-5", "map_frame=/map", "map_period=-3"])
def test_bad_values_of_nodes_are_refused_everywhere(program, short, tmp_path, assignment):  # noqa: F811
    for refused in (
        run(program, short, tmp_path / "out", "--set", assignment),
        said_by(beside(program, "ratslam_places"), short, "--open", "--set", assignment, "--out", tmp_path / "p.csv"),
    ):
        assert refused.returncode == 1 and refused.stdout.count("\n") == 1, refused.stdout
        assert assignment.split("=")[0] in refused.stdout


def test_an_openratslam_configuration_may_say_otherwise(program, short, tmp_path):  # noqa: F811
    config = tmp_path / "config.txt"
    config.write_text("[ratslam]\ntemplate_x_size=20\ntemplate_y_size=6\nvt_shift_match=2\n")
    done = said_by(program, short, "--config", config, "--set", "exp_solver=graph", "--out", tmp_path / "out")
    assert "implies OpenRatSLAM's arithmetic, exp_solver=relaxation, unless exp_solver is set" in done.stdout
    assert '"exp_solver": "graph"' in (tmp_path / "out" / "summary.json").read_text()


def test_activity_that_dies_is_counted_and_said(program, short, tmp_path):  # noqa: F811
    done = run(program, short, tmp_path / "out", "--set", "pc_global_inhib=1")
    starts = json.loads((tmp_path / "out" / "summary.json").read_text())["counts"]["pose_cell_fresh_starts"]
    assert starts > 0 and f"all activity of the pose cells died {int(starts)} times" in done.stdout, done.stdout


def test_home_is_found_behind_an_equals_sign(program, short, tmp_path):  # noqa: F811
    home = tmp_path / "home"
    home.mkdir()
    done = run(program, short, "~/run", cwd=str(tmp_path), env={**os.environ, "HOME": str(home)})
    assert done.returncode == 0, done.stdout
    assert (home / "run" / "summary.json").exists() and not (tmp_path / "~").exists()


def test_a_map_goes_to_a_machine_with_other_threads(program, short, tmp_path):  # noqa: F811
    drive_map = tmp_path / "drive.db"
    first = ["--max-frames", "15", "--save-map", drive_map, "--set", "threads=2"]
    assert run(program, short, tmp_path / "out", *first).returncode == 0
    on = run(program, short, tmp_path / "out", "--load-map", drive_map, "--from-frame", "15", "--set", "threads=1")
    assert on.returncode == 0, on.stdout
    assert run(program, short, tmp_path / "whole").returncode == 0
    final = "trajectory_final.tum"
    assert (tmp_path / "out" / final).read_bytes() == (tmp_path / "whole" / final).read_bytes()


def test_a_second_day_is_exported_in_stretches(program, short, tmp_path):  # noqa: F811
    drive_map = tmp_path / "drive.db"
    assert run(program, short, tmp_path / "one", "--save-map", drive_map).returncode == 0
    assert run(program, short, tmp_path / "two", "--load-map", drive_map, "--save-map", drive_map).returncode == 0
    (tmp_path / "days_3.tum").write_text("of another map")
    done = said_by(beside(program, "ratslam_map"), "export", drive_map, "--format", "tum", "-o", tmp_path / "days.tum")
    assert "days_3.tum: lies there already" in done.stdout and (tmp_path / "days_3.tum").exists(), done.stdout
    assert done.returncode == 0 and "days_2.tum: stretch 2 of 2" in done.stdout, done.stdout
    for name, of_run in (("days.tum", "trajectory_final.tum"), ("days_2.tum", "trajectory_final_2.tum")):
        # The run goes on to settle its map once it has saved it.
        assert np.loadtxt(tmp_path / name) == pytest.approx(np.loadtxt(tmp_path / "two" / of_run), abs=1e-6)


@pytest.mark.parametrize(
    "name, words",
    [("ratslam_run", ["--odom", "profile"]), ("ratslam_places", ["--min", "5"]), ("ratslam_map", ["--form", "tum"])],
)
def test_options_have_their_full_names(program, short, name, words):  # noqa: F811
    refused = said_by(beside(program, name), short, *words)
    assert refused.returncode == 1 and f"'{words[0]}'" in refused.stdout, refused.stdout
