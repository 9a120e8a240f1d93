"""Reading from and writing to rosbags. With played_bag.py the only module that needs ROS (python3-rosbag and the message
packages).
"""

import os
import re
import stat
import struct
from contextlib import contextmanager, suppress

import numpy as np

from ratslam_tools import output_file
from ratslam_tools.errors import InputError, one_line
from ratslam_tools.trajectory import Trajectory, geometry
from ratslam_tools.trajectory.poses import MAX_NUMBER

# A bag must not hold messages of record time 0, which rospy takes for "no time".
MIN_RECORD_TIME_NS = 1000


def is_bag(path: str) -> bool:
    """Whether a path names a bag: what ends so is read as one."""
    return path.endswith(".bag")


def open_bag(path: str, mode: str = "r"):
    """Opens a rosbag.Bag. @throws InputError for a file that is no complete bag, and without ROS's Python packages.
    """
    try:
        import rosbag
    except ImportError as error:
        raise InputError(f"{path}: bags need ROS's Python packages (python3-rosbag): {error}") from None
    if mode == "r":
        _check_records(path)
    try:
        return rosbag.Bag(path, mode)
    except rosbag.ROSBagUnindexedException:
        raise InputError(
            f"{path}: the bag has no index (its recording was cut off); run: rosbag reindex {path}"
        ) from None
    except OSError as error:
        if mode == "w":
            raise  # writing() tells it
        raise InputError(f"{path}: not a readable bag: {error.strerror or error}") from None
    except Exception as error:  # rosbag raises various errors for a damaged file
        raise _damaged(path, error) from None


def _damaged(path: str, error: Exception) -> InputError:
    return InputError(f"{path}: not a readable bag, or a damaged one: {one_line(error) or type(error).__name__}")


# A chunk that unpacks to at most so many bytes is never refused; a larger one is if it claims to unpack to far more.
CHUNK_BYTES, CHUNK_RATIO = 64 << 20, 1000
BAG_HEADER, CHUNK = b"\x03", b"\x05"


def _check_records(path: str) -> None:
    """Checks that the records of a bag follow each other within the file, and that no chunk claims to unpack to far
    more than its size. rosbag itself allocates any length before it checks it. @throws InputError
    """
    try:
        if not stat.S_ISREG(os.stat(path).st_mode):
            raise InputError(f"{path}: not a readable bag: it is no regular file")
        size = os.path.getsize(path)
        with open(path, "rb") as file:
            begin = file.readline(64)
            if not begin.startswith(b"#ROSBAG V2.0\n"):
                raise InputError(f"{path}: not a readable bag: {_what_else(begin)}")
            position = file.tell()
            while position < size:
                header = _field(file, position, size, path)
                data = position + 4 + len(header)
                length = _length(file, data, size, path)
                fields = _fields(header)
                if fields.get(b"op") == BAG_HEADER and not any(fields.get(b"index_pos", b"")):
                    return  # no index: the recording was cut off, perhaps within a record; rosbag reports it
                _check_chunk(path, fields, length)
                position = data + 4 + length
    except OSError as error:
        raise InputError(f"{path}: not a readable bag: {error.strerror}") from None


def _what_else(begin: bytes) -> str:
    """Description of a file whose first bytes are not those of a bag."""
    otherwise = "it does not begin with '#ROSBAG V2.0'"
    if begin.startswith(b"\x89MCAP"):
        return otherwise + " but as a bag of ROS 2; rosbags-convert makes one of ROS 1 of it"
    if begin.startswith(b"SQLite format"):
        return otherwise + " but as a database: if it is a bag of ROS 2, rosbags-convert makes one of ROS 1 of it"
    return otherwise


def _length(file, position: int, size: int, path: str) -> int:
    """The 32-bit length at byte `position` of a file of `size` bytes. @throws InputError if it reaches beyond the
    end of the file."""
    file.seek(position)
    data = file.read(4)
    length = struct.unpack("<I", data)[0] if len(data) == 4 else size
    if position + 4 + length > size:
        raise InputError(
            f"{path}: not a readable bag, or a damaged one: a record at byte {position} reaches beyond the file's end; "
            f"rosbag reindex {path} keeps the chunks that are whole"
        )
    return length


