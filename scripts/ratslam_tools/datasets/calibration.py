"""A camera's intrinsics from a hand-written file (config/calibration/phone_example.yaml shows one)."""

from dataclasses import dataclass

import numpy as np

from ratslam_tools.datasets import flat_yaml
from ratslam_tools.errors import InputError

REQUIRED = ("image_width", "image_height", "fx", "fy", "cx", "cy")
DISTORTION = ("k1", "k2", "p1", "p2", "k3")


@dataclass(frozen=True)
class Calibration:
    """Pinhole camera with plumb_bob distortion."""

    width: int  # [px]
    height: int
    matrix: np.ndarray  # (3, 3) [px]
    distortion: tuple  # k1, k2, p1, p2, k3


def read(path: str) -> Calibration:
    """@throws InputError for a missing or unknown key, or a value that no camera can have."""
    texts = flat_yaml.read(path)
    unknown = sorted(set(texts) - set(REQUIRED) - set(DISTORTION))
    missing = [key for key in REQUIRED if key not in texts]
    if unknown or missing:
        what = f"unknown key {unknown[0]}" if unknown else f"no {missing[0]}"
        raise InputError(f"{path}: {what}; the keys are {', '.join(REQUIRED + DISTORTION)}")
    values = {}
    for key, text in texts.items():
        try:
            values[key] = float(text)
        except ValueError:
            values[key] = np.nan
        if not np.isfinite(values[key]):
            raise InputError(f"{path}: {key}: '{text}' is not a finite number")
        if key in ("fx", "fy", "image_width", "image_height") and values[key] <= 0:
            raise InputError(f"{path}: {key}: {text} is not allowed: above 0")
    matrix = np.array([[values["fx"], 0, values["cx"]], [0, values["fy"], values["cy"]], [0, 0, 1]])
    return Calibration(
        int(values["image_width"]),
        int(values["image_height"]),
        matrix,
        tuple(values.get(key, 0.0) for key in DISTORTION),
    )
