"""KITTI folders: sequences of the odometry benchmark and raw drives.

Odometry: `image_N/*.png|jpg`, `times.txt`, `calib.txt`, `poses.txt` (or `../../poses/NN.txt`).
Raw: `image_0N/{data,timestamps.txt}`, `oxts/{data,timestamps.txt}`, calibration files in the folder above.
"""

import os
import re
from dataclasses import dataclass, field
from datetime import datetime, timezone
from typing import Dict, List, Optional

import numpy as np

from ratslam_tools import text_file
from ratslam_tools.datasets.images import list_files, list_images, times_of
from ratslam_tools.errors import InputError, require_folder
from ratslam_tools.trajectory import Trajectory, frames, geodesy, geometry, read_times, read_trajectory


FOCAL_PX = (0.001, 1e6)  # least and most that a camera has
SLOW_S = 10.0  # whole numbers at least so far apart are probably milliseconds, not seconds


@dataclass
class Drive:
    """One recorded drive; stamps in whole nanoseconds, truth in base convention."""

    images: List[str]
    stamps_ns: List[int]
    projection: np.ndarray  # (3, 4) [px] of the camera in use
    truth: Optional[Trajectory] = None
    truth_stamps_ns: List[int] = field(default_factory=list)
    # Pose of the camera (optical axes) in base_link; the truth is the path of base_link.
    camera_rotation: np.ndarray = field(default_factory=lambda: geometry.CAMERA_TO_BASE)
    camera_translation: np.ndarray = field(default_factory=lambda: np.zeros(3))
    notes: List[str] = field(default_factory=list)  # irregularities that were repaired, a line each

    def select(self, start: int, end: Optional[int]) -> "Drive":
        """Frames start ... end - 1. @throws InputError if there are none, or their times do not rise: the messages of a bag
        lie in order of time.
        """
        rows = slice(start, end)
        if start < 0 or (end is not None and end <= start) or not self.images[rows]:
            raise InputError(
                f"frames {start} to {'the end' if end is None else end}: the drive has {len(self.images)}"
            )
        steps = np.diff(np.array(self.stamps_ns[rows]))
        wrong = np.flatnonzero(steps <= 0)
        if len(wrong):
            frame = start + int(wrong[0]) + 1
            alone = f"; take the frames before and from it on alone: --end {frame}, --start {frame}"
            raise InputError(
                f"{self.images[frame]}: its time ({self.stamps_ns[frame] / 1e9:.9f} s) does not lie after that of the image "
                f"before ({self.stamps_ns[frame - 1] / 1e9:.9f} s), and the times of a bag rise"
                + (alone if 2 * len(wrong) < len(steps) else "")
            )
        truth = None if self.truth is None else self.truth.select(rows)
        return Drive(
            self.images[rows],
            self.stamps_ns[rows],
            self.projection,
            truth,
            self.truth_stamps_ns[rows],
            self.camera_rotation,
            self.camera_translation,
            self.notes,
        )


def nanoseconds(seconds) -> List[int]:
    """Times [s] rounded to whole nanoseconds."""
    return [int(value) for value in np.rint(np.asarray(seconds, dtype=float) * 1e9)]


def read_calibration(path: str) -> Dict[str, np.ndarray]:
    """Lines `key: numbers` of a KITTI calibration file; other lines (dates, comments) are left out."""
    values = {}
    for _, line in text_file.read_lines(path):
        key, colon, text = line.partition(":")
        try:
            numbers = np.array([text_file.finite_number(word) for word in text.split()])
        except ValueError:
            continue
        if not colon:
            continue
        if not np.array_equal(values.setdefault(key.strip(), numbers), numbers):
            raise InputError(f"{path}: line '{key.strip()}:' is given twice, with other numbers")
    return values


def _matrix(path: str, keys, *shape: int) -> np.ndarray:
    """The numbers of the first of `keys` that the calibration file `path` has, as an array of shape `shape`. @throws InputError
    if it has none of them, or another number of numbers."""
    values = read_calibration(path)
    key = next((key for key in keys if key in values), None)
    count = int(np.prod(shape))
    if key is None or values[key].size != count:
        raise InputError(f"{path}: no line '{keys[0]}:' with {count} numbers")
    return values[key].reshape(shape)