def _field(file, position: int, size: int, path: str) -> bytes:
    return file.read(_length(file, position, size, path))


def _fields(header: bytes) -> dict:
    """Name and value of the fields `length name=value` of a record's header."""
    fields = {}
    while len(header) >= 4:
        end = 4 + struct.unpack("<I", header[:4])[0]
        name, _, value = header[4:end].partition(b"=")
        fields[name], header = value, header[end:]
    return fields


def _check_chunk(path: str, fields: dict, length: int) -> None:
    """Checks the unpacked size that a chunk's header states. @param fields of a record's header @param length of its data
    [bytes] @throws InputError if the size is impossible for that length."""
    unpacked = fields.get(b"size", b"")
    if fields.get(b"op") != CHUNK or len(unpacked) != 4:
        return
    claimed = struct.unpack("<I", unpacked)[0]
    packed = fields.get(b"compression", b"none") != b"none"
    if claimed > (max(CHUNK_BYTES, CHUNK_RATIO * length) if packed else length):
        raise InputError(f"{path}: not a readable bag, or a damaged one: a chunk of {length} bytes claims {claimed}")


def _sort(bag):
    """Puts the messages of each topic in order of their record times, as `rosbag play` does. rosbag itself takes the
    order of the file, in which a bag that was merged need not be."""
    for index in bag._connection_indexes.values():  # pylint: disable=protected-access
        index.sort(key=lambda entry: entry.time)


@contextmanager
def reading(path: str):
    """An open bag for reading. @throws InputError for any error of rosbag, also later while the bag is read."""
    with open_bag(path) as bag:
        try:
            _sort(bag)
            yield bag
        except (InputError, MemoryError, KeyboardInterrupt):
            raise
        except Exception as error:  # see open_bag
            raise _damaged(path, error) from None


def _pose_of(message):
    """(position, orientation) of any of the pose-carrying message types; None for others."""
    if hasattr(message, "transform"):
        return message.transform.translation, message.transform.rotation
    pose = getattr(message, "pose", None)
    if hasattr(pose, "pose"):
        pose = pose.pose
    return (pose.position, pose.orientation) if hasattr(pose, "position") else None


def read_trajectory_topic(path: str, topic: str, allow_repeats: bool = False) -> Trajectory:
    """The poses of a topic by header stamp. @param allow_repeats as in Trajectory.check.

    Odometry, PoseStamped, PoseWithCovarianceStamped and TransformStamped have one pose per message. Of nav_msgs/Path
    the last message counts. @throws InputError listing the bag's topics, if this one is missing or has no poses.
    """
    messages = []
    with reading(path) as bag:
        topics = bag.get_type_and_topic_info().topics
        if topic not in topics:
            raise InputError(f"{path}: no topic {topic}; it has: {', '.join(sorted(topics)) or 'none'}")
        kind = topics[topic].msg_type
        for _, message, _ in bag.read_messages(topics=[topic]):
            if kind == "nav_msgs/Path":
                messages = message.poses
            elif not messages and _pose_of(message) is None:
                break  # of another type: no need to read all of it
            else:
                messages.append(message)
    poses = [_pose_of(message) for message in messages]
    if not poses or any(pose is None for pose in poses):
        raise InputError(f"{path}: topic {topic} ({kind}) carries no stamped poses")
    stamps = [message.header.stamp.to_sec() for message in messages]
    positions = [[position.x, position.y, position.z] for position, _ in poses]
    values = np.array(positions)
    if not np.isfinite(values).all() or (np.abs(values) > MAX_NUMBER).any():
        raise InputError(f"{path}: topic {topic}: a position that is not finite, or immense")
    quaternions = np.array([[turn.x, turn.y, turn.z, turn.w] for _, turn in poses])
    if not np.isfinite(quaternions).all() or (np.abs(quaternions) > MAX_NUMBER).any():
        raise InputError(f"{path}: topic {topic}: a quaternion that is not finite")
    if (np.linalg.norm(quaternions, axis=1) < 1e-6).any():
        raise InputError(f"{path}: topic {topic}: a quaternion of length zero")
    return Trajectory(positions, geometry.matrices_from_quaternions(quaternions), stamps, topic).check(allow_repeats)


