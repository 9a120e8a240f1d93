"""A folder of the Android dataset recorder: images, IMU and GPS with Unix times in milliseconds.

CSV without heads. Newer: data_image.txt (ms, path), data_imu.txt (ms, ax, ay, az [m/s^2], gx, gy, gz
[rad/s]), data_gps.txt (ms, latitude, longitude [deg], altitude, accuracy [m], bearing [deg], speed [m/s],
provider).
Older: imu_data.txt and gps_data.txt, no index of images, which are named by nanoseconds.
Times are those of the phone's callbacks: they jitter, repeat, and may be out of order. The number of digits shows
whether they are in microseconds or nanoseconds (stamp_of).
"""

import os
import re
from collections import Counter
from dataclasses import dataclass, field
from typing import List, Optional, Tuple

import numpy as np

from ratslam_tools import text_file
from ratslam_tools.datasets.clock import clock_set_back
from ratslam_tools.datasets.images import ENDINGS, list_files
from ratslam_tools.errors import InputError, require_folder
from ratslam_tools.trajectory import Trajectory, geodesy, geometry

FILES = {
    "image": ("data_image.txt",),
    "imu": ("data_imu.txt", "imu_data.txt"),
    "gps": ("data_gps.txt", "gps_data.txt"),
}
SECONDS_DIGITS = 10  # of Unix times from 2001 on
MAX_STAMP_NS = 2**32 * 10**9  # ROS stamps are below this [ns]
MIN_SPEED_FOR_BEARING = 1.0  # [m/s]; a phone's bearing is noise below it
MAX_NUMBER = 1e9  # no sensor's reading is larger


@dataclass
class Recording:
    """One recording; stamps in nanoseconds since 1970, increasing. `dropped` has the number of entries left out, or
    in doubt, by reason.
    """

    folder: str
    images: List[str] = field(default_factory=list)
    image_stamps: List[int] = field(default_factory=list)
    imu_stamps: List[int] = field(default_factory=list)
    imu: np.ndarray = field(default_factory=lambda: np.zeros((0, 6)))  # ax ay az gx gy gz
    gps_stamps: List[int] = field(default_factory=list)
    # latitude longitude altitude accuracy bearing speed; NaN where the phone did not know (never a position's)
    gps: np.ndarray = field(default_factory=lambda: np.zeros((0, 6)))
    dropped: Counter = field(default_factory=Counter)


def is_recording(folder: str) -> bool:
    """Whether a folder holds a recording."""
    return any(os.path.isfile(os.path.join(folder, name)) for names in FILES.values() for name in names)


def stamp_of(digits: str) -> Optional[int]:
    """Nanoseconds of a time: 16 digits are Unix microseconds, up to 14 milliseconds, others nanoseconds. None for a
    text that is no time.
    """
    if re.fullmatch("[0-9]{1,19}", digits) is None:
        return None
    unit = 10**6 if len(digits) <= 14 else 10**3 if len(digits) == 16 else 1
    stamp = int(digits) * unit
    return stamp if stamp < MAX_STAMP_NS else None


def read(folder: str) -> Recording:
    """Reads a recording of either form. @throws InputError if the folder is none, or has no image that
    exists.
    """
    require_folder(folder)
    recording = Recording(folder)
    _read_images(recording)
    _read_imu(recording)
    _read_gps(recording, _path(folder, "gps"))
    return recording


def read_images(folder: str) -> List[str]:
    """Paths of a recording's images by time, whatever its other logs hold. @throws InputError if none exists."""
    recording = Recording(folder)
    _read_images(recording)
    return recording.images


def read_gps_log(path: str) -> Recording:
    """Only the GPS of a recording: `path` is its folder or the log itself."""
    log = _path(path, "gps") if os.path.isdir(path) else path
    if log is None:
        raise InputError(f"{path}: no GPS log ({' or '.join(FILES['gps'])})")
    recording = Recording(path)
    _read_gps(recording, log)
    if not recording.gps_stamps:
        raise InputError(f"{log}: no GPS fix with a position{_left_out(recording) or ' (the file is empty)'}")
    return recording


def _left_out(recording: Recording) -> str:
    counted = ", ".join(f"{reason}: {count}" for reason, count in sorted(recording.dropped.items()) if count)
    return f" ({counted})" if counted else ""


