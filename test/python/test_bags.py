"""KITTI folders and recordings as bags, read back with the rosbag API."""

import os

import numpy as np
import pytest

rosbag = pytest.importorskip("rosbag")
cv2 = pytest.importorskip("cv2")

from ratslam_tools.cli import kitti_to_bag, recorder_to_bag  # noqa: E402
from ratslam_tools.datasets import bags, recorder, truth  # noqa: E402
from ratslam_tools.trajectory import frames  # noqa: E402
from ratslam_tools.errors import InputError  # noqa: E402
from ratslam_tools.trajectory import read_trajectory, write_kitti  # noqa: E402

CALIBRATION = """# by hand
image_width: 64
image_height: 48
fx: 50.5
fy: 51.5
cx: 31
cy: 23.5
k1: -0.2   # radial
p2: 0.001
"""


def write_image(path, seed, size=(48, 64)):
    cv2.imwrite(str(path), np.random.default_rng(seed).integers(0, 255, size, dtype=np.uint8))


def messages(path, topic):
    with rosbag.Bag(str(path)) as bag:
        return [(message, time.to_nsec()) for _, message, time in bag.read_messages(topics=[topic])]


@pytest.fixture
def sequence(tmp_path, drive):
    """A KITTI sequence of six frames with odd times."""
    folder = tmp_path / "sequences" / "07"
    (folder / "image_0").mkdir(parents=True)
    (tmp_path / "poses").mkdir()
    for frame in range(6):
        write_image(folder / "image_0" / f"{frame:06d}.png", frame)
    times = [0.0, 1.037359e-01, 2.073381e-01, 3.1e-01, 4.123456789e-01, 5.0e-01]
    (folder / "times.txt").write_text("".join(f"{time:.12e}\n" for time in times))
    (folder / "calib.txt").write_text("P0: 50 0 31 0 0 51 23 0 0 0 1 0\nP1: 50 0 31 -20 0 51 23 0 0 0 1 0\n")
    write_kitti(tmp_path / "poses" / "07.txt", frames.convert(drive(6), "base", "camera"))
    return folder


def test_images_stamps_and_camera_survive(sequence, tmp_path, drive):
    kitti_to_bag.main([str(sequence), str(tmp_path / "k.bag"), "--root", "town"])
    images = messages(tmp_path / "k.bag", "/town/camera/image")
    assert [message.header.stamp.to_nsec() for message, _ in images] == [
        0,
        103735900,
        207338100,
        310000000,
        412345679,
        500000000,
    ]
    assert [time for _, time in images] == [1000, 103735900, 207338100, 310000000, 412345679, 500000000]
    pixels = np.frombuffer(images[3][0].data, dtype=np.uint8).reshape(48, 64)
    np.testing.assert_array_equal(
        pixels, cv2.imread(str(sequence / "image_0" / "000003.png"), cv2.IMREAD_GRAYSCALE)
    )
    assert images[0][0].encoding == "mono8"
    info, _ = messages(tmp_path / "k.bag", "/town/camera/camera_info")[2]
    assert (info.width, info.height, info.distortion_model, list(info.D)) == (64, 48, "plumb_bob", [0] * 5)
    assert list(info.K) == [50, 0, 31, 0, 51, 23, 0, 0, 1] and list(info.P) == [
        50,
        0,
        31,
        0,
        0,
        51,
        23,
        0,
        0,
        0,
        1,
        0,
    ]
    ((static, _),) = messages(tmp_path / "k.bag", "/tf_static")
    assert (static.transforms[0].header.frame_id, static.transforms[0].child_frame_id) == (
        "base_link",
        "camera",
    )
    found = bags.read_trajectory_topic(str(tmp_path / "k.bag"), "/town/ground_truth")
    np.testing.assert_allclose(found.positions, drive(6).positions, atol=1e-6)
    assert frames.convention(found) == "base"
    np.testing.assert_allclose(
        truth.read_truth(str(tmp_path / "k.bag")).positions, truth.read_truth(str(sequence)).positions
    )


