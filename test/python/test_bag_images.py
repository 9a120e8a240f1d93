"""Images in the bags that the tools write: the pixels that ratslam_run takes from the same files."""

import subprocess

import numpy as np
import pytest

rosbag = pytest.importorskip("rosbag")
cv2 = pytest.importorskip("cv2")

from conftest import built  # noqa: E402
from test_bags import CALIBRATION, messages, recording, sequence, write_image  # noqa: E402,F401  (fixtures among them)
from ratslam_tools.cli import kitti_to_bag, recorder_to_bag  # noqa: E402
from ratslam_tools.datasets import images  # noqa: E402
from ratslam_tools.errors import InputError  # noqa: E402
from ratslam_tools.runs import suggestion  # noqa: E402


def pixels_of(message):
    values = np.frombuffer(message.data, np.dtype("<u2") if message.encoding == "mono16" else np.uint8)
    return values.reshape(message.height, message.width, -1)


def twelve_bits(path, seed, size=(48, 64)):
    values = np.random.default_rng(seed).integers(0, 4096, size, dtype=np.uint16)
    path.write_bytes(cv2.imencode(".png", values)[1].tobytes())  # what it is, its bytes say
    return values


def test_images_of_12_bits_keep_them(sequence, tmp_path):
    written = [twelve_bits(sequence / "image_0" / f"{frame:06d}.png", frame) for frame in range(6)]
    kitti_to_bag.main([str(sequence), str(tmp_path / "k.bag")])
    found = [message for message, _ in messages(tmp_path / "k.bag", "/kitti/camera/image")]
    assert [(message.encoding, message.step, message.is_bigendian) for message in found] == [("mono16", 128, 0)] * 6
    for message, values in zip(found, written):
        np.testing.assert_array_equal(pixels_of(message)[:, :, 0], values)


def test_colours_of_16_bits_get_8_as_in_a_run(sequence, tmp_path):
    values = np.random.default_rng(1).integers(0, 65536, (48, 64, 4), dtype=np.uint16)
    (sequence / "image_0").rename(sequence / "image_2")
    (sequence / "calib.txt").write_text("P2: 50 0 31 0 0 51 23 0 0 0 1 0\n")
    for frame in range(6):
        cv2.imwrite(str(sequence / "image_2" / f"{frame:06d}.png"), values)
    kitti_to_bag.main([str(sequence), str(tmp_path / "k.bag"), "--camera", "2"])
    message, _ = messages(tmp_path / "k.bag", "/kitti/camera/image")[0]
    assert message.encoding == "bgr8"
    np.testing.assert_array_equal(pixels_of(message), np.rint(values[:, :, :3] / 257.0))


def test_turned_images_of_12_bits_keep_them(recording, tmp_path):
    written = [twelve_bits(path, 5) for path in sorted((recording / "images").iterdir()) if b"JFIF" in path.read_bytes()[:20]]
    calibration = tmp_path / "phone.yaml"
    calibration.write_text(CALIBRATION.replace("64", "N").replace("48", "64").replace("N", "48"))
    recorder_to_bag.main([str(recording), str(tmp_path / "t.bag"), "--calibration", str(calibration), "--rotate", "90"])
    message, _ = messages(tmp_path / "t.bag", "/nn/camera/image/compressed")[0]
    assert message.format == "png"
    decoded = cv2.imdecode(np.frombuffer(message.data, np.uint8), cv2.IMREAD_UNCHANGED)
    np.testing.assert_array_equal(decoded, np.rot90(written[0], -1))


def test_images_with_few_bits_are_as_bright_as_a_run_sees_them(sequence):
    """suggest_parameters looks for the part of the image that shows something."""
    written = [twelve_bits(sequence / "image_0" / f"{frame:06d}.png", frame) for frame in range(6)]
    for found, values in zip(suggestion.sample_images(str(sequence), 6), written):
        assert found.dtype == np.uint8
        np.testing.assert_array_equal(found, values >> 4)


