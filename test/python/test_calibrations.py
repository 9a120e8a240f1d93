"""Calibration files: recorder_to_bag takes what ratslam_run --calibration takes, and refuses what it refuses."""

import numpy as np
import pytest

from ratslam_tools.datasets import calibration
from ratslam_tools.errors import InputError

OWN = "image_width: 64\nimage_height: 48\nfx: 50\nfy: 51\ncx: 31\ncy: 23\n"
ROS = (
    "image_width: 64\nimage_height: 48\ncamera_matrix: {rows: 3, cols: 3, data: [50, 0, 31, 0, 51, 23, 0, 0, 1]}\n"
    "distortion_model: plumb_bob\ndistortion_coefficients: {rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}\n"
)
BENT = ("data: [0, 0, 0, 0, 0]", "data: [-0.2, 0.01, 0, 0]")


@pytest.fixture
def read(tmp_path):
    def call(text):
        (tmp_path / "phone.yaml").write_text(text)
        return calibration.read(str(tmp_path / "phone.yaml"))

    return call


@pytest.mark.parametrize("name", ["radtan", "none", "Plumb_Bob", "''"])
def test_a_lens_that_bends_nothing_may_have_any_name(read, name):
    found = read(ROS.replace("plumb_bob", name))
    assert found.model == "plumb_bob" and found.distortion == (0.0,) * 5


@pytest.mark.parametrize("name", ["radtan", "none", "Plumb_Bob", "''"])
def test_a_lens_that_bends_has_a_model(read, name):
    with pytest.raises(InputError, match="phone.yaml: distortion_model: '.*' is none of plumb_bob, "):
        read(ROS.replace("plumb_bob", name).replace(*BENT))
    assert read(ROS.replace(*BENT)).distortion == (-0.2, 0.01, 0, 0, 0)


def test_matrices_may_be_plain_lists(read):
    text = "image_width: 64\nimage_height: 48\ncamera_matrix: [50, 0, 31, 0, 51, 23, 0, 0, 1]\ndistortion_coefficients: [-0.2]\n"
    assert read(text).distortion == (-0.2, 0, 0, 0, 0)
    np.testing.assert_array_equal(read(text).matrix, read(OWN).matrix)
    with pytest.raises(InputError, match=r"camera_matrix: 'data: \[...\]' is expected"):
        read(text.replace("[50, 0, 31, 0, 51, 23, 0, 0, 1]", "50"))
    with pytest.raises(InputError, match="camera_matrix: 'a list' is not a finite number"):
        read(text.replace("[50, 0, 31, 0, 51, 23, 0, 0, 1]", "[[50, 0, 31], [0, 51, 23], [0, 0, 1]]"))


def test_tabs_after_colons_are_blanks(read):
    np.testing.assert_array_equal(read(OWN.replace(": ", ":\t")).matrix, read(OWN).matrix)
    assert read(ROS.replace("width: ", "width:\t \t")).width == 64


def test_a_visible_skew_is_refused(read):
    with pytest.raises(InputError, match=r"camera_matrix\[1\] \(skew\): 3 is not allowed: it must be 0"):
        read(ROS.replace("[50, 0, 31", "[50, 3, 31"))
    assert read(ROS.replace("[50, 0, 31", "[50, 1e-3, 31")).matrix[0, 1] == 1e-3


def test_numbers_that_rosparam_takes_for_octal_are_refused(read):
    with pytest.raises(InputError, match="image_width: '064' begins with 0"):
        read(OWN.replace("64", "064"))
    assert read(OWN.replace("cx: 31", "cx: 0.5")).matrix[0, 2] == 0.5
