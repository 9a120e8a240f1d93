"""kitti_to_bag: a KITTI sequence or raw drive as a bag for the nodes."""

import argparse
import os
from typing import List, Tuple

import numpy as np

from ratslam_tools.datasets import bags, kitti, odometry_file
from ratslam_tools.datasets.images import load_image
from ratslam_tools.trajectory import geometry
from ratslam_tools.errors import InputError, finite, require_effect
from ratslam_tools.progress import Progress

def odometry_messages(rows: np.ndarray, offset_s: float) -> List[Tuple[int, object]]:
    """(stamp_ns, nav_msgs/Odometry) of odometry rows; the pose is their dead reckoning from the origin, in
    frame odom.
    """
    messages = []
    x = y = heading = 0.0
    before = rows[0, 1]
    for index, (_, stamp, speed, rate) in enumerate(rows):
        duration = stamp - before
        before = stamp
        heading += rate * duration
        x += speed * duration * np.cos(heading)
        y += speed * duration * np.sin(heading)
        stamp_ns = kitti.nanoseconds([stamp + offset_s])[0]
        quaternion = geometry.quaternions_from_matrices(geometry.rotation_about_z(heading)[None])[0]
        messages.append(
            (
                stamp_ns,
                bags.odometry_message(
                    bags.header(stamp_ns, "odom", index),
                    "base_link",
                    (x, y, 0.0),
                    quaternion,
                    (speed, 0.0, 0.0),
                    (0.0, 0.0, rate),
                ),
            )
        )
    return messages


def convert(drive: kitti.Drive, path: str, root: str, compressed: bool, colour: bool, odometry=()) -> int:
    """Writes the bag: static tf, then for each frame camera_info and image, with truth and odometry in order
    of time. Returns the number of images. Adds to drive.notes the images that ratslam_run leaves out: those that cannot be
    read, which the bag leaves out as well, and those of another size than the first readable one, whose size the
    calibration has.
    @throws InputError if no image is readable.
    """
    prefix = "/" + root.strip("/") + "/" if root.strip("/") else "/"
    image_topic = prefix + "camera/image" + ("/compressed" if compressed else "")
    others = [
        (stamp, "ground_truth", message)
        for stamp, message in (
            bags.ground_truth_messages(drive.truth, drive.truth_stamps_ns) if drive.truth is not None else ()
        )
    ]
    others += [(stamp, "odom", message) for stamp, message in odometry]
    others.sort(key=lambda item: item[0])
    progress = Progress(len(drive.images), "kitti_to_bag")
    following = 0
    size, unreadable, of_other_size = None, [], []
    with bags.writing(path) as bag:
        bags.write(
            bag,
            "/tf_static",
            bags.static_transform(
                drive.stamps_ns[0], "base_link", "camera", drive.camera_rotation, drive.camera_translation
            ),
            drive.stamps_ns[0],
        )
        for index, (file, stamp) in enumerate(zip(drive.images, drive.stamps_ns)):
            while following < len(others) and others[following][0] <= stamp:
                _write_other(bag, prefix, *others[following])
                following += 1
            head = bags.header(stamp, "camera", index)
            progress.advance()
            try:
                image = load_image(file, colour)
            except InputError as error:
                unreadable.append(str(error))
                continue
            shape = image.shape[1::-1]
            size = size or shape
            if shape != size:
                of_other_size.append(f"{file}: {shape[0]}x{shape[1]}")
            info = bags.camera_info(head, *size, drive.projection[:, :3], drive.projection)
            bags.write(bag, prefix + "camera/camera_info", info, stamp)
            message = bags.compressed_image(head, file) if compressed else bags.raw_image(head, image)
            bags.write(bag, image_topic, message, stamp)
        for item in others[following:]:
            _write_other(bag, prefix, *item)
        progress.close()
        if size is None:
            folder = os.path.dirname(drive.images[0])
            raise InputError(f"{folder}: none of its {len(drive.images)} images is readable; the first: {unreadable[0]}")
    for what, found in (
        ("images left out because they cannot be read", unreadable),
        ("images of another size than {}x{}, the calibration's".format(*size), of_other_size),
    ):
        if found:
            drive.notes.append(f"{what}: {len(found)}; the first: {found[0]}")
    return len(drive.images) - len(unreadable)


