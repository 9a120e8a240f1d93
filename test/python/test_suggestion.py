"""Parameters proposed for a recording, and the table of records, with a stand-in for ratslam_run."""

import math
import os
import re
import subprocess
import types

import cv2
import numpy as np
import pytest

from conftest import SOURCE, built
from ratslam_tools.cli import reproduce_paper, reproduce_records, suggest_parameters
from ratslam_tools.datasets import flat_yaml, image_message
from ratslam_tools.errors import InputError
from ratslam_tools.runs import run_folder, runner, suggestion
from ratslam_tools.trajectory import frames, write_kitti


def scene(bonnet=0, sky=0, count=20, shape=(100, 200)):
    """Images of a textured scene that moves, above a bonnet that does not and below a sky without texture."""
    random = np.random.RandomState(3)
    world = random.randint(0, 256, (shape[0], 2 * shape[1])).astype(np.uint8)
    hood = random.randint(0, 256, (shape[0], shape[1])).astype(np.uint8)
    sampled = []
    for index in range(count):
        image = world[:, 5 * index : 5 * index + shape[1]].copy()
        image[:sky] = 200 + index  # gets brighter, shows nothing
        if bonnet:
            image[-bonnet:] = hood[-bonnet:]
        sampled.append(image)
    return sampled


def test_bonnet_and_sky_are_cut_and_nothing_else():
    assert suggestion.crop(scene()) == {}
    settings = suggestion.crop(scene(bonnet=20, sky=30))
    assert settings == {"image_crop_y_min": "30", "image_crop_y_max": "80"}
    dark = [np.zeros((50, 60), np.uint8)] * 5
    most = suggestion.crop(dark)
    assert all(0 < int(value) < 60 for value in most.values()), "never the whole image"


@pytest.mark.parametrize("speed, wanted", [(8.0, 2.0), (0.06, 0.015), (-8.0, 2.0)])
def test_a_cell_is_crossed_in_a_few_frames(speed, wanted):
    speeds = np.where(np.arange(100) < 30, 0.0, speed)
    assert suggestion.cell_size(0.1 * np.arange(100), speeds) == pytest.approx(wanted)


def test_no_scale_without_motion():
    with pytest.raises(InputError, match="nothing moves"):
        suggestion.cell_size(np.arange(5.0), np.zeros(5))


def laps_of(lap, followed, summary=None):
    """Two laps of `lap` frames with the same views; in the second the map is at places of the first in the last frames of a loop."""
    ids = np.tile(np.arange(lap), 2)
    places = np.concatenate([np.arange(lap), np.where(np.arange(lap) < lap - followed, lap, 0) + np.arange(lap)])
    actions = {"stamp": 0.1 * np.arange(2 * lap), "action": np.ones(2 * lap), "dest_id": places}
    templates = {"stamp": 0.1 * np.arange(2 * lap), "template_id": ids}
    return types.SimpleNamespace(summary=summary or {}, templates=templates, actions=actions)


@pytest.mark.parametrize("words, value", [(["--a", "1"], "1"), (["--a=2"], "2"), (["--ab", "3"], None), (["--a"], None)])
def test_options_that_are_passed_on_are_found(words, value):
    assert runner.option(words, "--a") == value


@pytest.mark.parametrize("key", ["pc_cell_x_size", "pc_vt_inject_energy", "image_crop_y_min"])
def test_a_key_that_is_searched_cannot_be_set_as_well(tmp_path, key):
    words = ["drive.bag", "--config", "c.yaml", "--out", str(tmp_path / "out"), "--", "--set", f"{key}=3"]
    with pytest.raises(InputError, match=f"^--set: '{key}=3' is not allowed: {key} gets its values from this command"):
        suggest_parameters.main(words)
    assert not (tmp_path / "out").exists()


def test_a_threshold_that_is_searched_cannot_be_set_as_well():
    """Which threshold decides shows only in the first run."""
    passed_on = ["--set", "vt_match_threshold=0.5"]
    assert runner.command("p", "in", "c", "out", {"pc_cell_x_size": "2"}, more=passed_on)[-2:] == passed_on
    with pytest.raises(InputError, match="^--set: 'vt_match_threshold=0.5' is not allowed"):
        runner.command("p", "in", "c", "out", {"vt_match_threshold": "0.1"}, more=passed_on)


