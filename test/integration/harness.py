"""What the integration tests share: synthetic drives as bags, and nodes as processes whose words can be waited for."""
import math
import os
import re
import shutil
import signal
import subprocess
import tempfile
import threading
import time
import unittest
import xmlrpc.client

import cv2
import numpy as np
import rosbag
import rosgraph
import roslib.packages
import rospkg
import rospy
from nav_msgs.msg import Odometry
from ratslam_ros.msg import ViewTemplate
from ratslam_tools import master
from sensor_msgs.msg import CompressedImage, Image

WIDTH, HEIGHT = 160, 60
LAP_FRAMES = 80
PIXELS_PER_FRAME = 6
FRAME_PERIOD_NS = 100000000
START_NS = 1000000000000
SPEED = 1.0  # m/s, round a circle that closes after a lap

CONFIG = {
    "template_x_size": 20, "template_y_size": 6, "vt_shift_match": 2, "vt_step_match": 1, "vt_match_threshold": 0.03,
    "pc_dim_xy": 11, "pc_cell_x_size": 0.5, "pc_vt_inject_energy": 0.15, "exp_delta_pc_threshold": 1.0, "exp_loops": 5,
    "camera_fov_deg": 120.0, "vtrans_scaling": 10.0, "exp_recall_sigma": 0.3,
}


def stamp(nanoseconds):
    return rospy.Time(nanoseconds // 1000000000, nanoseconds % 1000000000)


def frame_stamp(index):
    """Not quite regular, as stamps are."""
    return START_NS + index * FRAME_PERIOD_NS + (index * 7919) % 1000000


def panorama():
    """A closed strip of random texture, LAP_FRAMES steps long."""
    noise = np.random.RandomState(7).randint(0, 256, (HEIGHT, LAP_FRAMES * PIXELS_PER_FRAME)).astype(np.uint8)
    wrapped = np.hstack([noise, noise, noise])
    smooth = cv2.normalize(cv2.GaussianBlur(wrapped, (0, 0), 5), None, 0, 255, cv2.NORM_MINMAX)
    width = noise.shape[1]
    return np.hstack([smooth[:, width:2 * width], smooth[:, width:width + WIDTH]])


def frame(strip, index):
    begin = (index % LAP_FRAMES) * PIXELS_PER_FRAME
    return np.ascontiguousarray(strip[:, begin:begin + WIDTH])


def image_message(pixels, stamp_ns, encoding="mono8", padding=0):
    """A raw image; `padding` bytes of 255 follow each row."""
    rows = np.ascontiguousarray(pixels).reshape(pixels.shape[0], -1)
    if padding:
        rows = np.hstack([rows, np.full((rows.shape[0], padding), 255, np.uint8)])
    message = Image(height=pixels.shape[0], width=pixels.shape[1], encoding=encoding, step=rows.shape[1],
                    data=rows.tobytes())
    message.header.stamp, message.header.frame_id = stamp(stamp_ns), "camera"
    return message


def compressed_message(pixels, stamp_ns):
    message = CompressedImage(format="jpeg", data=cv2.imencode(".jpg", pixels)[1].tobytes())
    message.header.stamp, message.header.frame_id = stamp(stamp_ns), "camera"
    return message


def odometry_message(stamp_ns, speed=SPEED, yaw_rate=2.0 * math.pi / (LAP_FRAMES * FRAME_PERIOD_NS * 1e-9)):
    message = Odometry()
    message.header.stamp, message.header.frame_id, message.child_frame_id = stamp(stamp_ns), "odom", "base_link"
    message.twist.twist.linear.x, message.twist.twist.angular.z = speed, yaw_rate
    return message


def view_message(index, number=None):
    """The view of a frame; lap after lap the same ones unless it has a number of its own."""
    message = ViewTemplate(current_id=index % LAP_FRAMES if number is None else number)
    message.header.stamp = stamp(frame_stamp(index))
    return message


def write_bag(path, root, frames, compressed=False, odometry_period_ns=None, size=None):
    """A drive of that many frames, scaled to `size` where given; with odometry of its own, out of step with the images,
    where a period is given."""
    strip = panorama()
    messages = []
    for index in range(frames):
        at, pixels = frame_stamp(index), frame(strip, index)
        if size:
            pixels = cv2.resize(pixels, size)
        topic = root + "/camera/image" + ("/compressed" if compressed else "")
        messages.append((at, topic, compressed_message(pixels, at) if compressed else image_message(pixels, at)))
    if odometry_period_ns:
        at = START_NS - 37000000
        while at < messages[frames - 1][0] + odometry_period_ns:
            messages.append((at, root + "/odom", odometry_message(at)))
            at += odometry_period_ns
    messages.sort(key=lambda entry: entry[0])
    with rosbag.Bag(path, "w") as bag:
        for at, topic, message in messages:
            bag.write(topic, message, stamp(at))


def write_parameters(path, values):
    with open(path, "w", encoding="utf-8") as file:
        file.writelines(f"{key}: {value}\n" for key, value in values.items())


def write_config(path, **changes):
    write_parameters(path, {**CONFIG, **changes})


def contents(path):
    with open(path, "rb") as file:
        return file.read()


def trajectories(prefix):
    """@return [online, final], as bytes"""
    return [contents(f"{prefix}_{kind}.tum") for kind in ("online", "final")]


def executable(name):
    found = roslib.packages.find_node("ratslam_ros", name)
    if not found:
        raise RuntimeError(f"{name} is not built")
    return found[0]


class Process:
    """A program, and what it has said so far."""

    def __init__(self, command, **kwargs):
        environment = dict(os.environ, ROSCONSOLE_STDOUT_LINE_BUFFERED="1")
        environment.pop("PYTHONUNBUFFERED", None)  # a user's shell does not set it
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                        env=environment, **kwargs)
        self.lines = []
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()

    def _read(self):
        for line in self.process.stdout:
            self.lines.append(line.rstrip("\n"))

    def output(self):
        return "\n".join(self.lines)

    def count(self, pattern):
        return sum(1 for line in self.lines if re.search(pattern, line))

    def said(self, pattern, timeout=15.0):
        """Waits for a line. @return whether it came"""
        return wait_until(lambda: self.count(pattern) > 0, timeout)

    def ended(self, timeout=15.0):
        """Waits for the end. @return exit code, None where it still runs"""
        try:
            code = self.process.wait(timeout)
        except subprocess.TimeoutExpired:
            return None
        self.reader.join(5.0)
        return code

    def interrupt(self, timeout=15.0):
        """Ends it as roslaunch would. @return exit code"""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        code = self.ended(timeout)
        if code is None:
            self.process.kill()
        return code


