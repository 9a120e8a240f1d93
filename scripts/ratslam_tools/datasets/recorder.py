"""The folder that the Android dataset recorder leaves: images, IMU and GPS with Unix times in milliseconds.

CSV without heads. Newer: data_image.txt (ms, path), data_imu.txt (ms, ax, ay, az [m/s^2], gx, gy, gz
[rad/s]), data_gps.txt (ms, latitude, longitude [deg], altitude, accuracy [m], bearing [deg], speed [m/s],
provider).
Older: imu_data.txt and gps_data.txt, no index of images, which are named by nanoseconds.
Times are those of the phone's callbacks: they jitter, repeat, and may be out of order.
"""

import os
from collections import Counter
from dataclasses import dataclass, field
from typing import List, Optional

import numpy as np

from ratslam_tools.trajectory import geodesy, geometry
from ratslam_tools.errors import InputError
from ratslam_tools.trajectory import Trajectory

FILES = {
    "image": ("data_image.txt",),
    "imu": ("data_imu.txt", "imu_data.txt"),
    "gps": ("data_gps.txt", "gps_data.txt"),
}
IMAGE_ENDINGS = (".jpeg", ".jpg", ".png")
NANOSECONDS_PER_MS = 10**6
# A number of this many digits cannot be Unix milliseconds before the year 5138.
NANOSECOND_DIGITS = 15
MIN_SPEED_FOR_BEARING = 1.0  # [m/s]; a phone's bearing is noise below it


@dataclass
class Recording:
    """One recording; stamps in nanoseconds since 1970, increasing. `dropped` counts what was left out, by
    reason.
    """

    folder: str
    images: List[str] = field(default_factory=list)
    image_stamps: List[int] = field(default_factory=list)
    imu_stamps: List[int] = field(default_factory=list)
    imu: np.ndarray = field(default_factory=lambda: np.zeros((0, 6)))  # ax ay az gx gy gz
    gps_stamps: List[int] = field(default_factory=list)
    gps: np.ndarray = field(
        default_factory=lambda: np.zeros((0, 6))
    )  # latitude longitude altitude accuracy bearing speed
    dropped: Counter = field(default_factory=Counter)


def is_recording(folder: str) -> bool:
    """Whether a folder holds a recording."""
    return any(os.path.isfile(os.path.join(folder, name)) for names in FILES.values() for name in names)


def _path(folder: str, kind: str) -> Optional[str]:
    paths = (os.path.join(folder, name) for name in FILES[kind])
    return next((path for path in paths if os.path.isfile(path)), None)


def _rows(path: str, columns: int, dropped: Counter, what: str) -> list:
    """Words of each line that has an integer time and at least `columns` words; others are counted."""
    rows = []
    with open(path, encoding="utf-8", errors="replace") as file:
        for line in file:
            words = [word.strip() for word in line.split(",")]
            if words == [""]:
                continue
            if len(words) < columns or not words[0].isdigit():
                dropped[f"malformed {what} line"] += 1
            else:
                rows.append(words)
    return rows


def stamp_of(digits: str) -> int:
    """Nanoseconds of a time written in milliseconds or nanoseconds."""
    return int(digits) * (1 if len(digits) >= NANOSECOND_DIGITS else NANOSECONDS_PER_MS)


def read(folder: str) -> Recording:
    """Reads a recording of either form. @throws InputError if the folder is none, or has no image that
    exists.
    """
    if not os.path.isdir(folder):
        raise InputError(f"{folder}: no such folder")
    recording = Recording(folder)
    _read_images(recording)
    _read_imu(recording)
    _read_gps(recording, _path(folder, "gps"))
    return recording


def read_gps_log(path: str) -> Recording:
    """Only the GPS of a recording: `path` is its folder or the log itself."""
    log = _path(path, "gps") if os.path.isdir(path) else path
    if log is None or not os.path.isfile(log):
        raise InputError(f"{path}: no GPS log ({' or '.join(FILES['gps'])})")
    recording = Recording(path)
    _read_gps(recording, log)
    return recording


