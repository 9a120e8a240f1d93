"""Reading from and writing to rosbags. The only module that needs ROS (python3-rosbag and the message packages)."""

import numpy as np

from ratslam_tools import geometry
from ratslam_tools.errors import InputError
from ratslam_tools.trajectory import Trajectory

# A bag must not hold messages of record time 0, which rospy takes for "no time".
MIN_RECORD_TIME_NS = 1000


def open_bag(path: str, mode: str = "r"):
    """An open rosbag.Bag. @throws InputError for a file that is no whole bag, or without ROS's Python packages."""
    try:
        import rosbag
    except ImportError as error:
        raise InputError(f"{path}: bags need ROS's Python packages (python3-rosbag): {error}") from None
    try:
        return rosbag.Bag(path, mode)
    except rosbag.ROSBagUnindexedException:
        raise InputError(f"{path}: the bag has no index (its recording was cut off); run: rosbag reindex {path}") from None
    except (rosbag.ROSBagException, OSError) as error:
        raise InputError(f"{path}: not a readable bag: {error}") from None


def _pose_of(message):
    """(position, orientation) of any of the pose-carrying message types; None for others."""
    if hasattr(message, "transform"):
        return message.transform.translation, message.transform.rotation
    pose = getattr(message, "pose", None)
    if hasattr(pose, "pose"):
        pose = pose.pose
    return (pose.position, pose.orientation) if hasattr(pose, "position") else None


def read_trajectory_topic(path: str, topic: str) -> Trajectory:
    """The poses of a topic by header stamp.

    Odometry, PoseStamped, PoseWithCovarianceStamped and TransformStamped give one pose a message; of nav_msgs/Path the last
    message counts. @throws InputError naming the topics there are, if it is missing or carries no poses.
    """
    messages = []
    with open_bag(path) as bag:
        topics = bag.get_type_and_topic_info().topics
        if topic not in topics:
            raise InputError(f"{path}: no topic {topic}; it has: {', '.join(sorted(topics)) or 'none'}")
        kind = topics[topic].msg_type
        for _, message, _ in bag.read_messages(topics=[topic]):
            if kind == "nav_msgs/Path":
                messages = message.poses
            else:
                messages.append(message)
    poses = [_pose_of(message) for message in messages]
    if not poses or any(pose is None for pose in poses):
        raise InputError(f"{path}: topic {topic} ({kind}) carries no stamped poses")
    stamps = [message.header.stamp.to_sec() for message in messages]
    positions = [[position.x, position.y, position.z] for position, _ in poses]
    quaternions = np.array([[turn.x, turn.y, turn.z, turn.w] for _, turn in poses])
    if (np.linalg.norm(quaternions, axis=1) < 1e-6).any():
        raise InputError(f"{path}: topic {topic}: a quaternion of length zero")
    return Trajectory(positions, geometry.matrices_from_quaternions(quaternions), stamps, topic).check()