def start_node(name, *arguments, before=(), **parameters):
    """A node of the package with private parameters; arguments are a configuration file and remappings, `before` words that
    run the command."""
    values = [f"_{key}:={value}" for key, value in parameters.items()]
    return Process([*before, executable(name), *arguments, *values])


def launch(name, cwd=None, **arguments):
    """A launch file: the package's by its name, another by its path."""
    file = [name] if os.path.isabs(name) else ["ratslam_ros", name]
    return Process(["roslaunch", *file, *(f"{key}:={value}" for key, value in arguments.items())], cwd=cwd)


def offline(recording, config, out, *options):
    """ratslam_run. @return what subprocess.run does: the exit code, and all that was said as stdout"""
    return subprocess.run([executable("ratslam_run"), recording, "--config", config, "--out", out, *options],
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False, timeout=300)


def demo_config():
    return os.path.join(rospkg.RosPack().get_path("ratslam_ros"), "config", "demo.yaml")


def write_town(path, *options):
    """A rendered drive, as a bag or a folder."""
    subprocess.run([executable("ratslam_town"), "--out", path, *options], check=True, stdout=subprocess.DEVNULL)


def write_town_bag(path):
    """60 frames of a drive through the synthetic town, as JPEG on /town."""
    write_town(path, "--frames", "60", "--jpeg-quality", "90")


def launch_on_town(**arguments):
    """ratslam.launch for such a bag."""
    return launch("ratslam.launch", **{"config": demo_config(), "topic_root": "town", "compressed": "true", **arguments})


def links(name):
    """{(topic, node)}: who listens to a node, as it knows itself; nobody where it does not run yet."""
    caller = "/links_of_test"
    try:
        api = rosgraph.Master(caller).lookupNode(name)
        _, _, connections = xmlrpc.client.ServerProxy(api).getBusInfo(caller)
    except (rosgraph.MasterException, OSError):
        return set()
    return {(topic, other) for _, other, direction, _, topic, connected, *_ in connections if direction == "o" and connected}


