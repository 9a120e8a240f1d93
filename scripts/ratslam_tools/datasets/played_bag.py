"""What `playback` needs to know about a bag, and the second bag that `rosbag play` plays after it."""

import tempfile

import rosbag
import rospy
from std_msgs.msg import String

from ratslam_tools.datasets import bags
from ratslam_tools.errors import InputError

LAST_TIME_S = 2.0**32 - 1.0  # the largest time of ROS [s]


def listed(topics):
    """The topics of a bag with their types as part of a sentence: "/a [type], /b [type]", or "no messages at all"."""
    return ", ".join(f"{name} [{info.msg_type}]" for name, info in sorted(topics.items())) or "no messages at all"


def look_into(path, topic):
    """Looks for the images of a topic in a bag. Returns the stamps of the first and the last one (rospy.Time), the record
    time of the bag's last message [s], and the bag's topics as rosbag describes them. @throws InputError if there are none."""
    with bags.reading(path) as bag:
        topics = bag.get_type_and_topic_info().topics
        if topic not in topics:
            raise InputError(f"{path}: no messages on {topic}; the bag has {listed(topics)}")
        kind = "sensor_msgs/CompressedImage" if topic.endswith("/compressed") else "sensor_msgs/Image"
        # Type and topic info names only the type of a topic's first connection.
        kinds = {connection.datatype for connection in bag._get_connections([topic])}  # pylint: disable=protected-access
        if kind not in kinds:
            raise InputError(f"{path}: {topic} holds no {kind}, but {topics[topic].msg_type}; the bag has {listed(topics)}")
        first = next((stamp for stamp in _stamps(bag, topic, kind) if stamp is not None), None)
        if first is None:
            raise InputError(f"{path}: {topic} holds no readable {kind}: its messages are damaged or of another type")
        # Reads backwards in growing steps and not the whole bag, because record times and stamps may differ.
        end, step = _end_of(bag), 1.0
        while True:
            start = rospy.Time.from_sec(max(0.0, end - step))
            stamps = list(_stamps(bag, topic, kind, start))
            last = next((stamp for stamp in reversed(stamps) if stamp is not None), None)
            if last is not None:
                break
            step *= 4.0
    skipped = sum(stamp is None for stamp in stamps)
    if skipped:
        rospy.logwarn("%s: %s: the first and last image are looked for; messages that are no %s, or damaged, were skipped: %d",
                      path, topic, kind, skipped)
    return first, last, end, topics


def _end_of(bag):
    """Record time of the bag's last message [s]. rosbag's get_end_time() is that of the chunk that lies last in the file."""
    chunks = bag._chunks  # pylint: disable=protected-access
    return max([chunk.end_time.to_sec() for chunk in chunks] + [bag.get_end_time()])


def _stamps(bag, topic, kind, start=None):
    """Stamps of the messages of a topic from a record time on; None for one of another type than `kind`, or damaged."""
    for message in bags.each_message(bag, topic, kind, start):
        yield None if message is None else message.header.stamp


def tail(end, *topics):
    """A temporary bag with one message on each topic, one after the other, just after the time `end` [s].
    Returns its file, which is deleted when it is closed. @throws InputError if it cannot be written."""
    try:
        file = tempfile.NamedTemporaryFile(prefix="end_of_bag_", suffix=".bag")
        with rosbag.Bag(file.name, "w") as bag:
            for number, topic in enumerate(topics, 1):
                bag.write(topic, String(topic), rospy.Time.from_sec(min(end + 0.001 * number, LAST_TIME_S)))
    except OSError as error:
        raise InputError(f"the temporary bag that marks the end of the played one cannot be written: {error}") from None
    return file
