"""What the playback looks up in a bag before it plays it."""

import pytest

rosbag = pytest.importorskip("rosbag")
pytest.importorskip("rospy")

from sensor_msgs.msg import CompressedImage, Image  # noqa: E402
from std_msgs.msg import Header, String  # noqa: E402
import rospy  # noqa: E402

from ratslam_tools.datasets import played_bag  # noqa: E402
from ratslam_tools.errors import InputError  # noqa: E402

TOPIC = "/cam/image/compressed"


def connection(kind):
    return {"topic": TOPIC, "type": kind._type, "md5sum": kind._md5sum, "message_definition": kind._full_text, "callerid": kind._type}


def image(second):
    return CompressedImage(header=Header(stamp=rospy.Time(second)), format="jpeg", data=b"x" * 100)


def write(path, messages, honest):
    """A bag of (second, message). @param honest whether a message of another type says so, which needs a connection of its
    own; rosbag's Python does not make one by itself."""
    with rosbag.Bag(str(path), "w") as bag:
        bag.write(TOPIC, image(100), rospy.Time(100))
        for second, message in messages:
            kind = {"connection_header": connection(type(message))} if honest else {}
            bag.write(TOPIC, message, rospy.Time(second), **kind)


@pytest.mark.parametrize("honest", [True, False])
def test_messages_of_another_type_among_the_images_are_skipped(tmp_path, honest):
    path = tmp_path / "mixed.bag"
    other = [(99, String("first")), (101, image(101)), (102, image(102)), (103, String("x")), (104, String("last"))]
    write(path, other, honest)
    first, last, end, topics = played_bag.look_into(str(path), TOPIC)
    assert (first.secs, last.secs, end) == (100, 102, 104.0) and TOPIC in topics


def test_a_bag_whose_chunks_do_not_lie_in_order_is_played_to_its_end(tmp_path):
    with rosbag.Bag(str(tmp_path / "merged.bag"), "w", chunk_threshold=200) as bag:
        for second in (*range(110, 120), *range(100, 110)):
            bag.write(TOPIC, image(second), rospy.Time(second))
    first, last, end, _ = played_bag.look_into(str(tmp_path / "merged.bag"), TOPIC)
    assert (first.secs, last.secs, end) == (100, 119, 119.0)


def test_images_without_stamps_are_images(tmp_path):
    write(tmp_path / "zero.bag", [(99, CompressedImage()), (101, CompressedImage())], False)
    first, last, _, _ = played_bag.look_into(str(tmp_path / "zero.bag"), TOPIC)
    assert (first.secs, last.secs) == (0, 0)


def test_how_many_were_skipped_is_told(tmp_path, monkeypatch):
    told = []
    monkeypatch.setattr(rospy, "logwarn", lambda text, *words: told.append(text % words))
    write(tmp_path / "mixed.bag", [(101, String("x")), (102, image(102)), (103, String("y"))], False)
    played_bag.look_into(str(tmp_path / "mixed.bag"), TOPIC)
    assert told == [f"{tmp_path / 'mixed.bag'}: {TOPIC}: the first and last image are looked for; messages that are no "
                    "sensor_msgs/CompressedImage, or damaged, were skipped: 1"]


def test_a_topic_without_an_image_is_refused(tmp_path):
    with rosbag.Bag(str(tmp_path / "none.bag"), "w") as bag:
        bag.write(TOPIC, String("x"), rospy.Time(99), connection_header=connection(CompressedImage))
    with pytest.raises(InputError, match=f"none.bag: {TOPIC} holds no readable sensor_msgs/CompressedImage: its messages are"):
        played_bag.look_into(str(tmp_path / "none.bag"), TOPIC)
    with rosbag.Bag(str(tmp_path / "raw.bag"), "w") as bag:
        bag.write(TOPIC, Image(), rospy.Time(99))
    with pytest.raises(InputError, match=f"raw.bag: {TOPIC} holds no sensor_msgs/CompressedImage, but sensor_msgs/Image"):
        played_bag.look_into(str(tmp_path / "raw.bag"), TOPIC)