def _write_other(bag, prefix: str, stamp_ns: int, name: str, message) -> None:
    bags.write(bag, prefix + name, message, stamp_ns)


def main(argv=None) -> None:
    """kitti_to_bag."""
    parser = argparse.ArgumentParser(
        prog="kitti_to_bag",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        description="A KITTI odometry sequence or raw drive as a bag: camera/image, camera/camera_info, "
        "ground_truth "
        "(nav_msgs/Odometry, x forward, z up), and the camera under base_link on /tf_static.",
        epilog="examples:\n  kitti_to_bag dataset/sequences/00 kitti_00.bag --compressed\n"
        "  kitti_to_bag 2011_09_26/2011_09_26_drive_0009_sync drive.bag --root kitti\n"
        "  kitti_to_bag sequences/00 clip.bag --start 100 --end 200 --odometry odometry.csv "
        "--odometry_offset 0.02",
    )
    parser.add_argument(
        "folder", help="sequence folder (image_0, times.txt, calib.txt) or raw drive (image_00, oxts)"
    )
    parser.add_argument("bag", help="bag file to write")
    parser.add_argument(
        "--root", default="kitti", help="name that all topics are put under; '' for none (default: kitti)"
    )
    parser.add_argument(
        "--compressed", action="store_true", help="camera/image/compressed with the files' own bytes"
    )
    parser.add_argument(
        "--camera", type=int, default=0, choices=range(4), help="0, 1 grey; 2, 3 colour (default 0)"
    )
    parser.add_argument("--start", type=int, default=0, help="first frame (default 0)")
    parser.add_argument("--end", type=int, help="frame to stop before (default: none)")
    parser.add_argument(
        "--odometry", metavar="CSV", help="also <root>/odom from columns " + ",".join(odometry_file.COLUMNS)
    )
    parser.add_argument(
        "--odometry_offset", type=finite, metavar="SECONDS", help="added to the odometry's stamps"
    )
    arguments = parser.parse_args(argv)
    bags.require_topic_name("--root", arguments.root)
    require_effect(arguments.odometry is not None, "there is no --odometry", odometry_offset=arguments.odometry_offset)
    offset = arguments.odometry_offset or 0.0
    drive = kitti.read_drive(arguments.folder, arguments.camera)
    count = len(drive.images)
    drive = drive.select(arguments.start, arguments.end)
    odometry: List[Tuple[int, object]] = []
    if arguments.odometry:
        rows = odometry_file.read_odometry(arguments.odometry)
        end = count if arguments.end is None else arguments.end
        rows = rows[(rows[:, 0] >= arguments.start) & (rows[:, 0] < end)]
        if not len(rows):
            raise InputError(f"{arguments.odometry}: no rows for frames {arguments.start} to {end}")
        stamps = rows[:, 1] + offset
        if stamps.min() < 0.0 or stamps.max() >= 2.0**32:
            raise InputError(
                f"{arguments.odometry}: with --odometry_offset {offset:g} its stamps are "
                f"{stamps.min():.9g} to {stamps.max():.9g} s; ROS can hold 0 to 2^32 s"
            )
        odometry = odometry_messages(rows, offset)
        first, last = drive.stamps_ns[0], drive.stamps_ns[-1]
        if odometry[-1][0] < first or odometry[0][0] > last:
            raise InputError(
                f"{arguments.odometry}: all of it lies outside the images' time: {odometry[0][0] / 1e9:.9g} to "
                f"{odometry[-1][0] / 1e9:.9g} s beside {first / 1e9:.9g} to {last / 1e9:.9g} s; --odometry_offset moves it"
            )
    written = convert(drive, arguments.bag, arguments.root, arguments.compressed, arguments.camera >= 2, odometry)
    truth = "with" if drive.truth is not None else "without"
    print(
        f"{arguments.bag}: {written} images, {truth} ground truth"
        + (f", {len(odometry)} odometry messages" if odometry else "")
    )
    for note in drive.notes:
        print(f"note: {note}")
