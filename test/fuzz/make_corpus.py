#!/usr/bin/env python3
"""Writes the corpus from which fuzzing starts: test/fuzz/make_corpus.py CORPUS

A well-formed input or two for each target; what fuzzing found lies beside them under names of its own (found_*).
"""
import pathlib
import struct
import sys
import tempfile
import zlib

def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


PNG = (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", 1, 1, 8, 0, 0, 0, 0))
       + chunk(b"IDAT", zlib.compress(b"\0\x80")) + chunk(b"IEND", b""))
JPEG_START = bytes.fromhex("ffd8ffe000104a46494600010100000100010000")
ODOMETRY_HEADER = "frame,stamp,linear_x,angular_z"


def odometry_message(seconds):
    header = struct.pack("<III", 1, seconds, 0) + struct.pack("<I", 4) + b"odom"
    return header + struct.pack("<I", 0) + struct.pack("<7d", 0, 0, 0, 0, 0, 0, 1) + bytes(36 * 8) + \
        struct.pack("<6d", 1.0, 0, 0, 0, 0, 0.1) + bytes(36 * 8)


def view_message(seconds):
    return struct.pack("<III", 1, seconds, 0) + struct.pack("<I", 0) + struct.pack("<Id", 0, 0.0)


def action_message(seconds):
    return struct.pack("<III", 1, seconds, 0) + struct.pack("<I", 0) + struct.pack("<IIId", 1, 0, 0, 0.0)


def framed(kind, message):
    return struct.pack("<BH", kind, len(message)) + message


def corpus():
    yield "ini", "config", ("[general]\ntopic_root=irat_red\n[ratslam]\nimage_crop_x_min=40\ntemplate_x_size=60\n"
                            "template_y_size=10\nvt_shift_match=5\n[draw]\nenable=1\n").encode()
    yield "yaml", "config", b"template_x_size: 60\ntemplate_y_size: 10\nvt_match_threshold: 0.04  # mean\nvt_panoramic: false\n"
    yield "kitti_times", "times", b"0.000000e+00\n1.036e-01\n"
    yield "kitti_calib", "calib", b"P0: 718.856 0 607.1928 0 0 718.856 185.2157 0 0 0 1 0\n"
    yield "kitti_poses", "poses", b"1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0.1 0 1 0 0 0 0 1 0.9\n"
    yield "odometry_csv", "twist", (ODOMETRY_HEADER + "\n0,1.5,0.3,-0.1\n1,1.6,0.3,0.2\n").encode()
    yield "odometry_csv", "pose", (ODOMETRY_HEADER + ",r11,r12,r13,x,r21,r22,r23,y,r31,r32,r33,z\n"
                                   "0,1.5,0.3,-0.1,1,0,0,0,0,1,0,0,0,0,1,0\n").encode()
    yield "recorder", "index", b"1000,images/1000.jpeg\n2000,images/2000.jpeg\n"
    yield "calibration", "phone", (b"image_width: 640\nimage_height: 480\nfx: 500.0\nfy: 500.0\ncx: 320\ncy: 240\n"
                                   b"k1: 0.1\nk2: 0.0\np1: 0\np2: 0\nk3: 0\n")
    yield "state", "empty", bytes(16)
    yield "map_file", "head", b"SQLite format 3\x00" + struct.pack(">HBBBBBB", 4096, 1, 1, 0, 64, 32, 32) + bytes(76)
    yield "stamp", "seconds", b"1317384506.409999872"
    yield "stamp", "exponent", b"1.5e3"
    yield "pose_cell_stage", "drive", bytes(range(256)) * 2
    yield "map_stage", "drive", bytes([1]) + bytes((7 * i) % 251 for i in range(600))
    yield "views", "greys", bytes([16, 16, 0, 0]) + bytes((i * i) % 256 for i in range(256))
    yield "image", "mono8", bytes([0, 4, 4, 4, 0, 0]) + bytes(range(16))
    yield "image", "bgr8", bytes([2, 2, 2, 6, 0, 0]) + bytes(range(12))
    yield "compressed_image", "png", b"\x01" + PNG
    yield "compressed_image", "jpeg", b"\x00" + JPEG_START
    yield "camera_info", "pinhole", bytes([0]) + struct.pack("<HHB", 64, 48, 5) + bytes(5) + bytes([50, 0, 3, 0, 50, 2, 0, 0, 0])
    yield "events", "drive", b"".join(framed(0, odometry_message(s)) + framed(1, view_message(s)) + framed(2, action_message(s))
                                      for s in range(10, 14))
    yield "bag", "head", b"#ROSBAG V2.0\n"
    for name, compression in (("whole", "none"), ("packed_bz2", "bz2"), ("packed_lz4", "lz4")):
        yield "bag", name, whole_bag(compression)


def whole_bag(compression):
    """Two small images: the definitions of other types would make it several times as large."""
    import rosbag
    import rospy
    from sensor_msgs.msg import Image
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "drive.bag"
        with rosbag.Bag(str(path), "w", compression=compression) as bag:
            for second in (1, 2):
                message = Image(width=8, height=6, step=8, encoding="mono8", data=bytes(range(48)))
                message.header.stamp = rospy.Time(second)
                bag.write("/camera/image", message, rospy.Time(second))
        return path.read_bytes()


def main(folder):
    for target, name, content in corpus():
        path = pathlib.Path(folder) / target / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)


if __name__ == "__main__":
    main(sys.argv[1])