def _read_images(recording: Recording) -> None:
    index = _path(recording.folder, "image")
    if index is not None:
        found = [
            (stamp_of(words[0]), os.path.join(recording.folder, words[1]))
            for words in _rows(index, 2, recording.dropped, "image")
        ]
    else:
        inside = os.path.join(recording.folder, "images")
        inside = inside if os.path.isdir(inside) else recording.folder
        names = [os.path.splitext(name) for name in os.listdir(inside)]
        found = [
            (stamp_of(stem), os.path.join(inside, stem + ending))
            for stem, ending in names
            if ending.lower() in IMAGE_ENDINGS and stem.isdigit()
        ]
    last = -1
    for stamp, path in sorted(found):
        if not os.path.isfile(path):
            recording.dropped["missing image file"] += 1
        elif stamp == last:
            recording.dropped["image with a repeated stamp"] += 1
        else:
            recording.images.append(path)
            recording.image_stamps.append(stamp)
            last = stamp
    if not recording.images:
        expected = "listed in data_image.txt" if index is not None else "named by their time, in images/"
        raise InputError(f"{recording.folder}: no images {expected}")


def _numbers(rows: list, count: int, dropped: Counter, what: str):
    """(stamp, numbers) of rows sorted by time; rows with words that are no finite numbers are counted and
    left out.
    """
    found = []
    for words in rows:
        try:
            numbers = [float(word) for word in words[1 : 1 + count]]
        except ValueError:
            numbers = []
        numbers += [np.nan] * (count - len(numbers))
        found.append((stamp_of(words[0]), numbers))
    if any(after[0] < before[0] for before, after in zip(found, found[1:])):
        dropped[f"{what} out of order (sorted)"] += 1
    return sorted(found, key=lambda item: item[0])


def _read_imu(recording: Recording) -> None:
    path = _path(recording.folder, "imu")
    if path is None:
        return
    samples = _numbers(_rows(path, 7, recording.dropped, "IMU"), 6, recording.dropped, "IMU samples")
    whole = [sample for sample in samples if np.isfinite(sample[1]).all()]
    recording.dropped["IMU sample that is no number"] += len(samples) - len(whole)
    repeats = Counter(stamp for stamp, _ in whole)
    seen: Counter = Counter()
    for stamp, _ in whole:
        # Several samples within one millisecond are all real: they share it evenly.
        recording.imu_stamps.append(stamp + seen[stamp] * NANOSECONDS_PER_MS // repeats[stamp])
        seen[stamp] += 1
    recording.imu = np.array([numbers for _, numbers in whole]).reshape(-1, 6)


def _read_gps(recording: Recording, path: Optional[str]) -> None:
    if path is None:
        return
    last = -1
    fixes = []
    for stamp, numbers in _numbers(
        _rows(path, 5, recording.dropped, "GPS"), 6, recording.dropped, "GPS fixes"
    ):
        latitude, longitude = numbers[:2]
        if (
            not np.isfinite(numbers[:3]).all()
            or abs(latitude) > 90
            or abs(longitude) > 180
            or latitude == longitude == 0
        ):
            recording.dropped["GPS fix without a position"] += 1
        elif stamp == last:
            recording.dropped["GPS fix with a repeated stamp"] += 1
        else:
            fixes.append(numbers)
            recording.gps_stamps.append(stamp)
            last = stamp
    recording.gps = np.array(fixes).reshape(-1, 6)


def good_fixes(recording: Recording, max_accuracy: float) -> np.ndarray:
    """Rows of the fixes whose stated accuracy [m] is known and good enough."""
    accuracy = recording.gps[:, 3]
    return np.flatnonzero(np.isfinite(accuracy) & (accuracy > 0) & (accuracy <= max_accuracy))


def gps_track(recording: Recording, rows: np.ndarray) -> Trajectory:
    """Path of the given fixes in East-North-Up about the first of them; x of the body points along the
    bearing.

    Where the phone is too slow to have a bearing, the last one holds; before the first, the first.
    """
    latitude, longitude, altitude, _, bearing, speed = recording.gps[rows].T
    positions = geodesy.local_enu(latitude, longitude, altitude, (latitude[0], longitude[0], altitude[0]))
    known = np.isfinite(bearing) & (np.nan_to_num(speed) >= MIN_SPEED_FOR_BEARING)
    yaw = np.zeros(len(rows))
    if known.any():
        latest = np.maximum.accumulate(np.where(known, np.arange(len(rows)), -1))
        latest[latest < 0] = np.argmax(known)
        yaw = np.radians(90.0 - bearing[latest])
    rotations = np.array([geometry.rotation_about_z(angle) for angle in yaw])
    stamps = np.array([recording.gps_stamps[row] for row in rows]) * 1e-9
    return Trajectory(positions, rotations, stamps, f"{recording.folder}: GPS").check()
