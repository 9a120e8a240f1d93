"""A drive through the synthetic town into a chain of nodes, of which some are killed and started again on the way, and what
that did to the map. The rostest restarts.test and `scripts/endurance restarts` share it."""
import math
import os
import re
import signal
import sys
import time

import numpy as np
import rosbag
import rospy
from nav_msgs.msg import Odometry
from ratslam_ros.msg import PoseCellState, ViewTemplate
from geometry_msgs.msg import PoseStamped
from sensor_msgs.msg import CameraInfo, CompressedImage

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "..", "scripts"))
import harness  # noqa: E402  (lies beside this file)
from ratslam_tools.evaluation import metrics  # noqa: E402
from ratslam_tools.trajectory import association  # noqa: E402
from ratslam_tools.trajectory.poses import Trajectory, read_trajectory  # noqa: E402

NODES = {"profile": "ratslam_vo", "orb": "ratslam_orb_vo"}
CONFIG = {
    "image_crop_y_min": 30, "image_crop_y_max": 150, "template_x_size": 60, "template_y_size": 10, "vt_normalisation": 0.4,
    "vt_shift_match": 5, "vt_step_match": 1, "vt_match_threshold": 0.04, "pc_dim_xy": 30, "pc_cell_x_size": 2.0,
    "pc_vt_inject_energy": 0.15, "pc_vt_restore": 0.04, "exp_delta_pc_threshold": 1.0, "exp_loops": 20, "exp_height": "true",
    "camera_height": 1.65, "camera_fov_deg": 80.0, "image_transport": "compressed", "image_queue_size": 0, "sync_timeout": 4.0,
}
TOWN = ["--frames", "600", "--size", "620x188", "--jpeg-quality", "90", "--wheel-noise", "0.01,0.1,0.01"]  # of ratslam_town
FALSE_M = 10.0  # a view recalled so far from where it was learned is another place


class Town:
    """A rendered drive: its messages by time, and where the car was."""

    def __init__(self, bag):
        self.bag = bag
        self.frames, self.wheels, self.truth = [], {}, {}
        with rosbag.Bag(bag) as messages:
            for topic, message, _ in messages.read_messages():
                name = topic.split("/", 2)[-1]
                if name == "camera/image/compressed":
                    self.frames.append(message)
                elif name == "camera/camera_info":
                    self.camera = message
                elif name == "odom":
                    self.wheels[message.header.stamp] = message
                elif name == "ground_truth":
                    self.truth[message.header.stamp] = message.pose.pose.position
        self.stamps = [frame.header.stamp for frame in self.frames]

    def place(self, stamp):
        return self.truth[stamp].x, self.truth[stamp].y

    def way(self, first, last):
        """Length of the way between two frames [m]."""
        places = [self.place(stamp) for stamp in self.stamps[first:last + 1]]
        return sum(math.dist(a, b) for a, b in zip(places, places[1:]))

    def trajectory(self):
        positions = np.array([[self.truth[s].x, self.truth[s].y, self.truth[s].z] for s in self.stamps])
        return Trajectory(positions, np.tile(np.eye(3), (len(positions), 1, 1)), np.array([s.to_sec() for s in self.stamps]))

    def error(self, path, scaled):
        """Mean APE of a trajectory [m], aligned to the truth."""
        reference, estimate = association.associate(self.trajectory(), read_trajectory(path))
        estimate = association.fit_alignment(reference, estimate, True, scaled).apply(estimate)
        return float(metrics.ape(reference, estimate).mean()), len(estimate)


    def with_poses(self, path, reset=None):
        """The same drive with poses in its odometry, which go back to the origin at frame `reset`."""
        turn, x, y, last = 0.0, 0.0, 0.0, None
        with rosbag.Bag(path, "w") as bag:
            for index, frame in enumerate(self.frames):
                stamp = frame.header.stamp
                message = self.wheels[stamp]
                dt = (stamp - last).to_sec() if last else 0.0
                turn += message.twist.twist.angular.z * dt
                x += message.twist.twist.linear.x * dt * math.cos(turn)
                y += message.twist.twist.linear.x * dt * math.sin(turn)
                if index == reset:
                    turn = x = y = 0.0
                last = stamp
                message.pose.pose.position.x, message.pose.pose.position.y = x, y
                message.pose.pose.orientation.z, message.pose.pose.orientation.w = math.sin(0.5 * turn), math.cos(0.5 * turn)
                bag.write("/town/odom", message, stamp)
                bag.write("/town/camera/image/compressed", frame, stamp)
                truth = Odometry(header=frame.header)
                truth.pose.pose.position = self.truth[stamp]
                bag.write("/town/ground_truth", truth, stamp)
        return Town(path)


