"""donkey_to_kitti: a donkey car's tub (images and `catalog_*.catalog`) as a KITTI sequence, with odometry
from its commands.

The car has no wheel encoder. Speed and yaw rate follow from its commands (kinematic bicycle model, no slip):
    v = speed_per_throttle * throttle, following it with a first-order lag of `speed_lag` seconds
    delta = max_steering * (trim - angle)        the tub's angle is +1 at full right lock; delta is positive
    to the left yaw rate = v * tan(delta) / wheelbase
with the commands taking effect `delay` seconds later. The defaults fit the image shift of a lap track (trim
and delays by regression, which explains 70% of the shift's variance; speed so that a lap turns once): they are crude.
"""

import argparse
import os
import shutil

import numpy as np

from ratslam_tools import text_file
from ratslam_tools.datasets import donkey, odometry_file
from ratslam_tools.datasets.images import measure_image
from ratslam_tools.datasets.kitti import FOCAL_PX
from ratslam_tools.errors import InputError, finite

TIMES, CALIBRATION, ODOMETRY = "times.txt", "calib.txt", "odometry.csv"
FOCAL_PER_WIDTH = 60.0 / 160  # of the car's camera


def parse_run(text: str) -> tuple:
    """`first:last` as two record indices, both included."""
    first, separator, last = text.partition(":")
    try:
        bounds = int(first), int(last)
    except ValueError:
        bounds = (0, -1)
    if not separator or bounds[0] > bounds[1] or bounds[0] < 0:
        raise InputError(f"--run: '{text}' is not allowed: first:last, such as 2129:5014")
    return bounds


def first_order_lag(stamps, values, time_constant: float) -> np.ndarray:
    """The response of a first-order lag [s] to sampled values, starting settled."""
    if time_constant == 0:
        return np.array(values)
    response = np.array(values)
    for index in range(1, len(values)):
        share = 1 - np.exp(-(stamps[index] - stamps[index - 1]) / time_constant)
        response[index] = response[index - 1] + share * (values[index] - response[index - 1])
    return response


def command_odometry(stamps, angles, throttles, arguments) -> np.ndarray:
    """Rows (frame, stamp, linear_x, angular_z): the mean motion between the frame before and this one."""
    delayed = stamps - arguments.delay
    middle = np.concatenate([delayed[:1], (delayed[1:] + delayed[:-1]) / 2])
    angle = np.interp(middle, stamps, angles)
    throttle = np.interp(middle, stamps, throttles)
    speed = arguments.speed_per_throttle * first_order_lag(stamps, throttle, arguments.speed_lag)
    steering = np.radians(arguments.max_steering_deg) * (arguments.steering_trim - angle)
    rate = speed * np.tan(steering) / arguments.wheelbase
    speed[0] = rate[0] = 0.0
    return np.column_stack([np.arange(len(stamps)), stamps, speed, rate])


def focal_length(arguments, pictures: "Pictures") -> float:
    """The given focal length, or the usual one for images of this width [px]."""
    return FOCAL_PER_WIDTH * pictures.size[0] if arguments.focal_px is None else arguments.focal_px


class Pictures:
    """The image files of records. @throws InputError if one is missing, or none is readable.

    `size` is that of the first readable one; `unreadable` and `of_other_size` are those that runs will leave out.
    """

    def __init__(self, records: list, folder: str):
        self.files = [os.path.abspath(os.path.join(folder, "images", record.image)) for record in records]
        self.unreadable, self.of_other_size = [], []
        self.size, reason = None, None
        for file, record in zip(self.files, records):
            if not os.path.isfile(file):
                raise InputError(f"{file}: no such file (record {record.index})")
            try:
                size = measure_image(file)
            except InputError as error:
                reason = reason or error
                self.unreadable.append(file)
                continue
            self.size = self.size or size
            if size != self.size:
                self.of_other_size.append(file)
        if self.size is None:
            raise InputError(f"{folder}: none of its {len(records)} images is readable; the first: {reason}")

    def print_notes(self) -> None:
        """Prints which images ratslam_run will leave out: the first one of each kind, and how many there are."""
        what = "images of another size than {}x{}".format(*self.size)
        for words, files in (("images that are not readable", self.unreadable), (what, self.of_other_size)):
            if files:
                print(f"note: {words}, the first is {files[0]}: {len(files)}")


def convert(records: list, folder: str, out: str, arguments) -> Pictures:
    """Writes image_0, times.txt, calib.txt and odometry.csv to the folder `out`. @throws InputError, and leaves none of
    them, if the records or images cannot be used."""
    stamps = np.array([record.time_ms - records[0].time_ms for record in records]) / 1e3
    if (np.diff(stamps) <= 0).any():
        raise InputError(
            f"{folder}: time stands still or goes back at record "
            f"{records[np.argmax(np.diff(stamps) <= 0) + 1].index}"
        )
    images = os.path.join(out, "image_0")
    if os.path.isdir(images) and os.listdir(images):
        raise InputError(f"{images}: exists and is not empty")
    written = [os.path.join(out, name) for name in (TIMES, CALIBRATION, ODOMETRY)]
    for path in filter(os.path.lexists, written):
        raise InputError(f"{path}: not overwritten: it exists already; give another folder")
    pictures = Pictures(records, folder)
    rows = _motion(records, stamps, folder, arguments)
    found = os.path.isdir(out)
    os.makedirs(images, exist_ok=True)
    try:
        _write(pictures, rows, out, arguments)
    except BaseException:
        shutil.rmtree(images, ignore_errors=True)  # it was empty, and would block the next attempt
        for path in filter(os.path.lexists, written):
            os.unlink(path)
        if not found:
            shutil.rmtree(out, ignore_errors=True)
        raise
    return pictures


