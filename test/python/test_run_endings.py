"""How ratslam_run ends: whatever stops it, what was mapped is kept, and no file is ever cut off."""

import os
import re
import resource
import signal
import subprocess
import time

import cv2
import numpy as np
import pytest

from ratslam_tools.errors import InputError
from ratslam_tools.runs import runner

FRAMES = 400
OUTPUTS = {
    "trajectory_online.tum",
    "trajectory_final.tum",
    "trajectory_odometry.tum",
    "odometry.csv",
    "pose_covariance.csv",
    "map.yaml",
    "templates.csv",
    "actions.csv",
    "pose_cells.csv",
    "summary.json",
}


@pytest.fixture(scope="module")
def program():
    try:
        return runner.find()
    except InputError as error:
        pytest.skip(str(error))


def make_sequence(folder, frames, size=(160, 60)):
    """A KITTI sequence of a camera that turns before a wall of random texture."""
    (folder / "image_0").mkdir(parents=True)
    width, height = size
    wall = cv2.GaussianBlur(
        np.random.RandomState(1).randint(0, 256, (height, width + 6 * frames)).astype(np.uint8), (0, 0), 3
    )
    wall = cv2.normalize(wall, None, 0, 255, cv2.NORM_MINMAX)
    for frame in range(frames):
        begin = 6 * frame
        cv2.imwrite(str(folder / "image_0" / f"{frame:06d}.png"), wall[:, begin : begin + width])
    (folder / "times.txt").write_text("".join(f"{frame / 10:.6f}\n" for frame in range(frames)))
    return folder


@pytest.fixture(scope="module")
def sequence(tmp_path_factory):
    return make_sequence(tmp_path_factory.mktemp("sequence") / "long", FRAMES, size=(640, 240))


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    return make_sequence(tmp_path_factory.mktemp("sequence") / "short", 30)


def command(program, recording, out, *more):
    sizes = ("template_x_size=20", "template_y_size=6", "vt_shift_match=2", "pc_cell_x_size=0.5")
    return [program, recording, "--out", out, *(word for size in sizes for word in ("--set", size)), *more]


def run(program, recording, out, *more, **options):
    words = list(map(str, command(program, recording, out, *more)))
    return subprocess.run(
        words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True, check=False, **options
    )


def lines(path):
    return path.read_text().splitlines()


def stopped_in_the_middle(program, sequence, out, signal_number):
    """Sends a signal once a part of the run is over. @return the process, ended, and what it said"""
    process = subprocess.Popen(
        list(map(str, command(program, sequence, out))),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        universal_newlines=True,
    )
    part = out / "templates.csv.part"
    end = time.monotonic() + 60.0
    # The stream's buffer reaches the file in pieces: any piece means that frames have gone by.
    while time.monotonic() < end and process.poll() is None and not (part.exists() and part.stat().st_size > 0):
        time.sleep(0.002)
    if process.poll() is None:
        process.send_signal(signal_number)
    said = process.communicate(timeout=60)[0]
    return process, said


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_a_signal_leaves_what_was_mapped_so_far(program, sequence, tmp_path, name):
    process, said = stopped_in_the_middle(program, sequence, tmp_path / "out", getattr(signal, name))
    if "interrupted" not in said:
        pytest.skip("the run was over before the signal came")
    assert process.returncode == 0, said
    assert set(os.listdir(tmp_path / "out")) == OUTPUTS
    poses = len(lines(tmp_path / "out" / "trajectory_final.tum"))
    assert 0 < poses < FRAMES
    assert len(lines(tmp_path / "out" / "templates.csv")) == poses + 1


def test_a_killed_run_leaves_the_files_of_the_run_before(program, sequence, short, tmp_path):
    out = tmp_path / "out"
    assert run(program, short, out).returncode == 0
    before = {name: (out / name).read_bytes() for name in OUTPUTS}
    process, _ = stopped_in_the_middle(program, sequence, out, signal.SIGKILL)
    if process.returncode == 0:
        pytest.skip("the run was over before the signal came")
    assert {name: (out / name).read_bytes() for name in OUTPUTS} == before
    assert run(program, short, out).returncode == 0, "what the killed run left is no hindrance"
    assert set(os.listdir(out)) == OUTPUTS