def _projection(path: str, camera: int) -> np.ndarray:
    """Projection (3, 4) [px] of a camera, under the benchmark's name or that of the raw drives."""
    matrix = _matrix(path, (f"P{camera}", f"P_rect_{camera:02d}"), 3, 4)
    if not all(FOCAL_PX[0] <= focal <= FOCAL_PX[1] for focal in (matrix[0, 0], matrix[1, 1])):
        raise InputError(
            f"{path}: P{camera}: focal lengths {matrix[0, 0]:g} and {matrix[1, 1]:g} px; they must lie within 0.001 to 1e6"
        )
    return matrix


def is_raw(folder: str) -> bool:
    """Whether a folder is a raw drive."""
    return os.path.isdir(os.path.join(folder, "oxts")) or os.path.isdir(os.path.join(folder, "image_00"))


def poses_file(folder: str) -> Optional[str]:
    """The file with a sequence's true poses: in the folder, or in the benchmark's layout; None if there is
    none.
    """
    folder = os.path.abspath(folder)
    beside = os.path.join(
        os.path.dirname(os.path.dirname(folder)), "poses", os.path.basename(folder) + ".txt"
    )
    return next((path for path in (os.path.join(folder, "poses.txt"), beside) if os.path.isfile(path)), None)


def _image_folder(folder: str, camera: int) -> str:
    """image_N of a sequence. @throws InputError listing the existing ones if it is missing."""
    path = os.path.join(folder, f"image_{camera}")
    if not os.path.isdir(path):
        others = [number for number in range(4) if os.path.isdir(os.path.join(folder, f"image_{number}"))]
        hint = f"; image_{others[0]} is there: --camera {others[0]}" if others else ""
        require_folder(path, hint)
    return path


def read_sequence(folder: str, camera: int = 0) -> Drive:
    """A sequence of the odometry benchmark. The truth, if there is any, is that of base_link at the left grey camera.
    """
    images = list_images(_image_folder(folder, camera))
    path = os.path.join(folder, "times.txt")
    times = read_times(path)
    rows = times_of(images, len(times), path)
    stamps_ns = nanoseconds(times[rows])
    drive = Drive(images, stamps_ns, _projection(os.path.join(folder, "calib.txt"), camera))
    if len(times) > len(images):
        drive.notes.append(
            f"{path}: {len(times)} times for {len(images)} images: each image takes the time of the number in its name"
        )
    apart = float(np.median(np.diff(times))) if len(times) > 1 else 0.0
    if apart >= SLOW_S and (times == np.rint(times)).all():
        drive.notes.append(f"{path}: its times lie {apart:g} s apart; are they milliseconds? They are taken as seconds")
    path = poses_file(folder)
    if path is not None:
        truth = frames.convert(read_trajectory(path, "kitti"), "camera", "base")
        if len(truth) != len(times):
            raise InputError(f"{path}: {len(truth)} poses for {len(times)} times of images")
        truth = truth.select(rows)
        truth.stamps = times[rows]
        drive.truth, drive.truth_stamps_ns = truth, stamps_ns
    return drive


def read_timestamps(path: str) -> List[int]:
    """Lines `2011-09-26 13:02:25.964389445` (UTC) as nanoseconds since 1970."""
    stamps: List[int] = []
    for number, text in text_file.read_lines(path):
        whole, _, fraction = text.partition(".")
        try:
            if fraction and re.fullmatch("[0-9]+", fraction) is None:
                raise ValueError(fraction)
            moment = datetime.strptime(whole, "%Y-%m-%d %H:%M:%S").replace(tzinfo=timezone.utc)
            stamps.append(int(moment.timestamp()) * 10**9 + int(fraction[:9].ljust(9, "0")))
        except ValueError:
            raise InputError(
                f"{path}:{number}: '{text_file.shown(text)}' is no time of the form 2011-09-26 13:02:25.964389445"
            ) from None
        if not 0 <= stamps[-1] < 2**32 * 10**9:
            raise InputError(f"{path}:{number}: {text_file.shown(text)} lies outside 1970 to 2106")
        if len(stamps) > 1 and stamps[-1] <= stamps[-2]:
            raise InputError(f"{path}:{number}: the time does not lie after the one before it")
    return stamps