def test_runs_on_the_folder_and_on_its_bag_agree(sequence, tmp_path):
    (program,) = built()
    for frame in range(6):
        twelve_bits(sequence / "image_0" / f"{frame:06d}.png", frame)
    kitti_to_bag.main([str(sequence), str(tmp_path / "k.bag")])
    config, left = tmp_path / "small.yaml", []
    config.write_text("template_x_size: 16\ntemplate_y_size: 8\nvt_shift_match: 2\nimage_crop_y_min: 0\n")
    for source in (sequence, tmp_path / "k.bag"):
        out = tmp_path / f"run_{len(left)}"
        words = [program, str(source), "--config", str(config), "--odometry", "profile", "--out", str(out)]
        subprocess.run(words, check=False, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        left.append((out / "templates.csv").read_bytes())
    assert left[0] == left[1] and left[0].count(b"\n") == 7


def test_bits_are_those_of_the_brightest_image():
    few, more = np.full((2, 2), 200, np.uint16), np.full((2, 2), 4000, np.uint16)
    assert [image.max() for image in images.with_eight_bits([few, more, few.astype(np.uint8)])] == [12, 250, 200]
    assert [image.max() for image in images.with_eight_bits([few])] == [200]


def test_images_that_a_run_leaves_out_are_counted(sequence, tmp_path, capsys):
    """One is corrupt and one of another size, which the camera's calibration is not of."""
    (sequence / "image_0" / "000002.png").write_bytes((sequence / "image_0" / "000002.png").read_bytes()[:500])
    write_image(sequence / "image_0" / "000004.png", 4, (24, 32))
    kitti_to_bag.main([str(sequence), str(tmp_path / "k.bag")])
    told = capsys.readouterr().out
    assert "k.bag: 5 images" in told and "note: images left out because they cannot be read: 1; the first: " in told
    assert "note: images of another size than 64x48, the calibration's: 1; the first: " in told
    assert "000002.png: not a readable image" in told and "000004.png: 32x24" in told
    found = messages(tmp_path / "k.bag", "/kitti/camera/image")
    assert [(image.width, image.header.seq) for image, _ in found] == [(64, 0), (64, 1), (64, 3), (32, 4), (64, 5)]
    assert {info.width for info, _ in messages(tmp_path / "k.bag", "/kitti/camera/camera_info")} == {64}
    assert len(messages(tmp_path / "k.bag", "/kitti/ground_truth")) == 6


def test_times_in_milliseconds_are_named(sequence, tmp_path, capsys):
    (sequence / "times.txt").write_text("".join(f"{100 * frame}\n" for frame in range(6)))
    kitti_to_bag.main([str(sequence), str(tmp_path / "k.bag")])
    assert "times.txt: its times lie 100 s apart; are they milliseconds? They are taken as seconds" in capsys.readouterr().out
    (sequence / "times.txt").write_text("".join(f"{frame}\n" for frame in range(6)))
    kitti_to_bag.main([str(sequence), str(tmp_path / "k.bag")])
    assert "are they milliseconds" not in capsys.readouterr().out


def test_messages_of_another_type_among_the_images_of_a_bag_are_skipped(sequence, tmp_path):
    from rospy import Time
    from std_msgs.msg import String

    kitti_to_bag.main([str(sequence), str(tmp_path / "k.bag"), "--compressed"])
    topic = "/kitti/camera/image/compressed"
    with rosbag.Bag(str(tmp_path / "k.bag"), "a") as bag:
        bag.write(topic, String("x"), Time(0, 150000000))
    assert len(suggestion.sample_images(str(tmp_path / "k.bag"), 100)) == 6
    with rosbag.Bag(str(tmp_path / "s.bag"), "w") as bag:
        connection = next(iter(rosbag.Bag(str(tmp_path / "k.bag"))._get_connections([topic])))
        bag.write(topic, String("x"), Time(1), connection_header=connection.header)
    with pytest.raises(InputError, match="no image can be read: its messages are damaged or of another type"):
        suggestion.sample_images(str(tmp_path / "s.bag"), 100)