def test_trials_and_records_do_not_lie_in_the_recordings_own_folder(tmp_path):
    for main, more in (
        (suggest_parameters.main, ["--config", "c.yaml"]),
        (reproduce_records.main, []),
        (reproduce_paper.main, []),
    ):
        with pytest.raises(InputError, match="^--out: '.*' is not allowed: it must be another folder than the recording's own"):
            main([str(tmp_path), "--out", f"{tmp_path}/.", *more])
    assert not os.listdir(tmp_path)


@pytest.mark.parametrize(
    "words, complaint",
    [
        (["--skip_sweeps", "--inject_energy", "1,2"], "--inject_energy: 1,2 has no effect"),
        (["--skip_sweeps", "--sweep_systems", "orb"], "--sweep_systems: .* has no effect"),
        (["--skip_sweeps", "--jobs", "2"], "--jobs: 2 has no effect"),
        (["--jobs", "0"], "--jobs: 0 is not allowed: at least 1"),
        (["--inject_energy", "1,x"], "--inject_energy: 'x' is not a number"),
        (["--cell_size", "1,1"], "--cell_size: '1,1' is not allowed: distinct values"),
    ],
)
def test_sweeps_of_the_paper_are_judged_before_anything_runs(tmp_path, words, complaint):
    with pytest.raises(InputError, match="^" + complaint):
        reproduce_paper.main([str(tmp_path), "--out", str(tmp_path / "out"), *words])


@pytest.fixture
def sequence(tmp_path):
    """A KITTI sequence whose images have their number in a corner; those of image_2 are brighter by 100."""
    for name, more in (("image_0", 0), ("image_2", 100)):
        (tmp_path / "seq" / name).mkdir(parents=True)
        for number in range(30):
            image = np.full((4, 6), more, np.uint8)
            image[0, 0] += number
            cv2.imwrite(str(tmp_path / "seq" / name / f"{number:06d}.png"), image)
    return tmp_path / "seq"


def sampled_corners(source, *words):
    view = suggestion.View.of_options(words)
    return [int(image.max()) for image in suggestion.sample_images(str(source), 12, count=4, view=view)]


@pytest.mark.parametrize(
    "words, seen",
    [
        ([], [0, 3, 6, 9]),
        (["--image-folder", "image_2"], [100, 103, 106, 109]),
        (["--image-f=image_2", "--from-frame", "10"], [110, 113, 116, 119]),
        (["--from", "26"], [26, 27, 28, 29]),
        (["--from-frame", "many"], [0, 3, 6, 9]),
    ],
)
def test_the_images_are_those_that_runs_see(sequence, words, seen):
    assert sampled_corners(sequence, *words) == seen


def test_images_behind_the_end_are_refused(sequence):
    with pytest.raises(InputError, match="^--from-frame: 30 is not allowed: .*seq has 30 images, counted from 0"):
        sampled_corners(sequence, "--from-frame", "30")
    with pytest.raises(InputError, match="image_7: no such folder"):
        sampled_corners(sequence, "--image-folder", "image_7")


@pytest.mark.parametrize("words", [["--rotate", "90"], ["--rot", "90"], ["--r=90"]])
def test_images_are_turned_as_a_run_turns_them(sequence, words):
    view = suggestion.View.of_options(words)
    assert suggestion.sample_images(str(sequence), 2, view=view)[1].shape == (6, 4)
    assert suggestion.sample_images(str(sequence), 2, view=view)[1][0, 3] == 1, "the upper left corner comes to the right"


def test_unreadable_images_are_left_out(sequence):
    (sequence / "image_0" / "000003.png").write_bytes(b"cut off")
    assert sampled_corners(sequence) == [0, 6, 9]
    for path in (sequence / "image_0").iterdir():
        path.write_bytes(b"cut off")
    with pytest.raises(InputError, match="seq: no image can be read; the first: .*000000.png: not a readable image"):
        sampled_corners(sequence)


def test_images_of_a_phone_come_in_order_of_time_whatever_its_sensors_say(tmp_path):
    (tmp_path / "images").mkdir()
    for number, name in ((1, "9"), (2, "10"), (3, "8")):
        cv2.imwrite(str(tmp_path / "images" / f"{name}.png"), np.full((4, 6), number, np.uint8))
    lines = "".join(f"160000000000{number},images/{name}.png\n" for number, name in ((1, "9"), (2, "10"), (3, "8")))
    (tmp_path / "data_image.txt").write_text(lines)
    (tmp_path / "data_imu.txt").write_text("1600000000000,0,0,9,8,0,0,0,0,0\n")
    assert sampled_corners(tmp_path) == [1, 2, 3]