def wait_until(condition, timeout=15.0, step=0.05):
    end = time.monotonic() + timeout
    while time.monotonic() < end:
        if condition():
            return True
        time.sleep(step)
    return condition()


def wait_for_links(condition, timeout=30.0):
    """As wait_until, for connections between nodes: the master may have failed to tell of a publisher."""
    end = time.monotonic() + timeout
    while not wait_until(condition, 5.0):
        if time.monotonic() > end:
            return False
        master.tell_subscribers(rospy.get_name())
    return True


class FolderTest(unittest.TestCase):
    """Tests with a folder and a configuration of their own. What still runs at a test's end is ended."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node(cls.__name__.lower() + "_test")
        cls.folder = tempfile.mkdtemp()
        cls.config = cls.path("config.yaml")
        write_config(cls.config)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    @classmethod
    def path(cls, *names):
        return os.path.join(cls.folder, *names)

    def setUp(self):
        self.running, self.subscribers = [], []

    def tearDown(self):
        for process in reversed(self.running):
            if process.process.poll() is None:
                process.process.send_signal(signal.SIGCONT)
                process.interrupt(30.0)
        for subscriber in self.subscribers:
            subscriber.unregister()

    def keep(self, process):
        self.running.append(process)
        return process

    def words(self):
        return "\n".join(process.output() for process in self.running)

    def wait(self, condition, timeout=15.0):
        self.assertTrue(wait_until(condition, timeout), self.words())

    def collected(self, topic, kind, connected=False):
        """A list that everything on the topic is appended to; `connected`: the node runs already."""
        messages = []
        subscriber = rospy.Subscriber(topic, kind, messages.append, queue_size=None)
        self.subscribers.append(subscriber)
        self.assertTrue(not connected or wait_for_links(lambda: subscriber.get_num_connections() > 0), topic)
        return messages

    def launch(self, name="ratslam.launch", cwd=None, **arguments):
        """A launch file with the test's configuration."""
        return self.keep(launch(name, cwd, **{"config": self.config, **arguments}))

    def completed(self, launched, prefix, timeout=120.0):
        """Waits for the end of a playback. @return the trajectories that it has left"""
        self.assertEqual(launched.ended(timeout), 0, launched.output())
        self.assertIn("the map has processed the last image", launched.output())
        return trajectories(prefix)

    def offline(self, recording, name, *options):
        """The trajectories of a run without nodes, in the folder of that name."""
        run = offline(recording, self.config, self.path(name), *options)
        self.assertEqual(run.returncode, 0, run.stdout)
        return trajectories(self.path(name, "trajectory"))


class NodeTest(FolderTest):
    """Tests of single nodes, each in a namespace that has the test's name."""
    BEFORE = ()  # words before a node's command

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.strip = panorama()

    def setUp(self):
        super().setUp()
        self.nodes = self.running
        self.root = "/" + self.id().rsplit(".", 1)[-1]

    def named(self, name):
        return name + self.root.replace("/", "_")

    def start(self, name, *arguments, **parameters):
        """A node that drops no image unless it is told to."""
        parameters = {"topic_root": self.root, "image_queue_size": 0, **parameters}
        return self.keep(start_node(name, self.config, f"__name:={self.named(name)}", *arguments, before=self.BEFORE, **parameters))

    def publisher(self, topic, kind, subscribers=1, queue_size=1000):
        """A publisher to which so many nodes have connected."""
        publisher = rospy.Publisher(self.root + "/" + topic, kind, queue_size=queue_size)
        self.assertTrue(wait_for_links(lambda: publisher.get_num_connections() >= subscribers), topic)
        return publisher

    def collected(self, topic, kind, connected=False):
        return super().collected(topic if topic.startswith("/") else self.root + "/" + topic, kind, connected)

    def frame(self, index):
        return frame(self.strip, index)

    def image(self, index):
        return image_message(self.frame(index), frame_stamp(index))

    def ends_well(self, node):
        self.assertIsNone(node.process.poll(), node.output())
        self.assertEqual(node.interrupt(), 0, node.output())
