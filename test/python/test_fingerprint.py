"""A run is repeated if one of its inputs has changed, and only then; and the program that runs is the one meant."""

import os
import shutil
import stat

import pytest

from run_fixtures import calls, folder, program  # noqa: F401  (fixtures)
from ratslam_tools.cli import sweep
from ratslam_tools.errors import InputError
from ratslam_tools.runs import fingerprint, runner


@pytest.fixture
def recording(tmp_path):
    """A KITTI sequence, as far as its files go."""
    path = tmp_path / "drive"
    (path / "image_0").mkdir(parents=True)
    for number in range(3):
        (path / "image_0" / f"{number:06d}.png").write_bytes(b"pixels" * (number + 1))
    (path / "times.txt").write_text("0\n0.1\n0.2\n")
    (path / "calib.txt").write_text("P0: 700 0 0 0\n")
    return path


CHANGES = {
    "a calibration of the same length": lambda path: (path / "calib.txt").write_text("P0: 800 0 0 0\n"),
    "times of the same length": lambda path: (path / "times.txt").write_text("0\n0.1\n0.3\n"),
    "an image of another size": lambda path: (path / "image_0" / "000001.png").write_bytes(b"picture"),
    "an image more": lambda path: (path / "image_0" / "000003.png").write_bytes(b""),
    "an image less": lambda path: (path / "image_0" / "000001.png").unlink(),
    "another name": lambda path: (path / "image_0" / "000001.png").rename(path / "image_0" / "000009.png"),
}


@pytest.mark.parametrize("change", list(CHANGES.values()), ids=list(CHANGES))
def test_a_recording_that_has_changed_is_run_anew(program, recording, tmp_path, change):
    out = tmp_path / "out"
    words = [str(recording), "--config", "c.yaml", "--vary", "other=1,2", "--goal", "counts.recalls", "--out", str(out)]
    words += ["--ratslam_run", str(program), "--jobs", "1"]
    (tmp_path / "run" / "summary.json").write_text('{"counts": {"templates": 3}}')
    for _ in range(2):
        sweep.main(words)
        assert len(calls(program)) == 2
    change(recording)
    sweep.main(words)
    assert len(calls(program)) == 4


def test_a_program_made_anew_and_a_file_behind_an_equals_sign_count(program, recording, tmp_path):
    calibration, out = tmp_path / "phone.yaml", str(tmp_path / "out")
    calibration.write_text("camera_fx: 700\n")
    words = [str(program), str(recording), f"--calibration={calibration}", "--out", out]
    for _ in range(2):
        runner.run_once(words, out)
        assert len(calls(program)) == 1
    calibration.write_text("camera_fx: 800\n")
    runner.run_once(words, out)
    assert len(calls(program)) == 2
    program.write_text(program.read_text() + "# another build\n")
    runner.run_once(words, out)
    assert len(calls(program)) == 3


def test_a_copy_with_other_times_of_change_is_the_same(recording, tmp_path):
    words = ["ratslam_run", str(recording), "--out", "out"]
    before = fingerprint.of_command(words)
    assert list(before) == [str(recording)] and before[str(recording)].startswith("5 files of ")
    moved = tmp_path / "moved"
    shutil.copytree(str(recording), str(moved))
    shutil.rmtree(str(recording))
    shutil.copytree(str(moved), str(recording), copy_function=shutil.copyfile)
    for place, _, names in os.walk(str(recording)):
        for name in names:
            os.utime(os.path.join(place, name), (1, 1))
    assert fingerprint.of_command(words) == before


@pytest.mark.parametrize("option", [["--out"], ["--save-map"], ["--save-m"], ["--video"]])
def test_what_a_run_writes_is_none_of_its_inputs(tmp_path, option):
    written = tmp_path / "written"
    written.write_text("by the last run")
    assert fingerprint.of_command(["ratslam_run", "input", *option, str(written)]) == {}
    assert fingerprint.of_command(["ratslam_run", "input", f"{option[0]}={written}"]) == {}
    assert list(fingerprint.of_command(["ratslam_run", "input", "--load-map", str(written), *option, str(written)])) == [str(written)]


def test_results_within_the_recording_are_none_of_its_files(recording):
    words = ["ratslam_run", str(recording), "--out", str(recording / "sweep" / "runs" / "a=1")]
    before = fingerprint.of_command(words)
    (recording / "sweep" / "runs" / "a=2").mkdir(parents=True)
    (recording / "sweep" / "sweep.csv").write_text("a\n")
    (recording / "sweep" / "runs" / "a=2" / "result.json").write_text("{}")
    assert fingerprint.of_command(words) == before


def test_links_that_lead_back_or_nowhere(recording):
    (recording / "again").symlink_to(recording)
    (recording / "gone.txt").symlink_to(recording / "nothing")
    assert fingerprint.of_command(["ratslam_run", str(recording)])[str(recording)].startswith("6 files")


def test_of_a_large_file_both_ends_and_what_lies_between_count(tmp_path, monkeypatch):
    monkeypatch.setattr(fingerprint, "FLEETING_BYTES", 10)
    monkeypatch.setattr(fingerprint, "WHOLE_BYTES", 1000)
    monkeypatch.setattr(fingerprint, "SAMPLES", 10)
    monkeypatch.setattr(fingerprint, "SAMPLE_BYTES", 100)
    path, content, found = tmp_path / "drive.bag", bytearray(1500), set()
    words = ["ratslam_run", str(path)]
    for number, changed in enumerate((0, 800, 1499)):
        content[changed] = 1
        path.write_bytes(content)
        os.utime(str(path), (number, number))
        found.add(fingerprint.of_command(words)[str(path)])
    assert len(found) == 3


def test_the_libraries_of_the_program_count(tmp_path):
    try:
        built = runner.find()
    except InputError as error:
        pytest.skip(str(error))
    names = {os.path.basename(name).split(".")[0] for name in fingerprint.of_command([built, "input"])}
    assert {"ratslam_run", "libratslam"} <= names


def test_the_program_beside_the_scripts_comes_before_one_on_the_path(tmp_path, monkeypatch):
    found = {}
    for name in ("scripts", "path"):
        (tmp_path / name).mkdir()
        found[name] = tmp_path / name / runner.PROGRAM
        found[name].write_text("#!/bin/sh\n")
        found[name].chmod(found[name].stat().st_mode | stat.S_IXUSR)
    monkeypatch.setattr(runner, "SCRIPTS", str(tmp_path / "scripts"))
    monkeypatch.setenv("PATH", f"{tmp_path / 'path'}:{os.environ['PATH']}")
    assert runner.find() == str(found["scripts"])
    found["scripts"].unlink()
    assert runner.find() == str(found["path"])
