"""Sweeps over parameters: their ranges, what they keep and how they end."""

import csv
import json
import os
import signal
import subprocess
import sys
import threading
import time

import pytest

from conftest import SCRIPTS, built
from run_fixtures import calls, folder, merging, program, sweep_words  # noqa: F401  (fixtures)
from ratslam_tools.cli import sweep
from ratslam_tools.errors import InputError
from ratslam_tools.runs import grid
from ratslam_tools.trajectory import write_tum


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
        "k=0:1e308:1e-308",
        "k=-1e308:1e308:1",
    ],
)
def test_ranges_that_are_none(text):
    with pytest.raises(InputError, match="--vary"):
        grid.parse_vary(text)


def test_a_file_is_no_folder_for_runs(tmp_path):
    (tmp_path / "out").write_text("mine")
    with pytest.raises(InputError, match="--out: .* is a file"):
        sweep.main(["in", "--config", "c", "--vary", "k=1,2", "--goal", "counts.recalls", "--out", str(tmp_path / "out")])
    assert (tmp_path / "out").read_text() == "mine"


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


def test_a_changed_configuration_or_truth_is_computed_anew(program, tmp_path, drive):
    words = sweep_words(program, tmp_path, "other=1,2")
    words[words.index("c.yaml")] = str(tmp_path / "c.yaml")
    (tmp_path / "c.yaml").write_text("exp_loops: 5\n")
    for _ in range(2):
        sweep.main(words)
        assert len(calls(program)) == 2
    (tmp_path / "c.yaml").write_text("exp_loops: 6\n")
    sweep.main(words)
    assert len(calls(program)) == 4
    write_tum(tmp_path / "truth.tum", drive(150))
    sweep.main(words)
    assert len(calls(program)) == 6
    sweep.main(words + ["--t_max_diff", "0.02"])
    assert len(calls(program)) == 8
    with pytest.raises(InputError, match="--times: t.txt has no effect: there is no --truth"):
        sweep.main([*words[:words.index("--truth")], *words[words.index("--truth") + 2 :], "--times", "t.txt"])
    with pytest.raises(InputError, match="--t_max_diff: -1 is not allowed"):
        sweep.main(words + ["--t_max_diff", "-1"])


def test_results_that_are_none_are_computed_anew_and_not_merged(program, tmp_path):
    words = sweep_words(program, tmp_path, "other=1,2")
    sweep.main(words)
    for content in ("[1]", '{"figures": 3}', '{"figures": {"a": "b"}}', "{"):
        (tmp_path / "out" / "runs" / "other=1" / "result.json").write_text(content)
        with pytest.raises(InputError, match="other=1/result.json: not "):
            sweep.main(merging(tmp_path / "out", [tmp_path / "out"], "other=1,2"))
    sweep.main(words)
    assert len(calls(program)) == 3


def test_what_follows_two_dashes_is_passed_on(program, tmp_path):
    more = ["--image-topic", "/front/image"]
    sweep.main(sweep_words(program, tmp_path, "pc_vt_inject_energy=0.1,0.2") + ["--odometry", "orb", "--", *more])
    assert len(calls(program)) == 3 and all(call.endswith(" ".join(more)) for call in calls(program))


@pytest.mark.parametrize("more", [[], ["--shard", "1/2"]])
def test_runs_do_not_lie_in_the_recordings_own_folder(program, tmp_path, more):
    (tmp_path / "drive").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "drive")
    words = sweep_words(program, tmp_path, "other=1,2")
    words[0] = str(tmp_path / "drive")
    for own in (tmp_path / "drive", f"{tmp_path}/drive/.", tmp_path / "link", tmp_path / "link" / "image_0"):
        words[words.index("--out") + 1] = str(own)
        with pytest.raises(InputError, match="^--out: '.*' is not allowed: it must be another folder than the recording's own"):
            sweep.main(words + more)
    assert not calls(program) and not os.listdir(tmp_path / "drive")
    words[words.index("--out") + 1] = str(tmp_path / "drive" / "out")
    if not more:
        sweep.main(words)
        assert os.listdir(tmp_path / "drive") == ["out"]