def test_compressed_images_keep_their_bytes_and_frames_can_be_cut(sequence, tmp_path):
    odometry = tmp_path / "odometry.csv"
    odometry.write_text(
        "frame,stamp,linear_x,angular_z\n" + "".join(f"{i},{0.1 * i},{i},0.5\n" for i in range(6))
    )
    kitti_to_bag.main(
        [
            str(sequence),
            str(tmp_path / "c.bag"),
            "--compressed",
            "--start",
            "2",
            "--end",
            "5",
            "--odometry",
            str(odometry),
            "--odometry_offset",
            "0.05",
        ]
    )
    images = messages(tmp_path / "c.bag", "/kitti/camera/image/compressed")
    assert len(images) == 3
    assert (
        images[0][0].data == (sequence / "image_0" / "000002.png").read_bytes()
        and images[0][0].format == "png"
    )
    odometry_read = [message for message, _ in messages(tmp_path / "c.bag", "/kitti/odom")]
    assert [message.twist.twist.linear.x for message in odometry_read] == [2, 3, 4]
    assert [message.header.stamp.to_nsec() for message in odometry_read] == [250000000, 350000000, 450000000]
    assert odometry_read[0].child_frame_id == "base_link"


def test_times_of_images_that_are_missing_are_said(sequence, tmp_path, capsys):
    os.remove(sequence / "image_0" / "000003.png")
    kitti_to_bag.main([str(sequence), str(tmp_path / "m.bag")])
    assert "note: " in capsys.readouterr().out and len(messages(tmp_path / "m.bag", "/kitti/camera/image")) == 5


def test_focal_lengths_that_no_camera_has_are_refused(sequence, tmp_path):
    for focal in ("1e308", "1e-310", "-5"):
        (sequence / "calib.txt").write_text(f"P0: {focal} 0 3 0 0 {focal} 2 0 0 0 1 0\n")
        with pytest.raises(InputError, match="focal lengths .* must lie within 0.001 to 1e6"):
            kitti_to_bag.main([str(sequence), str(tmp_path / "f.bag")])


def test_root_may_be_empty(sequence, tmp_path):
    kitti_to_bag.main([str(sequence), str(tmp_path / "r.bag"), "--root", "", "--end", "1"])
    assert len(messages(tmp_path / "r.bag", "/camera/image")) == 1


def test_topics_that_ros_cannot_have_and_odometry_of_another_time_are_refused(sequence, tmp_path):
    for root in ("a b", "2x", "a//b", "robot-1"):
        with pytest.raises(InputError, match="--root: .* is no name of ROS"):
            kitti_to_bag.main([str(sequence), str(tmp_path / "r.bag"), "--root", root])
    (tmp_path / "late.csv").write_text("frame,stamp,linear_x,angular_z\n0,3600,1,0\n1,3600.1,1,0\n")
    with pytest.raises(InputError, match="late.csv: all of it lies outside the images' time: 3600 to 3600.1 s"):
        kitti_to_bag.main([str(sequence), str(tmp_path / "r.bag"), "--odometry", str(tmp_path / "late.csv")])
    assert not (tmp_path / "r.bag").exists()


def test_frames_and_offsets_that_no_drive_has_are_refused(sequence, tmp_path):
    for end in ("-1", "0"):
        with pytest.raises(InputError, match=f"frames 0 to {end}: the drive has 6"):
            kitti_to_bag.main([str(sequence), str(tmp_path / "f.bag"), "--end", end])
    odometry = tmp_path / "odometry.csv"
    odometry.write_text("frame,stamp,linear_x,angular_z\n0,0,1,0\n1,0.1,1,0\n")
    for offset in ("1e300", "-0.05", "5e9"):
        with pytest.raises(InputError, match="odometry.csv: with --odometry_offset .* its stamps are .* ROS can hold 0 to"):
            kitti_to_bag.main([str(sequence), str(tmp_path / "f.bag"), "--odometry", str(odometry), f"--odometry_offset={offset}"])


def test_no_file_but_a_bag_is_replaced_by_a_bag(sequence, tmp_path):
    calibration = (sequence / "calib.txt").read_bytes()
    with pytest.raises(InputError, match="calib.txt: not overwritten: the file exists and is no bag"):
        kitti_to_bag.main([str(sequence), str(sequence / "calib.txt")])
    assert (sequence / "calib.txt").read_bytes() == calibration
    with pytest.raises(InputError, match="it names no file"):
        kitti_to_bag.main([str(sequence), ""])
    (tmp_path / "new.bag").touch()
    for _ in range(2):
        kitti_to_bag.main([str(sequence), str(tmp_path / "new.bag")])
    assert len(messages(tmp_path / "new.bag", "/kitti/camera/image")) == 6


