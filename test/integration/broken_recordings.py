#!/usr/bin/python3
"""A corpus of recordings that are broken in one way each, as bags and, where that exists, as folders.

Usage: broken_recordings.py OUT. Writes OUT/<kind>.bag (images on /drive/camera/image or .../compressed) and
OUT/<kind>/ (a KITTI sequence: image_0/, times.txt). All show the same drive, two laps of a closed strip.
"""
import os
import struct
import sys
import zlib

import cv2
import numpy as np
import rosbag
from sensor_msgs.msg import CompressedImage, Image

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import harness  # noqa: E402  (lies beside this file)

ROOT = "/drive"
FRAMES = 100
SECOND = 1000000000


class Shot:
    """One image of a recording: its stamp, and either pixels with an encoding or the bytes of a file."""

    def __init__(self, at, pixels=None, encoding="mono8", data=None, big_endian=0, step=None, size=None):
        self.at, self.pixels, self.encoding, self.data = at, pixels, encoding, data
        self.big_endian, self.step, self.size = big_endian, step, size

    def raw(self):
        rows = np.ascontiguousarray(self.pixels).reshape(self.pixels.shape[0], -1).view(np.uint8)
        height, width = self.size or self.pixels.shape[:2]
        message = Image(height=height, width=width, encoding=self.encoding, is_bigendian=self.big_endian,
                        step=self.step or rows.shape[1], data=rows.tobytes())
        message.header.stamp, message.header.frame_id = harness.stamp(self.at), "camera"
        return message

    def compressed(self):
        message = CompressedImage(format="jpeg", data=self.data)
        message.header.stamp, message.header.frame_id = harness.stamp(self.at), "camera"
        return message


def jpeg(pixels):
    return cv2.imencode(".jpg", pixels)[1].tobytes()


def png(pixels):
    return cv2.imencode(".png", pixels)[1].tobytes()


def huge_png(side=12000):
    """A PNG of a few hundred kilobytes that unpacks to side x side pixels."""
    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
    rows = zlib.compressobj(9)
    packed = b"".join(rows.compress(bytes(1 + side)) for _ in range(side)) + rows.flush()
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", side, side, 8, 0, 0, 0, 0)) +
            chunk(b"IDAT", packed) + chunk(b"IEND", b""))


def with_orientation(data, orientation):
    exif = b"Exif\0\0MM\0\x2a\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01" + struct.pack(">HHI", orientation, 0, 0)
    return data[:2] + b"\xff\xe1" + struct.pack(">H", len(exif) + 2) + exif + data[2:]


def with_thumbnail(data):
    """A JPEG that carries another, whole one in a segment of its own, as cameras do."""
    small = jpeg(np.full((16, 16), 99, np.uint8))
    return data[:2] + b"\xff\xe1" + struct.pack(">H", len(small) + 2) + small + data[2:]


