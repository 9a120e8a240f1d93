"""Tubs of robot cars as they come: records that were deleted, names that lead elsewhere, values that are none."""

import json
import os

import pytest

from conftest import png
from ratslam_tools.cli import donkey_to_kitti
from ratslam_tools.datasets import donkey, kitti
from ratslam_tools.errors import InputError


def tub(folder, count=30, manifest=None, **changes):
    (folder / "images").mkdir(parents=True)
    lines = []
    for index in range(count):
        (folder / "images" / f"{index}.jpg").write_bytes(png(160, 120))
        record = {"_index": index, "_timestamp_ms": 1000 + 50 * index, "user/angle": 0.1, "user/throttle": 0.2}
        lines.append(json.dumps({**record, "cam/image_array": f"{index}.jpg", **changes}))
    (folder / "catalog_0.catalog").write_text("\n".join(lines))
    if manifest is not None:
        (folder / "manifest.json").write_text(manifest)


def test_deleted_records_of_a_tub_are_left_out(tmp_path, capsys):
    manifest = '["cam/image_array"]\n["image_array"]\n{}\n{"deleted_indexes": [10, 11, 29]}\n'
    tub(tmp_path / "tub", manifest=manifest)
    donkey_to_kitti.main([str(tmp_path / "tub"), str(tmp_path / "out")])
    assert len(os.listdir(tmp_path / "out" / "image_0")) == 27
    assert "left out: 3" in capsys.readouterr().out
    assert kitti.read_sequence(str(tmp_path / "out")).stamps_ns[10] == 600000000


@pytest.mark.parametrize(
    "changes, words",
    [
        ({"cam/image_array": "../secret.jpg"}, "is no name of a file in images/"),
        ({"_index": float("-inf")}, "catalog_0.catalog:1: not a record"),
        ({"_timestamp_ms": 10**30}, "catalog_0.catalog:1: not a record"),
        ({"user/angle": float("nan")}, "catalog_0.catalog:1: not a record"),
        ({"user/angle": None}, "catalog_0.catalog:1: not a record"),
        ({"_index": 4}, "record 4 is there twice"),
    ],
)
def test_tubs_that_are_none(tmp_path, changes, words):
    tub(tmp_path / "tub", 3, **changes)
    with pytest.raises(InputError, match=words):
        donkey.read(str(tmp_path / "tub"))


def test_a_manifest_that_is_cut_off_is_named(tmp_path):
    tub(tmp_path / "tub", 3, manifest='{"deleted_indexes": [1,')
    with pytest.raises(InputError, match="manifest.json:1: not a line of a manifest"):
        donkey.read(str(tmp_path / "tub"))


def test_a_tub_without_an_image_leaves_nothing_that_blocks_the_next_attempt(tmp_path):
    tub(tmp_path / "tub")
    (tmp_path / "tub" / "images" / "12.jpg").unlink()
    words = [str(tmp_path / "tub"), str(tmp_path / "out")]
    with pytest.raises(InputError, match=r"12.jpg: no such file \(record 12\)"):
        donkey_to_kitti.main(words)
    assert not (tmp_path / "out").exists()
    (tmp_path / "tub" / "images" / "12.jpg").write_bytes(png(160, 120))
    donkey_to_kitti.main(words)
    assert len(kitti.read_sequence(str(tmp_path / "out")).images) == 30


def test_a_sequence_that_cannot_be_finished_is_removed(tmp_path, monkeypatch):
    tub(tmp_path / "tub")
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "mine.txt").write_text("kept")

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(donkey_to_kitti.shutil, "copyfile", full)
    with pytest.raises(OSError):
        donkey_to_kitti.main([str(tmp_path / "tub"), str(tmp_path / "out"), "--copy"])
    assert os.listdir(tmp_path / "out") == ["mine.txt"]


def test_the_calibration_is_of_the_images_size(tmp_path, capsys):
    tub(tmp_path / "tub")
    for path in (tmp_path / "tub" / "images").iterdir():
        path.write_bytes(png(320, 240))
    (tmp_path / "tub" / "images" / "0.jpg").write_bytes(b"cut off")
    (tmp_path / "tub" / "images" / "7.jpg").write_bytes(png(160, 120))
    donkey_to_kitti.main([str(tmp_path / "tub"), str(tmp_path / "out")])
    told = capsys.readouterr().out
    assert "calib.txt for 320x240 pixels and a focal length of 120" in told
    assert "note: images that are not readable, the first is" in told and "0.jpg: 1" in told
    assert "note: images of another size than 320x240, the first is" in told and "7.jpg: 1" in told
    assert (tmp_path / "out" / "calib.txt").read_text() == "P0: 120 0 160 0 0 120 120 0 0 0 1 0\n"
    donkey_to_kitti.main([str(tmp_path / "tub"), str(tmp_path / "other"), "--focal_px", "100"])
    assert (tmp_path / "other" / "calib.txt").read_text().startswith("P0: 100 0 160")


def test_a_tub_whose_images_are_all_unreadable_is_refused(tmp_path):
    tub(tmp_path / "tub", 3)
    for path in (tmp_path / "tub" / "images").iterdir():
        path.write_bytes(b"no image")
    with pytest.raises(InputError, match="none of its 3 images is readable.*0.jpg: .*neither JPEG nor PNG"):
        donkey_to_kitti.main([str(tmp_path / "tub"), str(tmp_path / "out")])
    assert not (tmp_path / "out").exists()


def test_files_of_another_sequence_are_not_overwritten(tmp_path):
    tub(tmp_path / "tub")
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "odometry.csv").write_text("of a run")
    with pytest.raises(InputError, match="odometry.csv: not overwritten: it exists already"):
        donkey_to_kitti.main([str(tmp_path / "tub"), str(tmp_path / "out")])
    assert os.listdir(tmp_path / "out") == ["odometry.csv"] and (tmp_path / "out" / "odometry.csv").read_text() == "of a run"


@pytest.mark.parametrize(
    "option, value, words",
    [
        ("--max_steering_deg", "90", "--max_steering_deg: 90 is not allowed: below 80.36 with --steering_trim 0.12"),
        ("--max_steering_deg", "85", "--max_steering_deg: 85 is not allowed: below 80.36 with --steering_trim 0.12"),
        ("--steering_trim", "-3", "--max_steering_deg: 25 is not allowed: below 22.5 with --steering_trim -3"),
        ("--focal_px", "1e300", "--focal_px: 1e.300 is not allowed: 0.001 to 1e.06"),
        ("--speed_per_throttle", "1e300", "at record 1 the options make .* m/s and .* rad/s of its commands"),
        ("--wheelbase", "1e-300", "at record 1 the options make"),
    ],
)
def test_odometry_that_no_car_has_is_not_written(tmp_path, option, value, words):
    tub(tmp_path / "tub", 5)
    with pytest.raises(InputError, match=words):
        donkey_to_kitti.main([str(tmp_path / "tub"), str(tmp_path / "out"), option, value])
    assert not (tmp_path / "out").exists()
