"""Reads a camera's intrinsics from a file: hand-written (like config/calibration/phone_example.yaml), or written by
ROS's camera_calibration or OpenCV.
"""

import re
from dataclasses import dataclass

import numpy as np

from ratslam_tools import text_file
from ratslam_tools.datasets import flat_yaml
from ratslam_tools.errors import InputError

REQUIRED = ("image_width", "image_height", "fx", "fy", "cx", "cy")
DISTORTION = ("k1", "k2", "p1", "p2", "k3")
# Coefficients of each of the lens models of sensor_msgs/CameraInfo; more of them must be zero.
MODELS = {"plumb_bob": 5, "rational_polynomial": 8, "equidistant": 4}
SYNONYMS = {"fisheye": "equidistant"}
MAX_SIZE, MAX_FOCAL = 65535, 1e6  # [px]
VISIBLE_SKEW = 0.5  # [px] at the border of the image
OCTAL = re.compile(r"[-+]?0[0-9]+")


@dataclass(frozen=True)
class Calibration:
    """Pinhole camera with one of ROS's lens models."""

    width: int  # [px]
    height: int
    matrix: np.ndarray  # (3, 3) [px]
    distortion: tuple  # in the order of ROS and OpenCV
    model: str = "plumb_bob"


def read(path: str) -> Calibration:
    """The calibration in a YAML file. @throws InputError for a missing or unknown key, or a value that no camera can have."""
    entries = flat_yaml.load(path)
    if "camera_matrix" in entries:
        return _ros_form(path, entries)
    unknown = sorted(set(entries) - set(REQUIRED) - set(DISTORTION))
    missing = [key for key in REQUIRED if key not in entries]
    if unknown or missing:
        what = f"unknown key {unknown[0]}" if unknown else f"no {missing[0]}"
        raise InputError(
            f"{path}: {what}; the keys are {', '.join(REQUIRED + DISTORTION)}, or those of ROS's camera_calibration"
        )
    for key, text in entries.items():
        if isinstance(text, str) and OCTAL.fullmatch(text):
            raise InputError(f"{path}: {key}: '{text}' begins with 0, which makes it octal for rosparam; write it without")
    values = {key: _number(path, key, text) for key, text in entries.items()}
    matrix = np.array([[values["fx"], 0, values["cx"]], [0, values["fy"], values["cy"]], [0, 0, 1]])
    return Calibration(
        _size(path, "image_width", values["image_width"]),
        _size(path, "image_height", values["image_height"]),
        _checked(path, matrix),
        tuple(values.get(key, 0.0) for key in DISTORTION),
    )


def _ros_form(path: str, entries: dict) -> Calibration:
    for key in ("image_width", "image_height"):
        if key not in entries:
            raise InputError(f"{path}: no {key}")
    matrix = np.array(_data(path, entries, "camera_matrix"))
    if matrix.size != 9:
        raise InputError(f"{path}: camera_matrix: {matrix.size} numbers; 9 are expected")
    has_some = "distortion_coefficients" in entries
    coefficients = _data(path, entries, "distortion_coefficients") if has_some else []
    named = str(entries.get("distortion_model", "plumb_bob"))
    name = SYNONYMS.get(named, named)
    if not any(coefficients):
        name = name if name in MODELS else "plumb_bob"  # without distortion all models are the same
    elif name not in MODELS:
        raise InputError(f"{path}: distortion_model: '{text_file.shown(named)}' is none of {', '.join(MODELS)}")
    count = MODELS[name]
    if any(coefficients[count:]):
        raise InputError(f"{path}: distortion_coefficients: {name} has {count}, here are {len(coefficients)}")
    coefficients = (coefficients + [0.0] * count)[:count]
    width, height = (_size(path, key, _number(path, key, entries[key])) for key in ("image_width", "image_height"))
    (fx, skew, cx), (_, fy, cy) = matrix.reshape(3, 3)[:2]
    matrix = _checked(path, np.array([[fx, skew, cx], [0, fy, cy], [0, 0, 1]]))
    if abs(skew) * max(abs(cy), abs(height - cy)) / fy >= VISIBLE_SKEW:
        raise InputError(f"{path}: camera_matrix[1] (skew): {skew:g} is not allowed: it must be 0")
    return Calibration(width, height, matrix, tuple(coefficients), name)


def _data(path: str, entries: dict, key: str) -> list:
    """The numbers of `key: {rows, cols, data: [...]}`."""
    entry = entries[key]
    data = entry.get("data") if isinstance(entry, dict) else entry
    if not isinstance(data, list):
        raise InputError(f"{path}: {key}: 'data: [...]' is expected")
    return [_number(path, key, text) for text in data]


def _number(path: str, key: str, text) -> float:
    try:
        return text_file.finite_number(text if isinstance(text, str) else "")
    except ValueError:
        shown = text_file.shown(text) if isinstance(text, str) else "a list"
        raise InputError(f"{path}: {key}: '{shown}' is not a finite number") from None


def _size(path: str, key: str, value: float) -> int:
    if not 0 < value <= MAX_SIZE or value != int(value):
        raise InputError(f"{path}: {key}: {value:g} is not allowed: a whole number, above 0, up to {MAX_SIZE}")
    return int(value)


def _checked(path: str, matrix: np.ndarray) -> np.ndarray:
    for key, value in (("fx", matrix[0, 0]), ("fy", matrix[1, 1])):
        if not 1e-3 <= value <= MAX_FOCAL:
            raise InputError(f"{path}: {key}: {value:g} is not allowed: above 0, up to {MAX_FOCAL:g}")
    for key, value in (("cx", matrix[0, 2]), ("cy", matrix[1, 2])):
        if abs(value) > MAX_FOCAL:
            raise InputError(f"{path}: {key}: {value:g} is not allowed: within {MAX_FOCAL:g}")
    return matrix