def test_a_full_disk_leaves_the_files_of_the_run_before(program, short, sequence, tmp_path):
    out = tmp_path / "out"
    assert run(program, short, out).returncode == 0
    before = {name: (out / name).read_bytes() for name in OUTPUTS}

    def little_space():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (20000, 20000))

    full = run(program, sequence, out, preexec_fn=little_space)
    assert full.returncode == 1
    assert "cannot write this file" in full.stdout
    assert {name: (out / name).read_bytes() for name in OUTPUTS} == before
    assert set(os.listdir(out)) == OUTPUTS


def test_a_video_on_a_full_disk_is_no_success(program, short, tmp_path):
    def little_space():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (100000, 100000))

    video = tmp_path / "run.mp4"
    if "no codec" in run(program, short, tmp_path / "good", "--video", video).stdout:
        pytest.skip("this OpenCV writes no .mp4")
    assert video.exists()
    whole = video.read_bytes()
    full = run(program, short, tmp_path / "out", "--video", video, preexec_fn=little_space)
    assert full.returncode == 1, full.stdout
    assert "run.mp4: cannot write this video" in full.stdout
    assert video.read_bytes() == whole
    assert set(os.listdir(tmp_path / "out")) == OUTPUTS, "the run itself is not lost"


def test_files_that_an_earlier_run_left_do_not_mix_with_the_new_ones(program, short, tmp_path):
    out = tmp_path / "out"
    assert run(program, short, out).returncode == 0
    (out / "notes.txt").write_text("the user's own")
    odometry = tmp_path / "odometry.csv"
    odometry.write_text(
        "frame,stamp,linear_x,angular_z\n" + "".join(f"{i},{i / 10:.6f},1.0,0.0\n" for i in range(30))
    )
    assert run(program, short, out, "--odometry", odometry).returncode == 0
    assert set(os.listdir(out)) == OUTPUTS - {"trajectory_odometry.tum"} | {"notes.txt"}


def test_stamps_of_one_file_rise_where_time_goes_back(program, short, tmp_path):
    looped = tmp_path / "looped"
    looped.mkdir()
    (looped / "image_0").symlink_to(short / "image_0")
    times = (short / "times.txt").read_text().splitlines()
    (looped / "times.txt").write_text("\n".join(times[1:16] + times[1:16]) + "\n")
    out = tmp_path / "out"
    ended = run(program, looped, out)
    assert ended.returncode == 0, ended.stdout
    assert "time went back: the 2 stretches of each trajectory" in ended.stdout
    for name in ("trajectory_online", "trajectory_final", "trajectory_odometry"):
        for part in ("", "_2"):
            stamps = [float(line.split()[0]) for line in lines(out / f"{name}{part}.tum")]
            assert stamps and stamps == sorted(set(stamps)), name + part
    for part in ("", "_2"):
        assert len(lines(out / f"odometry{part}.csv")) == 16
    assert run(program, short, out).returncode == 0
    assert set(os.listdir(out)) == OUTPUTS


def test_what_cannot_be_written_is_said_before_the_first_image(program, sequence, tmp_path):
    (tmp_path / "out" / "summary.json").mkdir(parents=True)
    began = time.monotonic()
    refused = run(program, sequence, tmp_path / "out")
    assert refused.returncode == 1
    assert "summary.json: cannot write this file" in refused.stdout
    (tmp_path / "file").write_text("")
    refused = run(program, sequence, tmp_path / "file")
    assert refused.returncode == 1 and "cannot make this folder" in refused.stdout, refused.stdout
    assert time.monotonic() - began < 30.0


def odometry_file(tmp_path, begin=0.0, period=0.1, speed=1.0):
    """Odometry for 30 images, straight ahead [s, m/s]."""
    path = tmp_path / "odometry.csv"
    rows = "".join(f"{i},{begin + i * period:.6f},{speed},0.0\n" for i in range(30))
    path.write_text("frame,stamp,linear_x,angular_z\n" + rows)
    return path