class Chain:
    """The nodes, fed with a town's drive by hand."""

    def __init__(self, town, root, folder, odometry="external", lag=0, **parameters):
        """lag: the odometry comes so many frames after the images, as one does that takes long to compute"""
        self.town, self.root, self.folder, self.odometry, self.lag = town, root, folder, odometry, lag
        os.makedirs(folder)
        self.config = os.path.join(folder, "config.yaml")
        self.parameters = parameters
        harness.write_parameters(self.config, CONFIG)
        self.trajectory = os.path.join(folder, "run")
        self.names = ["ratslam_em", "ratslam_pc", "ratslam_lv"] + ([NODES[odometry]] if odometry in NODES else [])
        self.nodes, self.earlier, self.next = {}, [], 0
        self.poses, self.states, self.views = [], [], []
        self.images = rospy.Publisher(f"{root}/camera/image/compressed", CompressedImage, queue_size=1000)
        self.info = rospy.Publisher(f"{root}/camera/camera_info", CameraInfo, queue_size=1000)
        self.odom = rospy.Publisher(f"{root}/odom", Odometry, queue_size=1000) if odometry == "external" else None
        self.listeners = [
            rospy.Subscriber(f"{root}/ExperienceMap/RobotPose", PoseStamped, self.poses.append),
            rospy.Subscriber(f"{root}/PoseCell/State", PoseCellState, self.states.append),
            rospy.Subscriber(f"{root}/LocalView/Template", ViewTemplate, self.views.append)]
        self.start(*self.names)

    def start(self, *names):
        for name in names:
            if name in self.nodes:
                self.earlier.append((name, self.nodes[name]))
            parameters = {"topic_root": self.root, **self.parameters}
            if name == "ratslam_em":
                parameters["trajectory_file"] = self.trajectory
            if name in ("ratslam_lv", "ratslam_pc", *NODES.values()):
                parameters["wait_for_subscribers"] = 1
            self.nodes[name] = harness.start_node(name, self.config, f"__name:={name}{self.root.replace('/', '_')}", **parameters)
        if not harness.wait_for_links(self.connected):
            raise AssertionError("the nodes do not listen: " + self.words())

    def connected(self):
        """All that take images or odometry do, the test hears all outputs, and the nodes listen to each other."""
        vo = self.odometry in NODES
        taken_by = 3 if CONFIG.get("vt_recall") == "belief" else 2
        called = {name: f"/{name}{self.root.replace('/', '_')}" for name in self.names}
        wanted = [("ratslam_lv", "LocalView/Template", "ratslam_pc"), ("ratslam_pc", "PoseCell/State", "ratslam_em")]
        wanted += [(NODES[self.odometry], "odom", listener) for listener in ("ratslam_pc", "ratslam_em") if vo]
        return (self.images.get_num_connections() == 1 + vo and (vo or self.odom.get_num_connections() == taken_by)
                and all(s.get_num_connections() for s in self.listeners)
                and all((f"{self.root}/{topic}", called[to]) in harness.links(called[by]) for by, topic, to in wanted))

    def kill(self, *names, by=signal.SIGKILL):
        for name in names:
            self.nodes[name].process.send_signal(by)
        for name in names:
            self.nodes[name].ended()

    def restart(self, names, killed, back, rate=100.0, by=signal.SIGKILL, wait_s=0.0):
        """Kills nodes at one frame, after a while, and starts them again at another."""
        self.drive(killed, rate)
        time.sleep(wait_s)
        self.kill(*names, by=by)
        self.drive(back, rate, wait=False)
        time.sleep(0.5)  # what has been published is not for the new nodes
        self.start(*names)

    def drive(self, until, rate=100.0, wait=True):
        """Publishes frames up to a number; waits until the map has taken the last one."""
        ends = until == len(self.town.frames)
        for index in range(self.next, until):
            frame = self.town.frames[index]
            if not self.lag:
                self.measure(index)
            self.info.publish(self.town.camera)
            self.images.publish(frame)
            if self.lag and index >= self.lag:
                self.measure(index - self.lag)
            time.sleep(1.0 / rate)
        for index in range(until - self.lag, until) if ends else ():
            self.measure(index)
        self.next = until
        reached = self.town.stamps[until - 1 - (0 if ends else self.lag)]
        if wait and not harness.wait_until(lambda: self.poses and self.poses[-1].header.stamp >= reached, 60.0):
            raise AssertionError(f"no robot pose of frame {until - 1}: " + self.words())

    def measure(self, index):
        if self.odom:
            self.odom.publish(self.town.wheels[self.town.stamps[index]])

    def end(self):
        """Ends what a failed trial has left."""
        for node in self.nodes.values():
            node.interrupt()
        for listener in self.listeners:
            listener.unregister()

    def finish(self):
        codes = {name: self.nodes[name].interrupt() for name in reversed(self.names)}
        if any(codes.values()):
            raise AssertionError(f"ended with {codes}: " + self.words())

    def words(self):
        return "\n".join(f"--- {name}\n{node.output()}" for name, node in self.earlier + list(self.nodes.items()))

    def forgotten(self, name, killed):
        """Time between the checkpoint that a node went on from and the last frame before it was killed [s]."""
        (resumed,) = [line for line in self.nodes[name].lines if "resumed from the checkpoint at" in line]
        at = re.search(r"checkpoint at (\d+)\.(\d{9})", resumed)
        return (self.town.stamps[killed - 1] - rospy.Time(int(at[1]), int(at[2]))).to_sec()

    def false_recalls(self):
        """(views recalled, of these false; decisions for a known experience, of these false)."""
        return (self.count((v.header.frame_id, v.current_id, v.header.stamp) for v in self.views),
                self.count((str(s.session), s.dest_id, s.header.stamp) for s in self.states if s.action))

    def count(self, numbered):
        learned, recalled, false = {}, 0, 0
        for session, number, stamp in numbered:
            place = self.town.place(stamp)
            if (session, number) not in learned:
                learned[session, number] = place
                continue
            recalled += 1
            false += math.dist(place, learned[session, number]) > FALSE_M
        return recalled, false


def undisturbed(town, folder, odometry="external"):
    """Mean APE of the run without a fault [m], and its poses: the runner leaves what the nodes do."""
    os.makedirs(folder)
    config = os.path.join(folder, "config.yaml")
    harness.write_parameters(config, CONFIG)
    run = harness.offline(town.bag, config, os.path.join(folder, "run"), "--odometry", "topic" if odometry == "external" else odometry)
    if run.returncode:
        raise AssertionError(run.stdout)
    return town.error(os.path.join(folder, "run", "trajectory_final.tum"), odometry != "external")
