"""evaluate_places on a short drive through the town: what it counts, and what it refuses."""

import os
import shutil
import subprocess
import types

import numpy as np
import pytest

from conftest import built
from ratslam_tools.cli import evaluate_places
from ratslam_tools.evaluation import places

CONFIG = "template_x_size: 30\ntemplate_y_size: 10\nvt_shift_match: 2\nvt_descriptor: orientation\nvt_recall: belief\n"
FRAMES = 24


@pytest.fixture(scope="module")
def town(tmp_path_factory):
    """A folder with a drive as KITTI sequence town/, its images alone in plain/, as a bag, and a configuration."""
    folder = tmp_path_factory.mktemp("places")
    program = built("ratslam_town", "ratslam_places")[1]
    for name in ("town", "town.bag"):
        words = [program, "--out", folder / name, "--frames", str(FRAMES), "--size", "160x60", "--jpeg-quality", "85"]
        subprocess.run(list(map(str, words)), check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    shutil.copytree(folder / "town" / "image_0", folder / "plain")
    (folder / "my.yaml").write_text(CONFIG)
    return folder


def call(run, town, *words):
    return run("evaluate_places", *words, "--config", "my.yaml", cwd=town)


@pytest.mark.parametrize("first", ["town", "plain", "town.bag"])
def test_images_of_the_first_pass_are_counted_whatever_its_kind(run, town, first):
    done = call(run, town, first, "plain", "--open")
    assert done.returncode == 0, done.stderr
    assert f"frames that revisit a place: {FRAMES}\n" in done.stdout


def test_two_passes_and_one_with_truth_are_judged(run, town):
    done = call(run, town, "town", "plain", "--plot", "curve.png", "--csv", "answers.csv")
    assert done.returncode == 0 and f"questions with a right place: {FRAMES} of {FRAMES}\n" in done.stdout, done.stderr
    assert (town / "curve.png").exists() and len((town / "answers.csv").read_text().splitlines()) == FRAMES + 1
    for words in (("--min-gap", "2", "--radius", "4"), ("--min-gap", "10", "--open")):
        done = call(run, town, "town", "--truth", "town/poses.txt", *words)
        assert done.returncode == 0, done.stderr
    asked = ("--min-gap", "2", "--radius", "4")
    of_bag, of_file = (call(run, town, "town.bag", "--truth", name, *asked) for name in ("town.bag", "town/poses.txt"))
    assert of_bag.returncode == 0 and of_bag.stdout == of_file.stdout, of_bag.stderr
    done = call(run, town, "town", "plain", "--starts", "2")
    assert done.returncode == 0 and "starts: 2" in done.stdout, done.stderr


@pytest.mark.parametrize(
    "words, complaint",
    [
        (("town", "plain", "--tolerance", "-1"), "--tolerance: -1 is not allowed: at least 0"),
        (("town", "plain", "--starts", "-3"), "--starts: -3 is not allowed: at least 1"),
        (("town", "plain", "--starts", "25"), "--starts: 25 is not allowed: plain has 24 images"),
        (("town", "plain", "--starts", "0"), "--starts: 0 is not allowed: at least 1"),
        (("town", "--starts", "3", "--truth", "town/poses.txt"), "--starts: it needs a second pass"),
        (("town", "plain", "--open", "--starts", "3"), "has no effect with --open"),
        (("town", "--truth", "town/poses.txt", "--min-gap", "-5"), "--min-gap: -5 is not allowed: at least 1"),
        (("town", "--truth", "town/poses.txt", "--radius", "-1"), "--radius: -1 is not allowed: above 0 m"),
        (("town",), "one recording needs --truth"),
        (("town", "--open"), "one recording needs --truth"),
        (("town", "plain", "--truth", "town/poses.txt"), "--truth: town/poses.txt has no effect"),
        (("town", "--truth", "nothing.txt"), "nothing.txt: cannot be read"),
        (("town", "--truth", "town/times.txt"), "KITTI poses have 12"),
        (("town", "--truth", "short.txt", "--min-gap", "10"), "short.txt: 10 poses for 24 images"),
        (("town.bag", "--truth", "long.txt"), "long.txt: 25 poses for 24 images of town.bag: which pose is whose is not clear"),
        (("town", "--truth", "nan.txt"), "nan.txt:2: a NaN or infinite value"),
        (("town", "plain", "--min-gap", "5"), "--min-gap: 5 has no effect"),
        (("town", "plain", "--starts", "5", "--min-gap", "5"), "--min-gap: 5 has no effect"),
        (("town", "plain", "--open", "--min-gap", "5"), "--min-gap: 5 has no effect"),
        (("town", "plain", "--radius", "5"), "--radius: 5 has no effect"),
        (("town", "plain", "--radius", "5", "--open"), "--radius: 5 has no effect"),
        (("town", "--truth", "town/poses.txt", "--tolerance", "3"), "--tolerance: 3 has no effect"),
        (("town", "--truth", "town/poses.txt", "--open", "--tolerance", "1"), "--tolerance: 1 has no effect"),
        (("town", "plain", "--plot", "x.png", "--open"), "--plot: with --open and --starts there is no curve"),
        (("town", "--truth", "town/poses.txt", "--csv", "town/poses.txt"), "--csv: town/poses.txt is read as well"),
        (("town", "plain", "--csv", "x.png", "--plot", "x.png"), "--plot: x.png is written as well"),
        (("town", "plain", "--recall", "belief", "--set", "vt_recall=nearest"), "--set: 'vt_recall=nearest' is not allowed"),
        (("town", "plain", "--csv", "plain/000003.jpg"), "--csv: plain/000003.jpg is read as well"),
        (("town", "plain", "--plot", "town/image_0/000003.jpg"), "--plot: town/image_0/000003.jpg is read as well"),
        (("town", "plain", "--csv", "town/times.txt"), "--csv: town/times.txt is read as well"),
    ],
)
def test_what_makes_no_sense_is_refused_before_anything_runs(run, town, words, complaint):
    poses = (town / "town" / "poses.txt").read_text()
    lines = poses.splitlines(True)
    (town / "short.txt").write_text("".join(lines[:10]))
    (town / "long.txt").write_text("".join([*lines, lines[-1]]))
    (town / "nan.txt").write_text("".join([lines[0], " ".join(["nan", *lines[1].split()[1:]]) + "\n", *lines[2:]]))
    times = (town / "town" / "times.txt").read_text()
    done = call(run, town, *words)
    assert done.returncode == 1 and complaint in done.stderr and done.stderr.count("\n") == 1, done.stdout + done.stderr
    assert (town / "town" / "poses.txt").read_text() == poses and (town / "town" / "times.txt").read_text() == times


def copy_of(folder, source, keep):
    """A pass with those of the images whose number in order `keep` accepts."""
    folder.mkdir()
    for number, name in enumerate(sorted(os.listdir(source))):
        if keep(number):
            shutil.copy(source / name, folder)
    return folder


@pytest.mark.parametrize(
    "words, asked",
    [((), "questions with a right place: 11 of 24"), (("--tolerance", "3"), "questions with a right place: 13 of 24")]
    + [(("--open",), "frames that revisit a place: 11\n")],
)
def test_images_beyond_the_first_pass_have_no_right_place(run, town, tmp_path, words, asked):
    short = copy_of(tmp_path / "short", town / "plain", lambda number: number < 10)
    done = call(run, town, short, "plain", *words)
    assert done.returncode == 0 and asked in done.stdout, done.stdout + done.stderr
    assert f"{short} has 10 images and plain 24" in done.stderr and done.stderr.count("\n") == 1
    done = call(run, town, "plain", short)
    assert "questions with a right place: 10 of 10" in done.stdout and "plain has 24 images" in done.stderr


def test_of_two_short_passes_the_second_ones_recalls_count(run, town, tmp_path):
    """However few images lie between; a robot that stands still at a new place recalls nothing."""
    standing = copy_of(tmp_path / "standing", town / "plain", lambda number: number < 10)
    done = call(run, town, standing, standing, "--open", "--recall", "nearest", "--set", "vt_match_threshold=0.01")
    assert done.returncode == 0 and "recalls: 10, of these right: 10 (100.0 %)\n" in done.stdout, done.stdout + done.stderr
    assert "revisiting frames recalled: 100.0 %\n" in done.stdout and "recalls where nothing is revisited: 0\n" in done.stdout
    last = sorted(os.listdir(town / "plain"))[-1]
    for number in range(5):
        shutil.copy(town / "plain" / last, tmp_path / "standing" / f"z{number}.jpg")
    done = call(run, town, copy_of(tmp_path / "moving", town / "plain", lambda number: number < 15),
                standing, "--open", "--recall", "nearest", "--set", "vt_match_threshold=0.01")
    assert "recalls: 10, of these right: 10 (100.0 %)\n" in done.stdout, done.stdout + done.stderr


def test_starts_that_claim_nothing_are_a_result(run, town, tmp_path):
    one = copy_of(tmp_path / "one", town / "plain", lambda number: number == 0)
    done = call(run, town, one, "plain", "--starts", "2")
    assert done.returncode == 0 and "starts: 2, places claimed: 0" in done.stdout, done.stdout + done.stderr
    assert "nan" not in done.stdout and "Warning" not in done.stderr


def test_without_any_right_place_there_are_no_figures(run, town):
    done = call(run, town, "town", "--truth", "town/poses.txt", "--min-gap", "23", "--radius", "0.01")
    assert done.returncode == 1 and "none of its 24 images has a right place" in done.stderr, done.stderr
    assert "right at rank 1:              -\n" in done.stdout and "0.0 %" not in done.stdout
    done = call(run, town, "town", "--truth", "town/poses.txt", "--min-gap", "23", "--radius", "0.01", "--open")
    assert done.returncode == 0 and "frames that revisit a place: 0\n" in done.stdout, done.stderr


@pytest.mark.parametrize("whole_times", [True, False])
def test_an_image_has_the_pose_of_its_number_where_images_are_missing(run, town, tmp_path, whole_times):
    gone = {5, 6, 11}
    shutil.copytree(town / "town", tmp_path / "town")
    images = sorted((tmp_path / "town" / "image_0").iterdir())
    for number in gone:
        images[number].unlink()
    kept = [number for number in range(FRAMES) if number not in gone]
    times, poses = (tmp_path / "town" / name for name in ("times.txt", "poses.txt"))
    if not whole_times:
        times.write_text("".join(times.read_text().splitlines(True)[number] for number in kept))
    words = ("--min-gap", "3", "--radius", "2.5")
    by_number = call(run, town, tmp_path / "town", "--truth", poses, *words)
    assert by_number.returncode == 0, by_number.stderr
    assert f"{poses}: 24 poses for 21 images: each image takes the pose of the number in its name" in by_number.stderr
    poses.write_text("".join(poses.read_text().splitlines(True)[number] for number in kept))
    in_order = call(run, town, tmp_path / "town", "--truth", poses, *words)
    assert in_order.stdout == by_number.stdout


def test_pictures_have_an_ending_of_pictures(run, town):
    for name in ("x.foo", "plain"):
        done = call(run, town, "town", "plain", "--plot", name)
        assert done.returncode == 2 and "Traceback" not in done.stderr
    assert not os.path.exists(town / "x.foo")


@pytest.mark.parametrize(
    "words, complaint",
    [
        (("town", "plain", "--starts", "-3"), "--starts: value -3 is not allowed: it must be 1 or above"),
        (("town", "--min-gap", "-5"), "--min-gap: value -5 is not allowed: it must be 1 or above"),
        (("town", "plain", "--min-gap", "5"), "--min-gap: it has no effect with two passes"),
        (("town", "--starts", "5", "--min-gap", "5"), "--starts: it needs a second pass"),
        (("nowhere", "plain"), "nowhere"),
    ],
)
def test_the_program_behind_it_refuses_the_same_and_leaves_the_file_as_it_was(town, tmp_path, words, complaint):
    out = tmp_path / "recalls.csv"
    out.write_text("an earlier result\n")
    program = os.path.join(os.path.dirname(built("ratslam_town")[1]), "ratslam_places")
    done = subprocess.run([program, *words, "--config", "my.yaml", "--out", out], cwd=town, capture_output=True, text=True, timeout=60)
    assert done.returncode == 1 and complaint in done.stderr and done.stderr.count("\n") == 1, done.stderr
    assert out.read_text() == "an earlier result\n" and os.listdir(tmp_path) == ["recalls.csv"]


@pytest.mark.parametrize("damaged", ["ref", "query"])
def test_an_image_that_cannot_be_read_keeps_its_place_and_has_no_answer(run, town, tmp_path, damaged):
    passes = {name: tmp_path / name for name in ("ref", "query")}
    for folder in passes.values():
        shutil.copytree(town / "plain", folder)
    victim = sorted(os.listdir(passes[damaged]))[10]
    (passes[damaged] / victim).write_bytes(b"\xff\xd8\xff not an image")
    for words in ((), ("--open",)):
        answers = tmp_path / "answers.csv"
        done = call(run, town, passes["ref"], passes["query"], "--csv", answers, *words)
        assert done.returncode == 0, done.stderr
        assert f"{passes[damaged]}: {FRAMES - 1} of {FRAMES} images used (1 unreadable)" in done.stderr
        assert victim in done.stderr and done.stderr.count("\n") == 1
    call(run, town, passes["ref"], passes["query"], "--csv", answers)
    rows = [row.split(",") for row in answers.read_text().splitlines()[1:]]
    assert [int(row[0]) for row in rows] == list(range(FRAMES))
    if damaged == "query":
        assert rows[10][1:] == ["-1", "-inf", "0"]
    else:
        assert all(int(row[1]) != 10 for row in rows)
    right = sum(abs(int(row[1]) - int(row[0])) <= 1 for row in rows if int(row[1]) >= 0)
    assert right >= FRAMES - 4, rows


def test_a_pass_without_a_usable_image_is_refused(run, town, tmp_path):
    (tmp_path / "a.png").write_bytes(b"nothing")
    done = call(run, town, tmp_path, "plain")
    assert done.returncode == 1 and "no image was used" in done.stderr and "a.png" in done.stderr
    assert done.stderr.count("\n") == 1


def test_sixteen_bits_of_which_few_are_used_are_seen_as_eight_are(run, town, tmp_path):
    cv2 = pytest.importorskip("cv2")
    deep = tmp_path / "deep"
    deep.mkdir()
    for name in sorted(os.listdir(town / "plain")):
        grey = cv2.imread(str(town / "plain" / name), cv2.IMREAD_GRAYSCALE)
        colours = cv2.merge([grey.astype("uint16") * 16] * 3)
        cv2.imwrite(str(deep / name.replace(".jpg", ".png")), colours)
    done = call(run, town, "plain", deep)
    assert done.returncode == 0, done.stderr
    assert "right at rank 1:              100.0 %" in done.stdout, done.stdout


def told_open(capsys, frame, place, until, positions, headings=None):
    """What --open --truth reports of recalls in these frames, as numbers by name."""
    answers = places.Answers(frame, place, np.full(len(frame), 0.1), frame > place)
    poses = (positions, np.zeros(len(frame)) if headings is None else headings)
    evaluate_places._report_open(types.SimpleNamespace(min_gap=100, radius=3.0, tolerance=1), answers, until, poses, 0)
    lines = (line.partition(": ") for line in capsys.readouterr().out.splitlines())
    return {name: told for name, _, told in lines}


def test_who_stands_still_recalls_and_revisits_nothing(capsys):
    frame = np.arange(300)
    place = np.minimum(frame, 49)  # the last place that was learned stays the active one
    told = told_open(capsys, frame, place, frame, np.column_stack([place * 1.0, 0.0 * frame]))
    assert told["frames that revisit a place"] == "0" and told["recalls"].startswith("0,")
    assert told["recalls where nothing is revisited"] == "0"


def test_laps_are_revisits_and_so_are_their_recalls(capsys):
    """Two laps of 150 frames, with a stop of 120 frames in the first one."""
    way = np.concatenate([np.arange(80), np.full(120, 80), np.arange(80, 150), np.arange(150)])
    frame, angle = np.arange(len(way)), way * 2.0 * np.pi / 150
    learned = np.unique(way, return_index=True)[1]
    last = np.array([np.flatnonzero(way[:270] == step)[-1] for step in range(150)])
    until = np.where(frame < 270, frame, last[way])
    positions = 50.0 * np.column_stack([np.cos(angle), np.sin(angle)])
    told = told_open(capsys, frame, learned[way], until, positions, angle)
    # The first lap ends where it began: two metres a frame, so its last frame is near its first.
    assert told["frames that revisit a place"] == "151"
    assert told["recalls"] == "150, of these right: 150 (100.0 %)"
    assert told["revisiting frames recalled"] == "99.3 %" and told["recalls where nothing is revisited"] == "0"