def test_images_outside_the_odometrys_time_are_said_with_the_offset(program, short, tmp_path):
    odometry = odometry_file(tmp_path, begin=1000.0)
    lost = run(program, short, tmp_path / "out", "--odometry", odometry)
    assert lost.returncode == 1
    assert "30 of 30 images lie outside the odometry's time: it is 1000.0 s ahead" in lost.stdout
    assert "nothing was mapped" in lost.stdout


@pytest.mark.parametrize("period", [0.1, 100.0])
def test_stretches_that_nobody_measured_are_said(program, short, tmp_path, period):
    """As where milliseconds stand where seconds should."""
    odometry = odometry_file(tmp_path, period=period)
    slow = run(program, short, tmp_path / "out", "--odometry", odometry)
    said = "29 stretches between samples of odometry are not measured: they last longer than odometry_gap (2 s)"
    assert slow.returncode == 0, slow.stdout
    assert (said in slow.stdout) == (period > 2.0), slow.stdout


@pytest.mark.parametrize("speed", [0.0, 1.0])
def test_odometry_that_never_moves_is_said(program, short, tmp_path, speed):
    odometry = odometry_file(tmp_path, speed=speed)
    stands = run(program, short, tmp_path / "out", "--odometry", odometry)
    assert stands.returncode == 0, stands.stdout
    assert ("the odometry never moves: all 30 poses lie at one place" in stands.stdout) == (speed == 0.0), stands.stdout


def test_changes_that_the_drive_does_not_reach_are_said(program, short, tmp_path):
    changes = tmp_path / "changes.csv"
    changes.write_text("after_ns,name,value\n1000000000,exp_loops,7\n99000000000,exp_loops,8\n")
    drive = run(program, short, tmp_path / "out", "--changes", changes)
    assert drive.returncode == 0, drive.stdout
    assert "changes.csv:3: exp_loops never changed, because after_ns=99000000000 is not before" in drive.stdout


@pytest.mark.parametrize(
    "words, said",
    [
        (["--from-frame", "30"], "--from-frame: value 30 is not allowed: .* has 30 images, counted from 0"),
        (["--max-frames", "1e3"], r"the argument \('1e3'\) for option '--max-frames' is invalid: it must be a whole"),
        (["second"], "one INPUT at a time; a path with blanks stands in quotes"),
        (["--odometri", "orb"], "unrecognised option '--odometri'; see --help"),
    ],
)
def test_options_that_mean_nothing_are_named(program, short, tmp_path, words, said):
    refused = run(program, short, tmp_path / "out", *words)
    assert refused.returncode == 1 and refused.stdout.count("\n") == 1, refused.stdout
    assert re.search(said, refused.stdout), refused.stdout
    assert not (tmp_path / "out").exists()


def test_a_topic_of_odometry_that_nobody_reads_is_refused(program, tmp_path):
    rosbag = pytest.importorskip("rosbag")
    messages = pytest.importorskip("sensor_msgs.msg")
    with rosbag.Bag(str(tmp_path / "drive.bag"), "w") as bag:
        bag.write("/camera/image", messages.Image(height=60, width=160, encoding="mono8", step=160, data=bytes(9600)))
    refused = run(program, tmp_path / "drive.bag", tmp_path / "out", "--odometry-topic", "/odom")
    assert refused.returncode == 1
    assert "--odometry-topic: value /odom is not allowed: it is for --odometry topic, not profile" in refused.stdout


@pytest.mark.parametrize("name", ["odometry.csv", "map.yaml"])
def test_what_a_run_reads_is_not_replaced_by_what_it_leaves(program, short, tmp_path, name):
    read = tmp_path / "out" / name
    read.parent.mkdir()
    content = {"odometry.csv": "frame,stamp,linear_x,angular_z\n0,0,1,0\n1,9,1,0\n", "map.yaml": "pc_dim_xy: 21\n"}
    read.write_text(content[name])
    option = "--odometry" if name.endswith("csv") else "--config"
    refused = run(program, short, tmp_path / "out", option, read)
    assert refused.returncode == 1 and refused.stdout.count("\n") == 1, refused.stdout
    assert "--out: value" in refused.stdout and name in refused.stdout
    assert os.listdir(read.parent) == [name] and read.read_text() == content[name]