def test_a_broken_sequence_leaves_no_bag(sequence, tmp_path):
    with pytest.raises(InputError, match="none of its 2 images is readable; the first: .*000001.png: not a readable image"):
        for frame in (1, 2):
            (sequence / "image_0" / f"00000{frame}.png").write_bytes(b"no png")
        kitti_to_bag.main([str(sequence), str(tmp_path / "b.bag"), "--start", "1", "--end", "3"])
    assert not [name for name in os.listdir(tmp_path) if ".bag" in name]
    times = (sequence / "times.txt").read_text().splitlines(True)
    (sequence / "times.txt").write_text("".join(times[:5]))
    with pytest.raises(InputError, match="5 times for 6 images"):
        kitti_to_bag.main([str(sequence), str(tmp_path / "b.bag")])
    with pytest.raises(InputError, match="frames 9 to"):
        (sequence / "times.txt").write_text("".join(times))
        os.remove(tmp_path / "poses" / "07.txt")
        kitti_to_bag.main([str(sequence), str(tmp_path / "b.bag"), "--start", "9"])


def test_bags_that_are_none(tmp_path):
    (tmp_path / "no.bag").write_bytes(b"not a bag")
    with pytest.raises(InputError, match="not a readable bag"):
        bags.read_trajectory_topic(str(tmp_path / "no.bag"), "/odom")
    for name, begin in (("a.db3", b"SQLite format 3\0"), ("a.mcap", b"\x89MCAP0\r\n")):
        (tmp_path / name).write_bytes(begin + bytes(100))
        with pytest.raises(InputError, match="not a readable bag: .*ROS 2.*rosbags-convert"):
            bags.read_trajectory_topic(str(tmp_path / name), "/odom")


def test_a_bag_that_was_cut_names_what_mends_it(sequence, tmp_path):
    whole, cut = tmp_path / "whole.bag", tmp_path / "cut.bag"
    kitti_to_bag.main([str(sequence), str(whole)])
    cut.write_bytes(whole.read_bytes()[:-200])
    with pytest.raises(InputError, match=f"a record at byte .*; rosbag reindex {cut} keeps the chunks that are whole"):
        bags.read_trajectory_topic(str(cut), "/kitti/ground_truth")


def test_missing_topic_lists_those_there_are(sequence, tmp_path):
    kitti_to_bag.main([str(sequence), str(tmp_path / "k.bag")])
    with pytest.raises(InputError, match="no topic /odom; it has: .*/kitti/ground_truth"):
        bags.read_trajectory_topic(str(tmp_path / "k.bag"), "/odom")
    with pytest.raises(InputError, match="carries no stamped poses"):
        bags.read_trajectory_topic(str(tmp_path / "k.bag"), "/kitti/camera/camera_info")


def test_raw_drive_gives_truth_from_oxts(tmp_path):
    day = tmp_path / "2011_09_26"
    folder = day / "drive"
    for name in ("image_00/data", "oxts/data"):
        (folder / name).mkdir(parents=True)
    (day / "calib_cam_to_cam.txt").write_text(
        "calib_time: 09-Jan-2012 13:57:47\nP_rect_00: 50 0 31 0 0 51 23 0 0 0 1 0\n"
    )
    stamps = "".join(f"2011-09-26 13:02:{25 + i}.96438944{i}\n" for i in range(4))
    for name in ("image_00", "oxts"):
        (folder / name / "timestamps.txt").write_text(stamps)
    for frame in range(4):
        write_image(folder / "image_00" / "data" / f"{frame:010d}.png", frame)
        # Northwards: yaw 90 degrees from east; 1e-5 degrees of latitude are 1.113 m on KITTI's sphere.
        words = [49 + 1e-5 * frame, 8.4, 116.0, 0.0, 0.0, np.pi / 2] + [0] * 24
        (folder / "oxts" / "data" / f"{frame:010d}.txt").write_text(" ".join(map(repr, words)))
    kitti_to_bag.main([str(folder), str(tmp_path / "raw.bag"), "--root", "raw"])
    found = bags.read_trajectory_topic(str(tmp_path / "raw.bag"), "/raw/ground_truth")
    np.testing.assert_allclose(
        found.positions, np.outer(range(4), [6378137 * np.radians(1e-5), 0, 0]), atol=1e-5
    )
    image, _ = messages(tmp_path / "raw.bag", "/raw/camera/image")[1]
    assert image.header.stamp.to_nsec() == 1317042146964389441