def index_files(folder: str) -> List[str]:
    """The text files of a recording that exist."""
    return [path for path in (_path(folder, kind) for kind in FILES) if path is not None]


def _path(folder: str, kind: str) -> Optional[str]:
    paths = (os.path.join(folder, name) for name in FILES[kind])
    return next((path for path in paths if os.path.isfile(path)), None)


def _rows(path: str, least: int, most: int, dropped: Counter, what: str) -> List[Tuple[int, List[str]]]:
    """(stamp, words after it) of each line that has a time and at least `least` words; others are counted.

    @throws InputError for a line of more than `most` words without a decimal point: it has decimal commas, which
    cannot be told from the commas between columns.
    """
    rows = []
    for number, line in text_file.read_lines(path):
        words = [word.strip() for word in line.split(",")]
        stamp = stamp_of(words[0])
        if stamp is None or len(words) < least:
            dropped[f"malformed {what} line"] += 1
            continue
        if len(words) > most and not any("." in word for word in words[1:]):
            raise InputError(
                f"{path}:{number}: {len(words)} columns in '{text_file.shown(line)}': decimals are written with the "
                "commas that part the columns; write them with points"
            )
        _tell_doubt(words[0], os.path.basename(path), dropped)
        rows.append((stamp, words[1:]))
    return rows


def _tell_doubt(digits: str, where: str, dropped: Counter) -> None:
    """Counts a time of 10 digits. It is read as milliseconds, which would be early in 1970, but is probably in seconds."""
    if len(digits) == SECONDS_DIGITS:
        dropped[f"{where}: time of 10 digits, taken as milliseconds (of 1970); is it in seconds?"] += 1


def _read_images(recording: Recording) -> None:
    index = _path(recording.folder, "image")
    found = _indexed_images(recording, index) if index is not None else _named_images(recording)
    last = -1
    for stamp, path in sorted(found, key=lambda image: (image[0], not os.path.isfile(image[1]), image[1])):
        if stamp == last:
            recording.dropped["image with a repeated stamp"] += 1
        elif not os.path.isfile(path):
            recording.dropped["missing image file"] += 1
        else:
            recording.images.append(path)
            recording.image_stamps.append(stamp)
            last = stamp
    if not recording.images:
        expected = "listed in data_image.txt" if index is not None else "named by their time, in images/"
        raise InputError(f"{recording.folder}: no images {expected}{_left_out(recording)}")


def _indexed_images(recording: Recording, index: str) -> List[Tuple[int, str]]:
    rows = _rows(index, 2, np.iinfo(int).max, recording.dropped, "image")
    for _, words in rows:
        if os.path.isabs(words[0]) or ".." in words[0].split("/") or "\0" in words[0]:
            raise InputError(f"{index}: '{text_file.shown(words[0])}' does not lie within the recording's folder")
    found = [(stamp, os.path.join(recording.folder, words[0])) for stamp, words in rows]
    jump = clock_set_back(found)
    if jump is not None:
        stamp, seconds = jump
        raise InputError(
            f"{index}: the phone's clock was set back by {seconds:.3f} s before the image of {stamp // 10**6} ms: the "
            "times before and after it overlap; keep the lines before it or those from it on, and do each part alone"
        )
    if any(after[0] < before[0] for before, after in zip(found, found[1:])):
        recording.dropped["images out of order (sorted)"] += 1
    return found


def _named_images(recording: Recording) -> List[Tuple[int, str]]:
    inside = os.path.join(recording.folder, "images")
    inside = inside if os.path.isdir(inside) else recording.folder
    found = []
    for name in list_files(inside):
        stem, ending = os.path.splitext(name)
        stamp = stamp_of(stem)
        if ending.lower() in ENDINGS and stamp is not None:
            _tell_doubt(stem, "images/", recording.dropped)
            found.append((stamp, os.path.join(inside, name)))
        elif ending.lower() in ENDINGS:
            recording.dropped["image whose name is no time"] += 1
    return found