@pytest.mark.parametrize(
    "key, passed_on",
    [
        ("vt_match_threshold", ["--set", "vt_match_threshold=0.5"]),
        ("vt_match_threshold", ["--image-topic", "/a", "--set= vt_match_threshold = 0.5"]),
        ("vt_match_threshold", ["--se", "exp_loops=3", "--se", "vt_match_threshold=0.5"]),
        ("vt_patch_normalise", ["--set", "vt_patch_normalisation=1"]),
        ("vt_patch_normalisation", ["--set", "vt_patch_normalise=1"]),
    ],
)
def test_a_key_that_is_varied_cannot_be_set_as_well(program, tmp_path, key, passed_on):
    with pytest.raises(InputError, match=f"^--set: '.*' is not allowed: {key} gets its values from this command itself"):
        sweep.main(sweep_words(program, tmp_path, f"{key}=1,2") + ["--", *passed_on])
    assert not calls(program) and not (tmp_path / "out").exists()


def test_other_keys_than_the_varied_ones_can_be_set(program, tmp_path):
    sweep.main(sweep_words(program, tmp_path, "vt_match_threshold=1,2") + ["--", "--set", "vt_patch_normalise=1"])
    assert len(calls(program)) == 2 and all("--set vt_patch_normalise=1" in call for call in calls(program))


@pytest.mark.parametrize("second", ["vt_patch_normalise", "vt_patch_normalisation"])
def test_a_key_is_varied_once_however_it_is_spelled(program, tmp_path, second):
    with pytest.raises(InputError, match=f"^--vary: {second} is given twice"):
        sweep.main(sweep_words(program, tmp_path, "vt_patch_normalise=1,2", f"{second}=3,4"))
    assert not calls(program) and not (tmp_path / "out").exists()


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


def test_a_sweep_has_one_goal(program, tmp_path):
    with pytest.raises(InputError, match="--goal: counts.recalls and ape.final.max are not allowed together"):
        sweep.main([*sweep_words(program, tmp_path, "other=1,2"), "--goal", "counts.recalls", "--goal", "ape.final.max"])


def test_a_misspelt_parameter_is_refused_before_anything_is_computed(program, tmp_path):
    with pytest.raises(InputError, match="--vary: nokey: no parameter has this name$"):
        sweep.main([*sweep_words(program, tmp_path, "other=1,2", "nokey=1,2"), "--odometry", "orb"])
    assert calls(program) == [] and not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "vary, complaint",
    [
        ("vt_match_treshold=0.03,0.04", "vt_match_treshold: no parameter has this name; did you mean vt_match_threshold"),
        ("vt_match_threshold=0.03,abc", "vt_match_threshold: value 'abc' is not a number$"),
        ("vt_match_threshold=0.03,-1", "failed"),  # the range is for the runs to judge
    ],
)
def test_ratslam_run_says_what_is_no_parameter_or_no_value(tmp_path, vary, complaint):
    (found,) = built()
    (tmp_path / "c.yaml").write_text("")
    words = sweep_words(found, tmp_path, vary)
    words[words.index("c.yaml")] = str(tmp_path / "c.yaml")
    at = words.index("--truth")
    del words[at : at + 2]
    with pytest.raises(InputError, match=complaint):
        sweep.main([*words, "--goal", "counts.recalls"])


def test_a_sweep_needs_a_recording(capsys):
    with pytest.raises(SystemExit):
        sweep.main(["--vary", "k=1,2", "--out", "out"])
    assert "the following arguments are required: INPUT, --config" in capsys.readouterr().err