@pytest.fixture
def recording(tmp_path):
    """A recorder's folder with a name full of traps, a missing image, repeats, jitter and bad fixes."""
    folder = tmp_path / "23-05-14 10:31:07"
    (folder / "images").mkdir(parents=True)
    times = [1684060267000, 1684060267107, 1684060267195, 1684060267301]
    for index, time in enumerate(times):
        write_image(folder / "images" / f"{time}.jpeg", index)
    lines = [f"{time},images/{time}.jpeg" for time in times]
    lines += [lines[1], "1684060267400,images/1684060267400.jpeg", "garbage"]
    (folder / "data_image.txt").write_text("\n".join(lines) + "\n")
    (folder / "data_imu.txt").write_text(
        "1684060267000,0.1,9.8,0.2,0.01,0.02,0.03\n1684060267000,0.2,9.8,0.2,0.01,0.02,0.03\n"
        "1684060267010,0.3,9.8,0.2,0.01,0.02,0.03\n1684060267005,0.4,9.8,0.2,0,0,nan\n"
    )
    fixes = [
        f"{1684060267000 + 1000 * i},{55.0},{82.9 + 1e-4 * i},150.0,{accuracy},90.0,6.4,gps"
        for i, accuracy in enumerate([4.0, 60.0, 5.0, 0.0, 6.0])
    ]
    (folder / "data_gps.txt").write_text("\n".join(fixes + ["1684060272000,0.0,0.0,0,5,0,0,gps"]) + "\n")
    (tmp_path / "phone.yaml").write_text(CALIBRATION)
    return folder


def test_recording_as_a_bag(recording, tmp_path, capsys):
    bag, calibration, gps = str(tmp_path / "n.bag"), str(tmp_path / "phone.yaml"), str(tmp_path / "gps.tum")
    recorder_to_bag.main([str(recording), bag, "--calibration", calibration, "--gps_tum", gps])
    images = messages(bag, "/nn/camera/image/compressed")
    assert [time for _, time in images] == [
        ms * 10**6 for ms in (1684060267000, 1684060267107, 1684060267195, 1684060267301)
    ]
    assert images[1][0].data == (recording / "images" / "1684060267107.jpeg").read_bytes()
    info, _ = messages(bag, "/nn/camera/camera_info")[0]
    assert list(info.D) == [-0.2, 0, 0, 0.001, 0] and info.K[4] == 51.5
    stamps = [time for _, time in messages(bag, "/nn/imu")]
    assert stamps == [1684060267000000000, 1684060267000500000, 1684060267010000000]
    fixes = messages(bag, "/nn/gps")
    assert len(fixes) == 5 and fixes[0][0].position_covariance[0] == pytest.approx(
        (4.0 / 1.51) ** 2, rel=0.01
    )
    track = read_trajectory(gps)
    assert len(track) == 3
    # 2e-4 degrees of longitude at 55 degrees north on WGS-84: 111.32 km * cos(55) * 1.00227 a degree.
    np.testing.assert_allclose(track.positions[1], [12.797, 0, 0], atol=0.01)
    assert frames.convention(track) == "base"
    found = bags.read_trajectory_topic(bag, "/nn/ground_truth")
    np.testing.assert_allclose(found.positions, track.positions, atol=1e-6)
    notes = capsys.readouterr().out
    for note in (
        "missing image file: 1",
        "image with a repeated stamp: 1",
        "malformed image line: 1",
        "IMU sample that is no number: 1",
        "GPS fix without a position: 1",
    ):
        assert note in notes


def test_rotation_turns_the_pixels(recording, tmp_path):
    (tmp_path / "phone.yaml").write_text(
        CALIBRATION.replace("width: 64", "width: 48").replace("height: 48", "height: 64")
    )
    path = recording / "images" / "1684060267000.jpeg"
    image = np.zeros((48, 64), dtype=np.uint8)
    image[:10, :10] = 250
    cv2.imwrite(str(path), image)
    recorder_to_bag.main(
        [
            str(recording),
            str(tmp_path / "t.bag"),
            "--calibration",
            str(tmp_path / "phone.yaml"),
            "--rotate",
            "90",
        ]
    )
    message, _ = messages(tmp_path / "t.bag", "/nn/camera/image/compressed")[0]
    turned = cv2.imdecode(np.frombuffer(message.data, dtype=np.uint8), cv2.IMREAD_GRAYSCALE)
    assert turned.shape == (64, 48) and turned[:8, -8:].mean() > 200 and turned[:8, :8].mean() < 30