def test_the_images_of_a_bag_are_those_of_the_topic_that_is_named(tmp_path):
    rosbag = pytest.importorskip("rosbag")
    from sensor_msgs.msg import Image

    with rosbag.Bag(str(tmp_path / "two.bag"), "w") as bag:
        for name, grey in (("/back", 10), ("/front", 200)):
            bag.write(name, Image(height=4, width=5, step=5, encoding="mono8", data=bytes([grey] * 20)))
    for words, grey in (([], 10), (["--image-t", "/front"], 200)):
        assert sampled_corners(tmp_path / "two.bag", *words) == [grey]
    with pytest.raises(InputError, match="no topic of images /left, but /back, /front"):
        sampled_corners(tmp_path / "two.bag", "--image-topic", "/left")


def test_a_bag_is_seen_from_the_frame_on_that_a_run_begins_with(tmp_path):
    rosbag = pytest.importorskip("rosbag")
    from sensor_msgs.msg import Image

    with rosbag.Bag(str(tmp_path / "one.bag"), "w") as bag:
        for grey in range(30):
            bag.write("/front", Image(height=4, width=5, step=5, encoding="mono8", data=bytes([grey] * 20)))
    assert sampled_corners(tmp_path / "one.bag", "--from-frame", "10") == [10, 13, 16, 19]
    assert sampled_corners(tmp_path / "one.bag", "--from-frame", "26") == [26, 27, 28, 29]
    with pytest.raises(InputError, match="^--from-frame: 30 is not allowed: .*one.bag has 30 images, counted from 0"):
        sampled_corners(tmp_path / "one.bag", "--from-frame", "30")


@pytest.mark.parametrize(
    "encoding, size, pixel, grey",
    [
        ("mono8", 1, [77], 77),
        ("8UC1", 1, [77], 77),
        ("mono16", 2, [1, 77], 77 * 256 + 1),
        ("rgb8", 3, [255, 0, 0], 76),
        ("bgr8", 3, [255, 0, 0], 29),
        ("rgba8", 4, [255, 0, 0, 9], 76),
        ("bgra8", 4, [255, 0, 0, 9], 29),
        ("8UC4", 4, [255, 0, 0, 9], 29),
        ("yuv422", 2, [128, 77], 77),
        ("yuv422_yuy2", 2, [77, 128], 77),
    ],
)
def test_an_image_message_is_read_as_its_encoding_says(encoding, size, pixel, grey):
    """Red is 76 and blue 29 of 255 in grey (ITU-R BT.601)."""
    row = pixel * 6 + [0] * 3  # rows may be longer than their pixels
    message = types.SimpleNamespace(encoding=encoding, height=4, width=6, step=6 * size + 3, data=bytes(row * 4), is_bigendian=0)
    image = image_message.grey(message)
    assert image.shape == (4, 6) and image.dtype == (np.uint16 if encoding == "mono16" else np.uint8)
    assert (image == grey).all()
    message.is_bigendian = 1
    assert (image_message.grey(message) == (256 + 77 if encoding == "mono16" else grey)).all()
    message.data = message.data[:-3]  # the last row ends with its pixels
    assert image_message.grey(message).shape == (4, 6)
    message.data = message.data[:-1]
    with pytest.raises(ValueError, match="bytes do not hold 6x4 pixels of"):
        image_message.grey(message)


@pytest.mark.parametrize("pattern, red, blue", [("rggb", 0, 3), ("bggr", 3, 0), ("grbg", 1, 2), ("gbrg", 2, 1)])
def test_a_bayer_pattern_has_its_colours_where_it_says(pattern, red, blue):
    def seen(lit):
        block = [255 if place == lit else 0 for place in range(4)]
        rows = [(block[:2] * 8, block[2:] * 8)[row % 2] for row in range(16)]
        message = types.SimpleNamespace(encoding=f"bayer_{pattern}8", height=16, width=16, step=16, data=bytes(sum(rows, [])), is_bigendian=0)
        return image_message.grey(message)[4:12, 4:12].mean()

    assert abs(seen(red) - 76) < 3 and abs(seen(blue) - 29) < 3


