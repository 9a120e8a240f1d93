"""Tubs of robot cars as they come: records that were deleted, names that lead elsewhere, values that are none."""

import json
import os

import pytest

from ratslam_tools.cli import donkey_to_kitti
from ratslam_tools.datasets import donkey, kitti
from ratslam_tools.errors import InputError


def tub(folder, count=30, manifest=None, **changes):
    (folder / "images").mkdir(parents=True)
    lines = []
    for index in range(count):
        (folder / "images" / f"{index}.jpg").write_bytes(b"")
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