def test_calibration_of_another_camera_is_refused(recording, tmp_path):
    (tmp_path / "phone.yaml").write_text(CALIBRATION.replace("64", "1280"))
    with pytest.raises(InputError, match="64x48 px; the calibration is of 1280x48"):
        recorder_to_bag.main(
            [str(recording), str(tmp_path / "x.bag"), "--calibration", str(tmp_path / "phone.yaml")]
        )
    for text, words in (
        ("fz: 3\n", "unknown key fz"),
        ("fx: 0\n", "fx: 0 is not allowed"),
        ("fx: wide\n", "not a finite"),
    ):
        lines = [line for line in CALIBRATION.splitlines(True) if not line.startswith(text.split(":")[0])]
        (tmp_path / "phone.yaml").write_text("".join(lines) + text)
        with pytest.raises(InputError, match=words):
            recorder_to_bag.main(
                [str(recording), str(tmp_path / "x.bag"), "--calibration", str(tmp_path / "phone.yaml")]
            )


def test_older_recordings(recording):
    (recording / "data_imu.txt").rename(recording / "imu_data.txt")
    (recording / "data_gps.txt").rename(recording / "gps_data.txt")
    (recording / "data_image.txt").unlink()
    for path in (recording / "images").iterdir():
        path.rename(path.with_name(path.stem + "000123.jpeg"))
    found = recorder.read(str(recording))
    assert found.image_stamps[0] == 1684060267000000123 and len(found.images) == 4
    assert len(found.gps) == 5 and len(found.imu) == 3


def test_folders_that_are_no_recording(tmp_path, fails):
    (tmp_path / "phone.yaml").write_text(CALIBRATION)
    assert "no images" in fails(
        "recorder_to_bag", tmp_path, tmp_path / "x.bag", "--calibration", tmp_path / "phone.yaml"
    )


def test_a_recording_of_images_alone_is_a_bag_as_well(recording, tmp_path):
    for name in ("data_imu.txt", "data_gps.txt"):
        (recording / name).unlink()
    recorder_to_bag.main([str(recording), str(tmp_path / "n.bag"), "--calibration", str(tmp_path / "phone.yaml")])
    assert len(messages(tmp_path / "n.bag", "/nn/camera/image/compressed")) == 4


def test_files_of_a_recording_are_not_overwritten_by_its_track(recording, tmp_path):
    phone = str(tmp_path / "phone.yaml")
    reads = [str(recording / "data_gps.txt"), phone, recorder.read(str(recording)).images[0]]
    for track, how in [*((track, "read") for track in reads), (str(tmp_path / "n.bag"), "written")]:
        with pytest.raises(InputError, match=f"--gps_tum: .* is {how} as well and would be overwritten"):
            recorder_to_bag.main([str(recording), str(tmp_path / "n.bag"), "--calibration", phone, "--gps_tum", track])
    with pytest.raises(InputError, match="--max_accuracy: -1 is not allowed: above 0 m"):
        recorder_to_bag.main([str(recording), str(tmp_path / "n.bag"), "--calibration", phone, "--max_accuracy", "-1"])


def test_damaged_bags_are_refused_in_one_line(sequence, tmp_path):
    kitti_to_bag.main([str(sequence), str(tmp_path / "k.bag")])
    whole = (tmp_path / "k.bag").read_bytes()
    at = whole.index(b"size=") + len(b"size=")
    for change, words in (
        (whole[:at] + b"\xf0\xff\xff\xff" + whole[at + 4 :], "claims 4294967280"),
        (whole[: len(whole) // 2], "beyond the file's end"),
        (b"#ROSBAG V9\n" + whole[13:], "does not begin with"),
        (whole.replace(b"nav_msgs/Odometry", b"nav_msgs/Odom\xffry"), "damaged"),
    ):
        (tmp_path / "d.bag").write_bytes(change)
        with pytest.raises(InputError, match=words):
            bags.read_trajectory_topic(str(tmp_path / "d.bag"), "/kitti/ground_truth")
    os.mkfifo(tmp_path / "pipe.bag")
    with pytest.raises(InputError, match="no regular file"):
        bags.read_trajectory_topic(str(tmp_path / "pipe.bag"), "/kitti/ground_truth")