def _motion(records: list, stamps, folder: str, arguments) -> np.ndarray:
    """The odometry of records. @throws InputError if the options make it one that no car has"""
    angles, throttles = (np.array([getattr(record, name) for record in records]) for name in ("angle", "throttle"))
    with np.errstate(all="ignore"):
        rows = command_odometry(stamps, angles, throttles, arguments)
        wrong = np.flatnonzero(~(np.abs(rows[:, 2:]) <= odometry_file.FASTEST).all(axis=1))
    if len(wrong):
        _, _, speed, rate = rows[wrong[0]]
        raise InputError(
            f"{folder}: at record {records[wrong[0]].index} the options make {speed:g} m/s and {rate:g} rad/s of its commands; "
            f"at most {odometry_file.FASTEST:g} can be"
        )
    return rows


def _write(pictures: Pictures, rows: np.ndarray, out: str, arguments) -> None:
    images = os.path.join(out, "image_0")
    for frame, source in enumerate(pictures.files):
        target = os.path.join(images, f"{frame:06d}{os.path.splitext(source)[1]}")
        if arguments.copy:
            shutil.copyfile(source, target)
        else:
            os.symlink(source, target)
    with text_file.writing(os.path.join(out, TIMES)) as file:
        file.writelines(f"{stamp:.6f}\n" for stamp in rows[:, 1])
    (width, height), focal = pictures.size, focal_length(arguments, pictures)
    with text_file.writing(os.path.join(out, CALIBRATION)) as file:
        file.write(f"P0: {focal:g} 0 {width / 2:g} 0 0 {focal:g} {height / 2:g} 0 0 0 1 0\n")
    with text_file.writing(os.path.join(out, ODOMETRY)) as file:
        file.write(",".join(odometry_file.COLUMNS) + "\n")
        file.writelines(
            f"{frame:.0f},{stamp:.6f},{speed:.9g},{rate:.9g}\n" for frame, stamp, speed, rate in rows
        )


def main(argv=None) -> None:
    """donkey_to_kitti."""
    parser = argparse.ArgumentParser(
        prog="donkey_to_kitti",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        description=__doc__,
        epilog="examples:\n  donkey_to_kitti tub out/laps --run 2129:5014\n"
        "  ratslam_run out/laps --config config/donkey.yaml --odometry out/laps/odometry.csv --out out/run",
    )
    parser.add_argument("folder", help="tub: catalog_*.catalog and images/")
    parser.add_argument("out", help="KITTI sequence folder to make")
    parser.add_argument("--run", metavar="FIRST:LAST", help="records to take, both included (default: all)")
    parser.add_argument("--copy", action="store_true", help="copy the images (default: symbolic links)")
    parser.add_argument(
        "--wheelbase", type=finite, default=0.25, metavar="M", help="[m] (default %(default)s)"
    )
    parser.add_argument(
        "--max_steering_deg",
        type=finite,
        default=25.0,
        metavar="DEG",
        help="at full lock (default %(default)s)",
    )
    parser.add_argument(
        "--steering_trim",
        type=finite,
        default=0.12,
        metavar="X",
        help="command at which the car runs straight (default %(default)s)",
    )
    parser.add_argument(
        "--speed_per_throttle",
        type=finite,
        default=5.0,
        metavar="M/S",
        help="speed at full throttle (default %(default)s)",
    )
    parser.add_argument(
        "--delay", type=finite, default=0.2, metavar="S", help="command to motion (default %(default)s)"
    )
    parser.add_argument(
        "--speed_lag", type=finite, default=0.5, metavar="S", help="throttle to speed (default %(default)s)"
    )
    parser.add_argument(
        "--focal_px", type=finite, metavar="PX", help="for calib.txt (default: 60 for a width of 160, in proportion)"
    )
    arguments = parser.parse_args(argv)
    for key in ("wheelbase", "max_steering_deg", "speed_per_throttle", "focal_px"):
        if getattr(arguments, key) is not None and not getattr(arguments, key) > 0:
            raise InputError(f"--{key}: {getattr(arguments, key)} is not allowed: above 0")
    # At full lock against the trim the wheels stand at more than --max_steering_deg.
    most = 90.0 / (1.0 + abs(arguments.steering_trim))
    if arguments.max_steering_deg >= most:
        raise InputError(
            f"--max_steering_deg: {arguments.max_steering_deg:g} is not allowed: below {most:.4g} with --steering_trim "
            f"{arguments.steering_trim:g}, so that the wheels stay below 90 degrees"
        )
    if arguments.focal_px is not None and not FOCAL_PX[0] <= arguments.focal_px <= FOCAL_PX[1]:
        raise InputError(f"--focal_px: {arguments.focal_px:g} is not allowed: {FOCAL_PX[0]:g} to {FOCAL_PX[1]:g}")
    for key in ("delay", "speed_lag"):
        if not getattr(arguments, key) >= 0:
            raise InputError(f"--{key}: {getattr(arguments, key)} is not allowed: at least 0")
    tub = donkey.read(arguments.folder)
    records = tub.records
    if arguments.run is not None:
        first, last = parse_run(arguments.run)
        records = [record for record in records if first <= record.index <= last]
        if not records:
            raise InputError(f"--run: no records {arguments.run} in {arguments.folder}")
    pictures = convert(records, arguments.folder, arguments.out, arguments)
    focal = focal_length(arguments, pictures)
    print(
        f"{arguments.out}: {len(records)} frames, odometry.csv from the commands, calib.txt for "
        f"{pictures.size[0]}x{pictures.size[1]} pixels and a focal length of {focal:g}"
    )
    pictures.print_notes()
    if tub.deleted:
        print(f"note: records that manifest.json says are deleted, left out: {tub.deleted}")