def read_oxts(folder: str) -> Trajectory:
    """Path of the inertial unit (x forward, y left, z up) from `oxts/data`, relative to its first pose.

    Latitude and longitude go through KITTI's Mercator projection scaled at the first latitude; roll, pitch,
    yaw turn about x, y, z. Source: Geiger et al., Vision meets robotics: the KITTI dataset, IJRR 2013, and
    the raw development kit's text.
    """
    rows = []
    data = os.path.join(folder, "oxts", "data")
    for name in (name for name in list_files(data) if name.lower().endswith(".txt")):
        words = text_file.read_text(os.path.join(data, name)).split()
        try:
            rows.append([text_file.finite_number(word) for word in words[:6]])
        except ValueError:
            rows.append([])
        if len(rows[-1]) != 6 or not abs(rows[-1][0]) < 90:
            raise InputError(
                f"{os.path.join(data, name)}: no latitude, longitude, altitude, roll, pitch and yaw"
            )
    if not rows:
        raise InputError(f"{data}: empty")
    latitude, longitude, altitude, roll, pitch, yaw = np.array(rows).T
    positions = np.column_stack([*geodesy.mercator(latitude, longitude, latitude[0]), altitude])
    rotations = np.array(
        [
            geometry.rotation_about_z(c) @ geometry.rotation_about_y(b) @ geometry.rotation_about_x(a)
            for a, b, c in zip(roll, pitch, yaw)
        ]
    )
    inverse = rotations[0].T
    return Trajectory((positions - positions[0]) @ inverse.T, inverse @ rotations, None, data).check()


def read_raw(folder: str, camera: int = 0) -> Drive:
    """A raw drive (synchronised and rectified). With oxts the truth is that of base_link at the inertial unit.
    """
    images = list_images(os.path.join(folder, f"image_{camera:02d}", "data"))
    stamps_ns = read_timestamps(os.path.join(folder, f"image_{camera:02d}", "timestamps.txt"))
    if len(stamps_ns) != len(images):
        raise InputError(f"{folder}: {len(images)} images and {len(stamps_ns)} times")
    above = os.path.dirname(os.path.abspath(folder))
    intrinsics = os.path.join(above, "calib_cam_to_cam.txt")
    drive = Drive(images, stamps_ns, _projection(intrinsics, camera))
    if os.path.isdir(os.path.join(folder, "oxts", "data")):
        drive.truth = read_oxts(folder)
        drive.truth_stamps_ns = read_timestamps(os.path.join(folder, "oxts", "timestamps.txt"))
        if len(drive.truth) != len(images) or len(drive.truth_stamps_ns) != len(images):
            raise InputError(
                f"{folder}: {len(images)} images, {len(drive.truth)} oxts files, "
                f"{len(drive.truth_stamps_ns)} oxts times"
            )
        drive.truth.stamps = np.array(drive.truth_stamps_ns) * 1e-9
    chain = [os.path.join(above, name) for name in ("calib_imu_to_velo.txt", "calib_velo_to_cam.txt")]
    if all(map(os.path.isfile, chain)):
        camera_from_unit = np.eye(4)
        for path in chain:
            camera_from_unit = _rigid(_matrix(path, ("R",), 3, 3), _matrix(path, ("T",), 3)) @ camera_from_unit
        camera_from_unit = _rigid(_matrix(intrinsics, ("R_rect_00",), 3, 3), np.zeros(3)) @ camera_from_unit
        try:
            unit_from_camera = np.linalg.inv(camera_from_unit)
        except np.linalg.LinAlgError:
            raise InputError(f"{chain[0]}, {chain[1]}: R is no rotation matrix") from None
        drive.camera_rotation, drive.camera_translation = unit_from_camera[:3, :3], unit_from_camera[:3, 3]
    return drive


def _rigid(rotation, translation) -> np.ndarray:
    """Homogeneous matrix (4, 4)."""
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation, translation
    return matrix


def read_drive(folder: str, camera: int = 0) -> Drive:
    """An odometry sequence or a raw drive, whichever the folder is."""
    require_folder(folder)
    return read_raw(folder, camera) if is_raw(folder) else read_sequence(folder, camera)
