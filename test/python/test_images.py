"""Image files: what they are, how large and whether whole is looked at before anything is decoded."""

import numpy as np
import pytest

from ratslam_tools.datasets import images
from ratslam_tools.errors import InputError

cv2 = pytest.importorskip("cv2")


def small_image(ending):
    return cv2.imencode(ending, np.arange(12, dtype=np.uint8).reshape(3, 4))[1].tobytes()


@pytest.mark.parametrize(
    "change, words",
    [
        (lambda png, jpeg: b"\0" * 128 + b"DICM" + b"\0" * 20, "152 bytes that are neither JPEG nor PNG"),
        (lambda png, jpeg: b"", "0 bytes that are neither JPEG nor PNG"),
        (lambda png, jpeg: png[:16] + b"\0\0\x75\x30\0\0\x75\x30" + png[24:], "30000x30000 pixels: at most 50000000"),
        (lambda png, jpeg: png[:-8], "it was cut off after"),
        (lambda png, jpeg: jpeg[: len(jpeg) - 9], "it was cut off after"),
        (lambda png, jpeg: jpeg[:30], "it was cut off after"),
        (lambda png, jpeg: jpeg[:4] + b"\0\0" + jpeg[6:], "a JPEG without an image"),
    ],
)
def test_images_are_measured_before_they_are_decoded(change, words, tmp_path):
    path = tmp_path / "a.jpg"
    path.write_bytes(change(small_image(".png"), small_image(".jpg")))
    with pytest.raises(InputError, match=f"a.jpg: not a readable image: {words}"):
        images.load_image(str(path), colour=False)


def test_images_that_are_whole_are_read(tmp_path):
    for ending in (".png", ".jpg"):
        (tmp_path / "a.jpg").write_bytes(small_image(ending))  # what it is, its bytes say
        assert images.load_image(str(tmp_path / "a.jpg"), colour=False).shape == (3, 4)