def test_runs_without_the_goal_are_left_out(program, tmp_path, capsys):
    vary = "pc_vt_inject_energy=0.1,0.2,0.4"
    sweep.main(sweep_words(program, tmp_path, vary))
    path = tmp_path / "out" / "runs" / "pc_vt_inject_energy=0.2" / "result.json"
    record = json.loads(path.read_text())
    del record["figures"]["ape.final.ground_mean"]
    path.write_text(json.dumps(record))
    capsys.readouterr()
    sweep.main([*sweep_words(program, tmp_path, vary), "--goal", "ape.final.ground_mean"])
    told = capsys.readouterr()
    assert "note: 1 of 3 runs have no ape.final.ground_mean and are left out" in told.err
    assert "best ape.final.ground_mean" in told.out and "with pc_vt_inject_energy=0.1" in told.out
    assert (tmp_path / "out" / "ape.final.ground_mean_over_pc_vt_inject_energy.png").exists()


@pytest.mark.parametrize(
    "name, label",
    [
        ("ape.final.mean", "mean APE of the final trajectory [m]"),
        ("ape.online.sse", "sse APE of the online trajectory [m^2]"),
        ("ape.final.coverage", "coverage of the final trajectory, as a share"),
        ("timing.orb_odometry", "orb odometry [ms a frame]"),
        ("counts.recalls", "recalls"),
    ],
)
def test_a_figure_names_the_unit_of_its_goal(name, label):
    assert grid.Goal(name).label == label


def test_every_point_has_a_folder_of_its_own():
    names = {grid.folder_name({"k": value}) for value in ("a/b", "a_b", "a%2Fb", "ab")}
    assert len(names) == 4 and all("/" not in name for name in names)


class StandIn:
    """A runner whose runs last until it is stopped."""

    def __init__(self):
        self.begun, self.stopped = threading.Event(), threading.Event()

    def run(self, _words):
        self.begun.set()
        assert self.stopped.wait(20)
        raise InputError("stopped")

    def stop(self):
        self.stopped.set()


def test_an_interrupted_sweep_leaves_the_older_results_of_what_it_has_not_begun(tmp_path, monkeypatch):
    points = grid.grid([("k", ["1", "2", "3"])])
    begun = grid.Sweep(lambda _point, folder: ["program", "in", "--out", folder], points, str(tmp_path), None, 0.01, False)
    begun.runner = StandIn()
    for number in (1, 2, 3):
        (tmp_path / "runs" / f"k={number}").mkdir(parents=True)
        (tmp_path / "runs" / f"k={number}" / "result.json").write_text("{}")

    def interrupted(_futures):
        assert begun.runner.begun.wait(20)
        raise KeyboardInterrupt

    monkeypatch.setattr(grid, "as_completed", interrupted)
    with pytest.raises(KeyboardInterrupt):
        begun.run(1)
    assert sorted(path.parent.name for path in tmp_path.rglob("result.json")) == ["k=2", "k=3"]


def test_what_runs_remark_is_told_once(program, tmp_path, capsys):
    words = sweep_words(program, tmp_path, "remark=a,a+b,c+d,e+f+g", "other=1,2")
    for _ in range(2):  # the second time no run is left to do
        sweep.main(words)
        messages = capsys.readouterr().err.splitlines()
        assert messages[0] == "note: 4 of 8 runs: remark a" and messages[1] == "note: 2 of 8 runs: remark b"
        assert len(messages) == 6 and messages[5] == "note: and 2 other remarks"
    sweep.main(sweep_words(program, tmp_path, "other=1,2"))
    assert capsys.readouterr().err == ""


def test_sweep_goes_on_after_failures_and_says_so(program, tmp_path):
    with pytest.raises(InputError, match="1 of 2 runs failed.*fail: 1 is not allowed: 0"):
        sweep.main(sweep_words(program, tmp_path, "fail=0,1"))
    assert len((tmp_path / "out" / "sweep.csv").read_text().splitlines()) == 2
    with pytest.raises(InputError, match="all 1 runs failed"):
        sweep.main(sweep_words(program, tmp_path, "fail=1"))


def test_interrupted_sweep_keeps_what_is_done_and_only_that(program, tmp_path):
    words = sweep_words(program, tmp_path, "sleep=0,0.01,60,61")
    process = subprocess.Popen(
        [sys.executable, os.path.join(SCRIPTS, "sweep"), *words],
        stderr=subprocess.PIPE,
        # Whoever was started in the background of a script ignores it, and so do its children.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
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