def test_a_recording_is_no_folder_for_results(program, short):
    before = set(os.listdir(short))
    refused = run(program, short, str(short) + "/.")
    assert refused.returncode == 1 and "another folder than the recording's own" in refused.stdout
    assert set(os.listdir(short)) == before


def test_a_missing_configuration_is_said_and_no_riddle(program, short, tmp_path):
    (tmp_path / "empty.yaml").write_text("# nothing\n")
    here = [program, short, "--out", tmp_path / "out"]
    places = [os.path.join(os.path.dirname(program), "ratslam_places"), short, "--open", "--out", tmp_path / "out.csv"]
    for words, said in (
        (here, "--config FILE is missing"),
        (places, "--config FILE is missing"),
        ([*here, "--config", tmp_path / "empty.yaml"], "empty.yaml: it holds no parameter"),
    ):
        refused = subprocess.run(
            list(map(str, words)), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True, check=False
        )
        assert refused.returncode == 1 and said in refused.stdout, refused.stdout
        assert refused.stdout.count("\n") == 1


def test_options_that_would_do_nothing_are_refused(program, short, tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    (tmp_path / "loop").mkdir()
    (tmp_path / "loop" / "image_0").symlink_to("image_0")
    for recording, words, said in (
        (short, ["--load-map", pipe], "no regular file"),
        (short, ["--load-map", tmp_path], "it is a folder"),
        (short, ["--save-map", ""], "--save-map: it is given, but empty"),
        (short, ["--pose-cells-every", "-1"], "--pose-cells-every: value -1"),
        (short, ["--image-topic", "/camera"], "--image-topic /camera is for a bag"),
        (short, ["--odometry-topic", "/odom"], "--odometry-topic /odom is for a bag"),
        (short, ["--calibration", tmp_path], "it is a folder"),
        (short, ["--set", "pc_dim_xy=2\n\x1b[31m" + "9" * 5000], "is not a whole number"),
        (tmp_path / "loop", [], "neither a KITTI sequence"),
    ):
        refused = run(program, recording, tmp_path / "out", *words, timeout=60)
        assert refused.returncode == 1, refused.stdout
        assert said in refused.stdout and refused.stdout.count("\n") == 1, refused.stdout
        assert len(refused.stdout) < 500


def test_pose_cells_at_times_that_the_drive_has_not_are_no_success(program, short, tmp_path):
    late = run(program, short, tmp_path / "out", "--pose-cells-at", "1,1000")
    assert late.returncode == 1
    assert "--pose-cells-at: value 1000: the last decision is 2.9 s after the first; 1 of the 2" in late.stdout
    assert set(os.listdir(tmp_path / "out")) == OUTPUTS, "what there is is written"
    going_on = run(program, short, tmp_path / "out", "--pose-cells-at", "1,1000", "--save-map", tmp_path / "a.map")
    assert going_on.returncode == 0, "the run that goes on may still come to it"


def test_a_run_that_is_refused_leaves_no_trace_of_its_map(program, short, tmp_path):
    (tmp_path / "no.map").write_text("text")
    for words in (["--save-map", tmp_path / "new.map", "--video", "/nowhere/run.mp4"], ["--save-map", tmp_path / "no.map"]):
        refused = run(program, short, tmp_path / "out", *words)
        assert refused.returncode == 1 and refused.stdout.count("\n") == 1, refused.stdout
        assert set(os.listdir(tmp_path)) <= {"no.map", "out"}
    assert run(program, short, tmp_path / "out", "--save-map", tmp_path / "new.map").returncode == 0
    assert set(os.listdir(tmp_path)) == {"no.map", "out", "new.map"}


@pytest.mark.parametrize("name", ["summary.json", "map.yaml.part"])
def test_a_map_that_the_results_would_replace_is_refused(program, short, tmp_path, name):
    refused = run(program, short, tmp_path / "out", "--save-map", tmp_path / "out" / name)
    assert refused.returncode == 1 and refused.stdout.count("\n") == 1, refused.stdout
    assert "its own files would take the place of" in refused.stdout
    assert run(program, short, tmp_path / "out", "--save-map", tmp_path / "out" / "drive.map").returncode == 0
    assert (tmp_path / "out" / "drive.map").exists()