@pytest.mark.parametrize("encoding, red", [("rgb16", 0), ("bgr16", 2), ("bayer_rggb16", 0), ("bayer_bggr16", 3)])
@pytest.mark.parametrize("order", ["<u2", ">u2"])
def test_colours_of_16_bits_become_grey_of_16_bits(encoding, red, order):
    values = np.zeros((16, 16) if "bayer" in encoding else (16, 16, 3))
    lit = (slice(red // 2, None, 2), slice(red % 2, None, 2)) if "bayer" in encoding else (..., red)
    values[lit] = 1000
    data = values.astype(order).tobytes()
    big = order == ">u2"
    message = types.SimpleNamespace(encoding=encoding, height=16, width=16, step=len(data) // 16, data=data, is_bigendian=big)
    image = image_message.grey(message)
    assert image.dtype == np.uint16 and abs(image[4:12, 4:12].mean() - 299) < 2


def test_every_encoding_that_runs_take_is_known():
    with open(os.path.join(SOURCE, "src", "ratslam", "camera", "image_decoding.cpp"), encoding="utf-8") as file:
        taken = re.findall(r'\{"(\w+)", CV_', file.read())
    assert len(taken) == 22
    for encoding in taken:
        image_message.grey(types.SimpleNamespace(encoding=encoding, height=4, width=4, step=32, data=bytes(128), is_bigendian=0))


def test_an_unknown_encoding_is_named():
    with pytest.raises(ValueError, match="encoding 'jet' is none of mono8, 8UC1"):
        image_message.grey(types.SimpleNamespace(encoding="jet"))


def stand_in(critical, closes_at=0.2):
    """Runs whose ratio of experiences to templates rises with the threshold and passes 1.5 at `critical`."""

    def runs(settings):
        threshold = float(settings.get("vt_match_threshold", 0.03))
        ratio = 1.0 + 0.5 * (threshold / critical) ** 2
        counts = {"experiences": 1000 * ratio, "templates": 1000}
        closes = float(settings.get("pc_vt_inject_energy", 0)) >= closes_at
        return laps_of(100, 100 if closes else 0, summary={"counts": counts})

    return runs


@pytest.mark.parametrize("critical", [0.01, 0.05, 0.2])
def test_the_threshold_brings_the_ratio_where_it_is_wanted(critical):
    value, ratio = suggestion.threshold(stand_in(critical), {}, "vt_match_threshold")
    assert suggestion.RATIO[0] <= ratio <= suggestion.RATIO[1]
    assert abs(math.log(float(value) / critical)) < 0.6


@pytest.mark.parametrize(
    "descriptor, recall, key",
    [
        ("blocks", "nearest", "vt_match_threshold"),
        ("orientation", "nearest", "vt_orientation_threshold"),
        ("orientation", "belief", None),
    ],
)
def test_the_threshold_is_that_of_what_recalls(descriptor, recall, key):
    run = types.SimpleNamespace(summary={"parameters": {"vt_descriptor": descriptor, "vt_recall": recall}})
    assert suggestion.threshold_key(run) == key


@pytest.mark.parametrize("descriptor, key", [("blocks", "vt_match_threshold"), ("orientation", "vt_orientation_threshold")])
def test_with_belief_a_threshold_decides_what_is_learned(tmp_path, descriptor, key):
    """As docs/tuning.md says: with 0 every view is a new place, with a wide one hardly any."""
    run, town = built("ratslam_town")
    subprocess.run([town, "--out", tmp_path / "town", "--frames", "12", "--size", "310x94"], check=True, stdout=subprocess.DEVNULL)
    counts = []
    for value in ("0", "1"):
        settings = {"template_x_size": "60", "template_y_size": "10", "vt_shift_match": "5", "vt_descriptor": descriptor}
        settings.update({"vt_recall": "belief", key: value})
        (tmp_path / "c.yaml").write_text("".join(f"{name}: {word}\n" for name, word in settings.items()))
        words = runner.command(run, str(tmp_path / "town"), str(tmp_path / "c.yaml"), str(tmp_path / f"run{value}"))
        runner.Runner().run(words)
        counts.append(run_folder.Run(tmp_path / f"run{value}").summary["counts"]["templates"])
    assert counts[0] == 12 and counts[1] < 6


def test_loops_are_stretches_of_views_that_come_back():
    standing = np.repeat(np.arange(20), 100)
    assert not suggestion.loops_of(standing), "whoever stands still has not come back"
    ids = np.concatenate([np.arange(200), np.arange(10, 40), np.full(5, -1), np.arange(50, 60), np.arange(300, 400), [7, 8]])
    (loop,) = suggestion.loops_of(ids)
    assert list(loop[[0, -1]]) == [200, 244] and len(loop) == 40, "a short hole ends no loop; two frames make none"
    thrice = suggestion.loops_of(np.tile(np.arange(100), 3))
    assert sum(map(len, thrice)) == 200


@pytest.mark.parametrize("frames", [0, 40, 100])
def test_what_is_followed_is_the_share_of_a_loop(frames):
    assert suggestion.followed(laps_of(100, frames)) == pytest.approx(frames / 100)


def test_an_energy_that_closes_loops_late_is_not_enough():
    late = {"0.05": 5, "0.1": 40}
    assert suggestion.injection(lambda settings: laps_of(100, late.get(settings["pc_vt_inject_energy"], 95)), {}) == "0.15"


def test_the_least_energy_that_closes_a_loop():
    assert suggestion.injection(stand_in(0.05), {}) == "0.2"
    assert suggestion.injection(stand_in(0.05, closes_at=9.0), {}) is None


def test_records_of_the_sequences_that_are_there(tmp_path, drive, capsys):
    root = tmp_path / "kitti"
    for name in ("03", "07"):
        (root / "sequences" / name).mkdir(parents=True)
        np.savetxt(root / "sequences" / name / "times.txt", drive().stamps)
        (root / "poses").mkdir(exist_ok=True)
        write_kitti(root / "poses" / f"{name}.txt", frames.convert(drive(), "base", "camera"))
    program = tmp_path / "program"
    program.write_text(
        "#!/bin/sh\nwhile [ $# -gt 1 ]; do [ \"$1\" = --out ] && out=$2; shift; done\n"
        f"for kind in online final odometry; do cp {tmp_path}/truth.tum $out/trajectory_$kind.tum; done\n"
    )
    program.chmod(0o755)
    from ratslam_tools.trajectory import write_tum

    write_tum(tmp_path / "truth.tum", drive())
    out = tmp_path / "out"
    reproduce_records.main([str(root), "--out", str(out), "--ratslam_run", str(program)])
    lines = [line.split() for line in capsys.readouterr().out.splitlines() if line[:2] in ("03", "07")]
    table = [line for line in lines if len(line) > 5]
    assert [line[:2] for line in table] == [["03", "odometry"], ["03", "final"], ["07", "odometry"], ["07", "final"]]
    assert "2.19" in table[3] and "2.19" not in table[2] and "1.19" in table[0]
    assert os.path.isfile(out / "records.json")
    with pytest.raises(InputError, match="neither a sequence"):
        reproduce_records.main([str(tmp_path / "out")])
    for words in (["07", "03"], ["07,03"], ["07,03", "07"]):
        reproduce_records.main([str(root), "--out", str(out), "--ratslam_run", str(program), "--sequences", *words])
        assert [line[:2] for line in capsys.readouterr().out.splitlines() if ": done" in line] == ["07", "03"]
    for main, more in ((reproduce_records.main, []), (reproduce_paper.main, ["--skip_sweeps"])):
        words = [str(root), "--out", str(out), "--ratslam_run", str(program), *more]
        with pytest.raises(InputError, match="^--sequences: 09: no .*sequences/09/times.txt"):
            main([*words, "--sequences", "03,09"])
        with pytest.raises(InputError, match="^--sequences: '03,' is not allowed: names such as 00 02 or 00,02"):
            main([*words, "--sequences", "03,"])


def test_suggestions_are_yaml_with_reasons(tmp_path):
    text = suggest_parameters.lines_of([("Because.", {"pc_cell_x_size": "2"}), ("Nothing.", {})])
    assert text == "# Because.\npc_cell_x_size: 2\n# Nothing.\n"


def test_a_drive_with_our_own_odometry(tmp_path):
    """The odometry that a run leaves has fields without a value; recalls by belief have no threshold to look for."""
    run, town = built("ratslam_town")
    drive = tmp_path / "town"
    subprocess.run([town, "--out", drive, "--frames", "40", "--size", "620x188"], check=True, stdout=subprocess.DEVNULL)
    config = tmp_path / "config.yaml"
    config.write_text("vt_descriptor: orientation\nvt_recall: belief\nexp_scale: true\ncamera_height: 1.65\n")
    wanted = ["--odometry", "orb", "--frames", "40", "--out", tmp_path / "runs", "--yaml", tmp_path / "found.yaml"]
    words = [drive, "--config", config, "--ratslam_run", run, *wanted]
    suggest_parameters.main(list(map(str, words)))
    found = flat_yaml.read(str(tmp_path / "found.yaml"))
    assert 0.5 <= float(found["pc_cell_x_size"]) <= 5.0 and "vt_match_threshold" not in found
    text = (tmp_path / "found.yaml").read_text()
    assert "Threshold: none is suggested, belief decides about recalls" in text and "Injection: no loop closed" in text