def each_message(bag, topic: str, kind: str, start=None):
    """The messages of a topic from a record time on; None for each that is of another type than `kind`, or damaged."""
    import genpy

    for _, (datatype, data, _, _, message_type), _ in bag.read_messages(topics=[topic], start_time=start, raw=True):
        message = message_type()
        try:
            yield message.deserialize(data) if datatype == kind else None
        except genpy.DeserializationError:
            yield None


def image_count(path: str) -> int:
    """Number of images on the only topic of images of a bag. @throws InputError if it has no such topic, or
    several."""
    with reading(path) as bag:
        topics = bag.get_type_and_topic_info().topics
    kinds = ("sensor_msgs/Image", "sensor_msgs/CompressedImage")
    counts = {name: info.message_count for name, info in sorted(topics.items()) if info.msg_type in kinds}
    if len(counts) != 1:
        raise InputError(f"{path}: one topic of images is needed; it has {', '.join(counts) or 'none'}")
    return next(iter(counts.values()))


@contextmanager
def writing(path: str):
    """A bag for writing. It gets its name only when it is complete, so that an interruption leaves no partial bag.
    """
    if not os.path.basename(path):
        raise InputError(f"'{path}': cannot be written: it names no file")
    if os.path.exists(path) and not os.path.isfile(path):
        raise InputError(f"{path}: cannot be written: there is a folder or device of this name")
    if _is_another_file(path):
        raise InputError(f"{path}: not overwritten: the file exists and is no bag")
    try:
        os.makedirs(os.path.dirname(os.path.abspath(path)), exist_ok=True)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}") from None
    with output_file.replacing(path) as part:
        bag = open_bag(part, "w")
        try:
            yield bag
            bag.close()
        except BaseException:
            with suppress(Exception):  # the bag is not wanted any more, and cannot even be closed if the disk is full
                bag.close()
            raise


def _is_another_file(path: str) -> bool:
    """Whether there is a file of that name that holds something other than a bag, such as a part of the recording."""
    try:
        with open(path, "rb") as file:
            begin = file.read(8)
    except OSError:
        return False
    return begin not in (b"", b"#ROSBAG ")


def require_topic_name(option: str, name: str) -> None:
    """@throws InputError naming the option if `name` cannot be the first part of ROS topic names. An empty name is allowed."""
    if name.strip("/") and re.fullmatch(r"/?[A-Za-z][A-Za-z0-9_]*(/[A-Za-z][A-Za-z0-9_]*)*/?", name) is None:
        raise InputError(f"{option}: '{name}' is no name of ROS: letters, digits and _, after a letter, parted by /")


def write(bag, topic: str, message, stamp_ns: int) -> None:
    """Writes with the record time of the stamp, but at least 1000 ns."""
    bag.write(topic, message, ros_time(max(stamp_ns, MIN_RECORD_TIME_NS)))