class Drive:
    """The good drive that all kinds start from."""

    def __init__(self):
        self.strip = harness.panorama()

    def grey(self, index):
        return harness.frame(self.strip, index)

    def colour(self, index):
        grey = self.grey(index)
        return np.dstack([grey, 255 - grey, grey // 2])

    def shots(self, make=None):
        make = make or (lambda index: {"pixels": self.grey(index)})
        return [Shot(harness.frame_stamp(index), **make(index)) for index in range(FRAMES)]

    def files(self, encode=jpeg):
        return self.shots(lambda index: {"data": encode(self.grey(index))})


def replaced(shots, changes):
    """The shots with fields of some changed: {index: {field: value}}."""
    for index, fields in changes.items():
        for field, value in fields.items():
            setattr(shots[index], field, value)
    return shots


def swapped_with_next(shots, indices):
    for index in indices:
        shots[index], shots[index + 1] = shots[index + 1], shots[index]
    return shots


def deep(pixels, factor, order="<u2"):
    return (pixels.astype(np.uint16) * factor).astype(order)


def kinds():
    """{name: (shots, exists as a folder)}; what is compressed has bytes, what is raw has pixels."""
    drive = Drive()
    raw, files = drive.shots, drive.files
    sizes = {3: (60, 80), 40: (30, 160)}
    odd = {index: {"pixels": cv2.resize(drive.grey(index), size[::-1])} for index, size in sizes.items()}
    one_file = lambda data: replaced(files(), {20: {"data": data(20)}, 70: {"data": data(70)}})
    noise = np.random.RandomState(5)
    uyvy = lambda grey: np.dstack([np.full_like(grey, 128), grey])
    return {
        "clean": (raw(), True),
        "clean_jpeg": (files(), True),
        "mono16": (raw(lambda i: {"pixels": deep(drive.grey(i), 257), "encoding": "mono16"}), True),
        "mono16_big_endian": (raw(lambda i: {"pixels": deep(drive.grey(i), 257, ">u2"), "encoding": "mono16",
                                             "big_endian": 1}), False),
        "mono16_of_12_bits": (raw(lambda i: {"pixels": deep(drive.grey(i), 16), "encoding": "mono16"}), True),
        "colour": (raw(lambda i: {"pixels": drive.colour(i), "encoding": "bgr8"}), True),
        "rgb8": (raw(lambda i: {"pixels": drive.colour(i)[:, :, ::-1], "encoding": "rgb8"}), False),
        "alpha": (raw(lambda i: {"pixels": np.dstack([drive.colour(i), np.full((harness.HEIGHT, harness.WIDTH), 7, np.uint8)]),
                                 "encoding": "bgra8"}), True),
        "8UC1": (raw(lambda i: {"pixels": drive.grey(i), "encoding": "8UC1"}), False),
        "8UC3": (raw(lambda i: {"pixels": drive.colour(i), "encoding": "8UC3"}), False),
        "yuv422": (raw(lambda i: {"pixels": uyvy(drive.grey(i)), "encoding": "yuv422"}), False),
        "bayer": (raw(lambda i: {"pixels": drive.grey(i), "encoding": "bayer_rggb8"}), False),
        "float_in_the_middle": (replaced(raw(), {30: {"pixels": drive.grey(30).astype(np.float32), "encoding": "32FC1"}}),
                                False),
        "all_float": (raw(lambda i: {"pixels": drive.grey(i).astype(np.float32), "encoding": "32FC1"}), False),
        "step_that_wraps": (replaced(raw(), {30: {"step": 71582789}, 60: {"step": 4294967295}}), False),
        "step_too_small": (replaced(raw(), {30: {"step": 7}}), False),
        "height_beyond_data": (replaced(raw(), {0: {"size": (61, 160)}, 30: {"size": (60000, 60000)}}), False),
        "truncated_jpeg": (one_file(lambda i: jpeg(drive.grey(i))[:600]), True),
        "truncated_behind_thumbnail": (one_file(lambda i: with_thumbnail(jpeg(drive.grey(i)))[:-200]), True),
        "truncated_png": (one_file(lambda i: png(drive.grey(i))[:-40]), True),
        "empty_file": (one_file(lambda i: b""), True),
        "noise_for_a_file": (one_file(lambda i: noise.bytes(900)), True),
        "bitmap_for_a_file": (one_file(lambda i: cv2.imencode(".bmp", drive.grey(i))[1].tobytes()), True),
        "medical_image": (one_file(lambda i: bytes(128) + b"DICM"), True),
        "huge_png": (one_file(lambda i: huge_png()), True),
        "first_unreadable": (replaced(files(), {0: {"data": b"x"}, 1: {"data": b""}}), True),
        "all_unreadable": (files(lambda pixels: jpeg(pixels)[:300]), True),
        "odd_sizes": (replaced(raw(), odd), True),
        "odd_size_first": (replaced(raw(), {0: {"pixels": cv2.resize(drive.grey(0), (80, 60))}}), True),
        "smaller_than_template_first": (replaced(raw(), {0: {"pixels": drive.grey(0)[:4, :10]}}), True),
        "turned_by_tag": (files(lambda pixels: with_orientation(jpeg(pixels), 6)), True),
        "late": (swapped_with_next(raw(), (10, 50, 90)), False),
        "repeated_stamps": (replaced(raw(), {i: {"at": harness.frame_stamp(i - 1)} for i in (10, 11, 50)}), False),
        "all_stamps_zero": (replaced(raw(), {i: {"at": 0} for i in range(FRAMES)}), False),
        "unstamped": (replaced(raw(), {i: {"at": 0} for i in (0, 10, 50)}), False),
        "looped": (replaced(raw(), {i: {"at": harness.frame_stamp(i - 50)} for i in range(50, FRAMES)}), False),
        "clock_set_back": (replaced(raw(), {i: {"at": harness.frame_stamp(i) - SECOND // 2} for i in range(50, FRAMES)}),
                           False),
        "frozen": (replaced(raw(), {i: {"pixels": drive.grey(30)} for i in range(30, 40)}), True),
        "dark": (replaced(raw(), {i: {"pixels": np.full_like(drive.grey(i), 3)} for i in range(20, 30)}), True),
        "white_from_the_start": (replaced(raw(), {i: {"pixels": np.full_like(drive.grey(i), 252)} for i in range(10)}),
                                 True),
        "dark_with_noise": (replaced(raw(), {i: {"pixels": noise.randint(2, 7, drive.grey(i).shape).astype(np.uint8)}
                                             for i in range(20, 30)}), True),
        "covered": (replaced(raw(), {i: {"pixels": np.hstack([np.full((harness.HEIGHT, 107), 20, np.uint8),
                                                              drive.grey(i)[:, 107:]])} for i in range(20, 30)}), True),
        "gap": ([shot for i, shot in enumerate(raw()) if not 30 <= i < 50], True),
    }


def write_bag(path, shots):
    with rosbag.Bag(path, "w") as bag:
        for index, shot in enumerate(shots):
            arrival = harness.stamp(harness.frame_stamp(index))
            if shot.data is None:
                bag.write(ROOT + "/camera/image", shot.raw(), arrival)
            else:
                bag.write(ROOT + "/camera/image/compressed", shot.compressed(), arrival)


def write_folder(path, shots):
    os.makedirs(path + "/image_0")
    with open(path + "/times.txt", "w", encoding="ascii") as times:
        for index, shot in enumerate(shots):
            data = png(shot.pixels) if shot.data is None else shot.data
            ending = "png" if shot.data is None else "jpg"
            with open(f"{path}/image_0/{index:06d}.{ending}", "wb") as file:
                file.write(data)
            times.write(f"{shot.at // SECOND}.{shot.at % SECOND:09d}\n")


def main():
    out = sys.argv[1]
    os.makedirs(out, exist_ok=True)
    for name, (shots, as_folder) in kinds().items():
        write_bag(f"{out}/{name}.bag", shots)
        if as_folder:
            write_folder(f"{out}/{name}", shots)


if __name__ == "__main__":
    main()
