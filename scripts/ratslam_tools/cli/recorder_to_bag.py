"""recorder_to_bag: an Android dataset recorder's folder as a bag for the nodes."""

import argparse
import os

import numpy as np

from ratslam_tools import text_file
from ratslam_tools.datasets import bags, calibration, recorder
from ratslam_tools.datasets.images import load_image
from ratslam_tools.trajectory import geometry
from ratslam_tools.errors import InputError, finite
from ratslam_tools.progress import Progress
from ratslam_tools.trajectory import write_tum

ROTATIONS = (0, 90, 180, 270)
JPEG_QUALITY = 95
# Android's accuracy is the radius that holds 68% of fixes; of a round 2D Gaussian that is 1.51 standard
# deviations.
SIGMA_PER_ACCURACY = 1 / 1.5096


def rotated_message(head, image: np.ndarray, degrees: int):
    """sensor_msgs/CompressedImage of the image turned clockwise, encoded anew: as JPEG, or as PNG if it has 16 bits."""
    import cv2
    from sensor_msgs.msg import CompressedImage

    turns = {90: cv2.ROTATE_90_CLOCKWISE, 180: cv2.ROTATE_180, 270: cv2.ROTATE_90_COUNTERCLOCKWISE}
    kind = "png" if image.dtype == np.uint16 else "jpeg"
    options = [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY] if kind == "jpeg" else []
    _, data = cv2.imencode("." + kind, cv2.rotate(image, turns[degrees]), options)
    return CompressedImage(header=head, format=kind, data=data.tobytes())


def imu_message(head, sample):
    """sensor_msgs/Imu of (ax, ay, az [m/s^2], gx, gy, gz [rad/s]) in the phone's axes; orientation is not
    known.
    """
    from geometry_msgs.msg import Vector3
    from sensor_msgs.msg import Imu

    message = Imu(
        header=head, linear_acceleration=Vector3(*sample[:3]), angular_velocity=Vector3(*sample[3:])
    )
    message.orientation_covariance[0] = -1.0
    return message


def fix_message(head, fix):
    """sensor_msgs/NavSatFix of (latitude, longitude [deg], altitude, accuracy [m], ...)."""
    from sensor_msgs.msg import NavSatFix

    message = NavSatFix(header=head, latitude=fix[0], longitude=fix[1], altitude=fix[2])
    message.status.service = 1
    if np.isfinite(fix[3]) and fix[3] > 0:
        variance = (fix[3] * SIGMA_PER_ACCURACY) ** 2
        # The height is about twice as inaccurate as the position; the phone does not state its accuracy.
        message.position_covariance = [variance, 0, 0, 0, variance, 0, 0, 0, 4 * variance]
        message.position_covariance_type = NavSatFix.COVARIANCE_TYPE_APPROXIMATED
    return message


def other_messages(recording: recorder.Recording, track) -> list:
    """(stamp, topic, message) of IMU, GPS and truth, sorted by stamp."""
    messages = [
        (stamp, "imu", imu_message(bags.header(stamp, "imu", index), sample))
        for index, (stamp, sample) in enumerate(zip(recording.imu_stamps, recording.imu))
    ]
    messages += [
        (stamp, "gps", fix_message(bags.header(stamp, "gps", index), fix))
        for index, (stamp, fix) in enumerate(zip(recording.gps_stamps, recording.gps))
    ]
    if track is not None:
        stamps = [int(value) for value in np.rint(track.stamps * 1e9)]
        messages += [
            (stamp, "ground_truth", message) for stamp, message in bags.ground_truth_messages(track, stamps)
        ]
    return sorted(messages, key=lambda item: item[0])