def ros_time(stamp_ns: int):
    """genpy.Time of nanoseconds. @throws InputError for a time that ROS cannot hold."""
    import genpy

    if not 0 <= stamp_ns < 2**32 * 10**9:
        raise InputError(f"the stamp {stamp_ns * 1e-9:.9f} s lies outside what ROS can hold (0 to 2^32 s)")
    return genpy.Time(stamp_ns // 10**9, stamp_ns % 10**9)


def header(stamp_ns: int, frame_id: str, seq: int = 0):
    """std_msgs/Header."""
    from std_msgs.msg import Header

    return Header(seq=seq, stamp=ros_time(stamp_ns), frame_id=frame_id)


def static_transform(stamp_ns: int, parent: str, child: str, rotation, translation=(0.0, 0.0, 0.0)):
    """tf2_msgs/TFMessage with the pose (rotation (3, 3), translation [m]) of `child` in `parent`."""
    from geometry_msgs.msg import Quaternion, Transform, TransformStamped, Vector3
    from tf2_msgs.msg import TFMessage

    quaternion = geometry.quaternions_from_matrices(np.asarray(rotation)[None])[0]
    transform = Transform(Vector3(*translation), Quaternion(*quaternion))
    return TFMessage([TransformStamped(header(stamp_ns, parent), child, transform)])


def camera_info(
    head, width: int, height: int, matrix, projection=None, distortion=(0.0,) * 5, model: str = "plumb_bob"
):
    """sensor_msgs/CameraInfo; matrix (3, 3) [px], distortion as `model` has it, projection (3, 4) [px]."""
    from sensor_msgs.msg import CameraInfo

    matrix = np.asarray(matrix, dtype=float)
    if projection is None:
        projection = np.hstack([matrix, np.zeros((3, 1))])
    return CameraInfo(
        header=head,
        width=width,
        height=height,
        distortion_model=model,
        D=list(distortion),
        K=matrix.ravel().tolist(),
        R=np.eye(3).ravel().tolist(),
        P=np.ravel(projection).tolist(),
    )


def raw_image(head, image: np.ndarray):
    """sensor_msgs/Image, mono8 or mono16 of an array (h, w), or bgr8 of (h, w, 3)."""
    from sensor_msgs.msg import Image

    height, width = image.shape[:2]
    channels = 1 if image.ndim == 2 else image.shape[2]
    return Image(
        header=head,
        height=height,
        width=width,
        encoding="bgr8" if channels == 3 else "mono16" if image.dtype == np.uint16 else "mono8",
        is_bigendian=0,
        step=width * channels * image.itemsize,
        data=image.astype(image.dtype.newbyteorder("<")).tobytes(),
    )


def compressed_image(head, path: str):
    """sensor_msgs/CompressedImage with the bytes of an image file as they are."""
    from sensor_msgs.msg import CompressedImage

    with open(path, "rb") as file:
        return CompressedImage(
            header=head, format="png" if path.lower().endswith(".png") else "jpeg", data=file.read()
        )


def odometry_message(head, child: str, position, quaternion, linear, angular):
    """nav_msgs/Odometry; pose of `child` in the header's frame, twist in `child` ([m/s], [rad/s])."""
    from geometry_msgs.msg import Point, Quaternion, Vector3
    from nav_msgs.msg import Odometry

    message = Odometry(header=head, child_frame_id=child)
    message.pose.pose.position = Point(*position)
    message.pose.pose.orientation = Quaternion(*quaternion)
    message.twist.twist.linear = Vector3(*linear)
    message.twist.twist.angular = Vector3(*angular)
    return message


def ground_truth_messages(trajectory: Trajectory, stamps_ns, frame_id: str = "world"):
    """One Odometry per pose (base convention, child base_link). The twist is that of the step before the pose.
    """
    quaternions = geometry.quaternions_from_matrices(trajectory.rotations)
    linear = np.zeros((len(trajectory), 3))
    angular = np.zeros((len(trajectory), 3))
    seconds = np.diff(np.asarray(stamps_ns, dtype=float)) * 1e-9
    inverse = geometry.transpose(trajectory.rotations[:-1])
    linear[1:] = geometry.rotate(inverse, np.diff(trajectory.positions, axis=0)) / seconds[:, None]
    angular[1:] = geometry.rotation_vectors(inverse @ trajectory.rotations[1:]) / seconds[:, None]
    for index, stamp_ns in enumerate(stamps_ns):
        yield stamp_ns, odometry_message(
            header(stamp_ns, frame_id, index),
            "base_link",
            trajectory.positions[index],
            quaternions[index],
            linear[index],
            angular[index],
        )
