"""What `playback` must know of a bag, and the second bag that `rosbag play` plays after it."""

import tempfile

import rosbag
import rospy
from std_msgs.msg import String

from ratslam_tools.datasets import bags
from ratslam_tools.errors import InputError

LAST_TIME_S = 2.0**32 - 1.0  # the last that a ROS time can hold


def listed(topics):
    """The topics of a bag and their types, as a sentence goes on with them."""
    return ", ".join(f"{name} [{info.msg_type}]" for name, info in sorted(topics.items())) or "no messages at all"


def look_into(path, topic):
    """Stamps of the first and last message of a bag's topic, the time of its last message, and all its topics.
    @raise InputError"""
    with bags.reading(path) as bag:
        topics = bag.get_type_and_topic_info().topics
        if topic not in topics:
            raise InputError(f"{path}: no messages on {topic}; the bag has {listed(topics)}")
        kind = "sensor_msgs/CompressedImage" if topic.endswith("/compressed") else "sensor_msgs/Image"
        if topics[topic].msg_type != kind:
            raise InputError(f"{path}: {topic} holds no {kind}, but {topics[topic].msg_type}; the bag has {listed(topics)}")
        first = next(message.header.stamp for _, message, _ in bag.read_messages(topics=[topic]))
        # Reads backwards in growing steps and not the whole bag, because record times and stamps may differ.
        end, step = bag.get_end_time(), 1.0
        while True:
            start = rospy.Time.from_sec(max(0.0, end - step))
            stamps = [message.header.stamp for _, message, _ in bag.read_messages(topics=[topic], start_time=start)]
            if stamps:
                return first, stamps[-1], end, topics
            step *= 4.0


def tail(end, *topics):
    """A temporary bag with one message on each topic, one after the other, just after the time `end` [s].
    @return its file, which vanishes when it is closed. @raise InputError"""
    try:
        file = tempfile.NamedTemporaryFile(prefix="end_of_bag_", suffix=".bag")
        with rosbag.Bag(file.name, "w") as bag:
            for number, topic in enumerate(topics, 1):
                bag.write(topic, String(topic), rospy.Time.from_sec(min(end + 0.001 * number, LAST_TIME_S)))
    except OSError as error:
        raise InputError(f"the temporary bag that marks the end of the played one cannot be written: {error}") from None
    return file