def convert(
    recording: recorder.Recording, path: str, root: str, camera: calibration.Calibration, rotate: int, track
) -> int:
    """Writes the bag; returns how many images. Unreadable images are counted in recording.dropped and left
    out.

    @throws InputError if an image's size is not the calibration's, or none is readable.
    """
    prefix = "/" + root.strip("/") + "/" if root.strip("/") else "/"
    progress = Progress(len(recording.images), "recorder_to_bag")
    others = other_messages(recording, track)
    following = written = 0
    with bags.writing(path) as bag:
        first = min([recording.image_stamps[0]] + [item[0] for item in others[:1]])
        bags.write(
            bag,
            "/tf_static",
            bags.static_transform(first, "base_link", "camera", geometry.CAMERA_TO_BASE),
            first,
        )
        for stamp, file in zip(recording.image_stamps, recording.images):
            while following < len(others) and others[following][0] <= stamp:
                bags.write(bag, prefix + others[following][1], others[following][2], others[following][0])
                following += 1
            progress.advance()
            try:
                image = load_image(file, colour=True)
            except InputError:
                recording.dropped["unreadable image"] += 1
                continue
            height, width = image.shape[:2] if rotate in (0, 180) else image.shape[1::-1]
            if (width, height) != (camera.width, camera.height):
                raise InputError(
                    f"{file}: {width}x{height} px{' after rotation' if rotate else ''}; the calibration is "
                    f"of "
                    f"{camera.width}x{camera.height}"
                )
            head = bags.header(stamp, "camera", written)
            if rotate == 0:
                message = bags.compressed_image(head, file)
            else:
                message = rotated_message(head, image, rotate)
            info = bags.camera_info(head, width, height, camera.matrix, None, camera.distortion, camera.model)
            bags.write(bag, prefix + "camera/camera_info", info, stamp)
            bags.write(bag, prefix + "camera/image/compressed", message, stamp)
            written += 1
        for stamp, topic, message in others[following:]:
            bags.write(bag, prefix + topic, message, stamp)
        progress.close()
        if not written:
            raise InputError(f"{recording.folder}: none of its {len(recording.images)} images is readable")
    return written


def main(argv=None) -> None:
    """recorder_to_bag."""
    parser = argparse.ArgumentParser(
        prog="recorder_to_bag",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        description="A folder of the Android dataset recorder as a bag: camera/image/compressed, "
        "camera/camera_info, imu, gps "
        "(NavSatFix), ground_truth (nav_msgs/Odometry from GPS in East-North-Up), and the camera on "
        "/tf_static.",
        epilog="examples:\n  recorder_to_bag '23-05-14 10:31:07' nn.bag --calibration phone.yaml\n"
        "  recorder_to_bag 23-05-14-10-31-07 nn.bag --calibration phone.yaml --rotate 90 --gps_tum gps.tum",
    )
    parser.add_argument("folder", help="the recorder's folder")
    parser.add_argument("bag", help="bag file to write")
    parser.add_argument(
        "--calibration",
        required=True,
        metavar="YAML",
        help="camera intrinsics, as in config/calibration/phone_example.yaml",
    )
    parser.add_argument(
        "--root", default="nn", help="name that all topics are put under; '' for none (default: nn)"
    )
    parser.add_argument(
        "--rotate", type=int, choices=ROTATIONS, default=0, help="turn images clockwise by so many degrees"
    )
    parser.add_argument(
        "--max_accuracy",
        type=finite,
        default=20.0,
        metavar="M",
        help="fixes with a worse stated accuracy are no ground truth (default 20 m)",
    )
    parser.add_argument(
        "--gps_tum", metavar="FILE", help="also write the GPS track (the same as ground_truth) as TUM"
    )
    arguments = parser.parse_args(argv)
    bags.require_topic_name("--root", arguments.root)
    if arguments.max_accuracy <= 0.0:
        raise InputError(f"--max_accuracy: {arguments.max_accuracy:g} is not allowed: above 0 m")
    read = recorder.index_files(arguments.folder)
    text_file.require_other("--gps_tum", arguments.gps_tum, [arguments.calibration, *read])
    text_file.require_other("--gps_tum", arguments.gps_tum, [arguments.bag], "written")
    camera = calibration.read(arguments.calibration)
    recording = recorder.read(arguments.folder)
    text_file.require_other("--gps_tum", arguments.gps_tum, recording.images)
    rows = recorder.good_fixes(recording, arguments.max_accuracy)
    track = recorder.gps_track(recording, rows) if len(rows) else None
    if arguments.gps_tum and track is None:
        raise InputError(
            f"{arguments.folder}: none of its {len(recording.gps)} GPS fixes has a stated accuracy of "
            f"{arguments.max_accuracy:g} m or better: no track to write"
        )
    if arguments.gps_tum:  # before the bag, which takes long: an error here comes at once
        write_tum(arguments.gps_tum, track)
    written = convert(recording, arguments.bag, arguments.root, camera, arguments.rotate, track)
    print(
        f"{os.path.basename(arguments.bag)}: {written} images, {len(recording.imu)} IMU samples, "
        f"{len(recording.gps)} GPS "
        f"fixes, {len(rows)} of them accurate to {arguments.max_accuracy:g} m"
    )
    for reason, count in sorted(recording.dropped.items()):
        if count:
            print(f"note: {reason}: {count}")