def _numbers(rows: list, count: int, dropped: Counter, what: str):
    """(stamp, numbers) of rows sorted by time; words that are no finite numbers become NaN."""
    found = []
    for stamp, words in rows:
        numbers = [_finite_or_nan(word) for word in words[:count]]
        found.append((stamp, numbers + [np.nan] * (count - len(numbers))))
    if any(after[0] < before[0] for before, after in zip(found, found[1:])):
        dropped[f"{what} out of order (sorted)"] += 1
    return sorted(found, key=lambda item: item[0])


def _finite_or_nan(word: str) -> float:
    try:
        number = text_file.finite_number(word)
    except ValueError:
        return np.nan
    return number if abs(number) <= MAX_NUMBER else np.nan


def _read_imu(recording: Recording) -> None:
    path = _path(recording.folder, "imu")
    if path is None:
        return
    samples = _numbers(_rows(path, 7, 8, recording.dropped, "IMU"), 6, recording.dropped, "IMU samples")
    whole = [sample for sample in samples if np.isfinite(sample[1]).all()]
    recording.dropped["IMU sample that is no number"] += len(samples) - len(whole)
    repeats = Counter(stamp for stamp, _ in whole)  # in order of time, as the samples are
    for stamp, following in zip(repeats, [*list(repeats)[1:], MAX_STAMP_NS]):
        # Several samples of one time are all real. They are distributed evenly over its millisecond, or up to the next time.
        span = min(10**6, following - stamp)
        recording.imu_stamps += [stamp + number * span // repeats[stamp] for number in range(repeats[stamp])]
    recording.imu = np.array([numbers for _, numbers in whole]).reshape(-1, 6)


def _read_gps(recording: Recording, path: Optional[str]) -> None:
    if path is None:
        return
    last = -1
    fixes = []
    for stamp, numbers in _numbers(
        _rows(path, 3, 9, recording.dropped, "GPS"), 6, recording.dropped, "GPS fixes"
    ):
        latitude, longitude = numbers[:2]
        # NaN fails every comparison. A phone writes (0, 0) before its first fix.
        if not (abs(latitude) <= 90 and abs(longitude) <= 180) or latitude == longitude == 0:
            recording.dropped["GPS fix without a position"] += 1
        elif stamp == last:
            recording.dropped["GPS fix with a repeated stamp"] += 1
        else:
            if not np.isfinite(numbers[2]):
                recording.dropped["GPS fix without an altitude (that of the fix before it is taken)"] += 1
            fixes.append(numbers)
            recording.gps_stamps.append(stamp)
            last = stamp
    recording.gps = np.array(fixes).reshape(-1, 6)


def good_fixes(recording: Recording, max_accuracy: float) -> np.ndarray:
    """Rows of the fixes whose stated accuracy [m] is known and good enough."""
    accuracy = recording.gps[:, 3]
    return np.flatnonzero(np.isfinite(accuracy) & (accuracy > 0) & (accuracy <= max_accuracy))


def gps_track(recording: Recording, rows: np.ndarray) -> Trajectory:
    """Path of the fixes in East-North-Up about the first one. The body's x axis points along the bearing.

    If the phone is too slow for a bearing, the last known one is used, and before that the first known one. Unknown
    altitudes are treated in the same way.
    """
    latitude, longitude, altitude, _, bearing, speed = recording.gps[rows].T
    altitude = _carried_on(altitude, np.isfinite(altitude))
    positions = geodesy.local_enu(latitude, longitude, altitude, (latitude[0], longitude[0], altitude[0]))
    known = np.isfinite(bearing) & (np.nan_to_num(speed) >= MIN_SPEED_FOR_BEARING)
    yaw = np.radians(90.0 - _carried_on(bearing, known)) if known.any() else np.zeros(len(rows))
    rotations = np.array([geometry.rotation_about_z(angle) for angle in yaw])
    stamps = np.array([recording.gps_stamps[row] for row in rows]) * 1e-9
    return Trajectory(positions, rotations, stamps, f"{recording.folder}: GPS").check()


def _carried_on(values: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Values (n,), in which each unknown one is replaced by the last known one before it, or, if there is none, by the first
    known one; zeros if none is known. @param known (n,) bools"""
    if not known.any():
        return np.zeros(len(values))
    latest = np.maximum.accumulate(np.where(known, np.arange(len(values)), -1))
    latest[latest < 0] = np.argmax(known)
    return values[latest]
