#!/usr/bin/python3
"""Kills, stops and starts again the nodes of a running chain, breaks its streams and its master, at seeded moments.

A trial starts local view, pose cells and map below a master of its own and plays a drive into them. In the middle a
fault happens. After it, robot poses must come again, no node may have ended but the one that was killed, and every node
must end by itself within 15 s of SIGINT, the map leaving trajectories of finite numbers whose stamps rise.
"""
import argparse
import collections
import glob
import math
import os
import random
import select
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import xmlrpc.client

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "integration"))

NODES = ("ratslam_lv", "ratslam_pc", "ratslam_em")
RATE = 20.0  # images a second; twice as many odometry messages


def free_port():
    with socket.socket() as found:
        found.bind(("", 0))
        return found.getsockname()[1]


class Drive(threading.Thread):
    """Publishes a drive round a loop; faults of its streams are attributes."""

    def __init__(self, harness, rospy):
        super().__init__(daemon=True)
        from nav_msgs.msg import Odometry
        from sensor_msgs.msg import CameraInfo, Image
        self.harness = harness
        self.strip = harness.panorama()
        self.images = rospy.Publisher("/faults/camera/image", Image, queue_size=10)
        self.odometry = rospy.Publisher("/faults/odom", Odometry, queue_size=10)
        self.infos = rospy.Publisher("/faults/camera/camera_info", CameraInfo, queue_size=10)
        self.info = self.camera = CameraInfo(width=harness.WIDTH, height=harness.HEIGHT, K=[46.0, 0, 80, 0, 46.0, 30, 0, 0, 1])
        self.other_camera = CameraInfo(width=640, height=480, K=[500.0, 0, 320, 0, 500.0, 240, 0, 0, 1])
        self.shift_ns = 0
        self.image_shift_ns = 0
        self.without_odometry = False
        self.without_images = False
        self.size = None
        self.late_s = {"images": 0.0, "odometry": 0.0, "infos": 0.0}  # how long messages are under way
        self.under_way = collections.deque()
        self.ended = False

    def send(self, stream, message):
        self.under_way.append((time.monotonic() + self.late_s[stream], stream, message))

    def deliver(self):
        now = time.monotonic()
        for entry in [entry for entry in self.under_way if entry[0] <= now]:
            self.under_way.remove(entry)
            getattr(self, entry[1]).publish(entry[2])

    def run(self):
        index = 0
        while not self.ended:
            at = self.harness.frame_stamp(index) + self.shift_ns
            if not self.without_odometry:
                self.send("odometry", self.harness.odometry_message(at - 50000000))
                self.send("odometry", self.harness.odometry_message(at))
            if self.info:
                self.info.header.stamp = self.harness.stamp(at + self.image_shift_ns)
                self.send("infos", self.info)
            if not self.without_images:
                at += self.image_shift_ns
                pixels = self.harness.frame(self.strip, index)
                self.send("images", self.harness.image_message(pixels[:self.size] if self.size else pixels, at))
            self.deliver()
            index += 1
            time.sleep(1.0 / RATE)


class Chain:
    """The nodes of a trial and their master."""

    def __init__(self, harness, folder, port, **parameters):
        self.harness = harness
        self.parameters = parameters
        self.trajectory = os.path.join(folder, "run")
        self.map_dir = os.path.join(folder, "map")
        os.makedirs(self.map_dir, exist_ok=True)
        self.config = os.path.join(folder, "config.yaml")
        harness.write_config(self.config)
        self.port = port
        self.nodes = {name: self.started(name) for name in NODES}

    def started(self, name):
        parameters = {"topic_root": "/faults", "sync_timeout": 2.0, "map_dir": self.map_dir, "autosave_period": 1.0,
                      **self.parameters}
        if name == "ratslam_em":
            parameters["trajectory_file"] = self.trajectory
        return self.harness.start_node(name, self.config, **parameters)

    def complaint_at_the_end(self):
        """Ends all nodes. @return what is wrong, or an empty text"""
        found = []
        for name, node in self.nodes.items():
            if node.process.poll() is not None:
                found.append(f"{name} had ended with {node.process.returncode}: {node.output()[-300:]}")
        for name, node in self.nodes.items():
            code = node.interrupt(15.0)
            if code != 0:
                found.append(f"{name} ended with {code} after SIGINT" if code is not None else f"{name} did not end")
        return "; ".join(found + trajectory_complaints(self.trajectory))


def trajectory_complaints(prefix):
    found = []
    for name in (prefix + "_online.tum", prefix + "_final.tum"):
        if not os.path.exists(name):
            found.append(f"{os.path.basename(name)} was not written")
            continue
        last = -math.inf
        with open(name, encoding="ascii") as file:
            for number, line in enumerate(file, 1):
                values = [float(word) for word in line.split()]
                if len(values) != 8 or not all(map(math.isfinite, values)):
                    found.append(f"{os.path.basename(name)}:{number} is no pose")
                    break
                if values[0] < last:
                    found.append(f"{os.path.basename(name)}:{number}: its stamp goes back")
                    break
                last = values[0]
    return found


def kill(chain, drive, node, seconds):
    chain.nodes[node].process.kill()
    chain.nodes[node].ended()
    time.sleep(1.0)
    chain.nodes[node] = chain.started(node)


def stop(chain, drive, node, seconds):
    chain.nodes[node].process.send_signal(signal.SIGSTOP)
    time.sleep(seconds)
    chain.nodes[node].process.send_signal(signal.SIGCONT)


def restart(chain, drive, node, seconds):
    code = chain.nodes[node].interrupt()
    if code != 0:
        raise AssertionError(f"{node} ended with {code} after SIGINT")
    chain.nodes[node] = chain.started(node)


def clock_back(chain, drive, node, seconds):
    drive.shift_ns -= 600 * 10**9  # the drive begins at 1000 s


def clock_ahead(chain, drive, node, seconds):
    drive.shift_ns += 3600 * 10**9


def camera_clock_back(chain, drive, node, seconds):
    drive.image_shift_ns -= 60 * 10**9


def no_odometry(chain, drive, node, seconds):
    drive.without_odometry = True
    time.sleep(seconds)
    drive.without_odometry = False


def no_images(chain, drive, node, seconds):
    drive.without_images = True
    time.sleep(seconds)
    drive.without_images = False


def other_size(chain, drive, node, seconds):
    drive.size = 30
    time.sleep(2.0)
    drive.size = None


def no_camera_info(chain, drive, node, seconds):
    """Of those about camera_info: whoever has a camera needs none any more, so the one that does is started again."""
    drive.info = None
    restart(chain, drive, "ratslam_lv", seconds)
    time.sleep(seconds)
    drive.info = drive.camera


def other_camera_info(chain, drive, node, seconds):
    drive.info = drive.other_camera
    restart(chain, drive, "ratslam_lv", seconds)
    if not chain.nodes["ratslam_lv"].said("no usable calibration: it is for images of 640x480, they are of 160x60"):
        raise AssertionError("ratslam_lv did not say that the calibration is of another size")
    drive.info = drive.camera


def late_camera_info(chain, drive, node, seconds):
    drive.late_s["infos"] = 1.5
    restart(chain, drive, "ratslam_lv", seconds)
    late(drive, "infos")


def late_odometry(chain, drive, node, seconds):
    late(drive, "odometry")


def late_images(chain, drive, node, seconds):
    late(drive, "images")


def late(drive, stream):
    drive.late_s[stream] = 1.5
    time.sleep(6.0)
    drive.late_s[stream] = 0.0
    time.sleep(2.0)


def disk_full(chain, drive, node, seconds):
    """The checkpoints' folder takes nothing for a while; all nodes must say so, and write it all once they can."""
    filler = os.path.join(chain.map_dir, "filler")
    with open(filler, "wb") as file:
        try:
            while True:
                file.write(bytes(65536))
                file.flush()
        except OSError:
            pass
    before = checkpoints(chain.map_dir)
    time.sleep(6.0)
    if checkpoints(chain.map_dir) != before:
        raise AssertionError("files changed on a full disk")
    for name, process in chain.nodes.items():
        if "checkpoint lost: " not in process.output():
            raise AssertionError(f"{name} did not say that the disk is full")
    os.remove(filler)
    time.sleep(4.0)
    if len(checkpoints(chain.map_dir)) < len(NODES):
        raise AssertionError(f"no checkpoints after the disk had room again: {os.listdir(chain.map_dir)}")


def checkpoints(folder):
    return {name: (os.stat(name).st_size, os.stat(name).st_mtime_ns) for name in glob.glob(os.path.join(folder, "**", "*"), recursive=True)
            if os.path.isfile(name) and not name.endswith("filler")}


def subscribers(chain, drive, node, seconds):
    """64 listeners on a topic of each node, the last of which never reads."""
    from geometry_msgs.msg import PoseStamped
    from ratslam_ros.msg import PoseCellState, ViewTemplate
    kinds = {"/faults/LocalView/Template": ViewTemplate, "/faults/PoseCell/State": PoseCellState,
             "/faults/ExperienceMap/RobotPose": PoseStamped}
    for topic, kind in kinds.items():
        listeners = [listener(topic, kind, f"/listener_{number}") for number in range(64)]
        received = dict.fromkeys(listeners[:-1], 0)
        end = time.monotonic() + 5.0
        while time.monotonic() < end:
            for ready in select.select(listeners[:-1], [], [], 0.2)[0]:
                received[ready] += len(ready.recv(65536))
        for connection in listeners:
            connection.close()
        if min(received.values()) < 1000:
            raise AssertionError(f"{topic}: a listener got {min(received.values())} bytes in 5 s")


def listener(topic, kind, caller):
    """A subscriber as ROS sees it: a connection that has asked for the topic. @return the socket"""
    master = xmlrpc.client.ServerProxy(os.environ["ROS_MASTER_URI"])
    publishers = dict(master.getSystemState(caller)[2][0])
    node = xmlrpc.client.ServerProxy(master.lookupNode(caller, publishers[topic][0])[2])
    _, host, port = node.requestTopic(caller, topic, [["TCPROS"]])[2]
    fields = [f"callerid={caller}", f"topic={topic}", f"type={kind._type}", f"md5sum={kind._md5sum}"]
    header = b"".join(struct.pack("<I", len(field)) + field.encode() for field in fields)
    connection = socket.create_connection((host, port))
    connection.sendall(struct.pack("<I", len(header)) + header)
    return connection


FAULTS = {"kill": kill, "stop": stop, "restart": restart, "clock_back": clock_back, "clock_ahead": clock_ahead, "camera_clock_back": camera_clock_back,
          "no_odometry": no_odometry, "no_images": no_images, "other_size": other_size, "late_odometry": late_odometry,
          "late_images": late_images, "no_camera_info": no_camera_info, "other_camera_info": other_camera_info,
          "late_camera_info": late_camera_info, "disk_full": disk_full, "subscribers": subscribers, "master": None}
OF_A_NODE = ("kill", "stop", "restart")
WITH_CAMERA = ("no_camera_info", "other_camera_info", "late_camera_info")  # recalls are verified


def trial(fault, node, seed, seconds):
    """One trial in this process. @return what is wrong, or an empty text"""
    port = free_port()
    os.environ.update(ROS_MASTER_URI=f"http://localhost:{port}", ROS_HOSTNAME="localhost")
    chance = random.Random(f"{fault} {node} {seed}")
    with tempfile.TemporaryDirectory() as folder:
        os.environ.update(ROS_HOME=folder, ROS_LOG_DIR=folder)
        master = subprocess.Popen(["rosmaster", "--core", "-p", str(port)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        import harness
        import rosgraph
        import rospy
        from geometry_msgs.msg import PoseStamped
        if not harness.wait_until(rosgraph.is_master_online, 30.0):
            return "the master did not start"
        rospy.init_node("faults", disable_signals=True)
        poses = []
        rospy.Subscriber("/faults/ExperienceMap/RobotPose", PoseStamped, lambda message: poses.append(message.header.stamp))
        if fault == "disk_full":  # a small disk of its own
            os.mkdir(os.path.join(folder, "map"))
            subprocess.run(["mount", "-t", "tmpfs", "-o", "size=16m", "tmpfs", os.path.join(folder, "map")], check=True)
        chain = Chain(harness, folder, port, **({"vt_verify": "orb"} if fault in WITH_CAMERA else {}))
        drive = Drive(harness, rospy)
        drive.start()
        try:
            if not harness.wait_until(lambda: len(poses) > 20, 60.0):
                return "no robot poses before the fault: " + chain.complaint_at_the_end()
            time.sleep(chance.uniform(0.0, 6.0))
            if fault == "master":
                master.kill()
                master.wait()
            else:
                try:
                    FAULTS[fault](chain, drive, node, seconds)
                except AssertionError as error:
                    return f"{error}; " + chain.complaint_at_the_end()
            before = len(poses)
            if not harness.wait_until(lambda: len(poses) > before + 20, 60.0):
                return f"{len(poses) - before} robot poses in 60 s after the fault; " + chain.complaint_at_the_end()
            time.sleep(2.0)
            return chain.complaint_at_the_end()
        finally:
            drive.ended = True
            for left in chain.nodes.values():
                if left.process.poll() is None:
                    left.process.kill()
            master.kill()
            master.wait()
            if fault == "disk_full":
                subprocess.run(["umount", "-l", os.path.join(folder, "map")], check=False)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--faults", nargs="+", choices=sorted(FAULTS), default=sorted(FAULTS))
    parser.add_argument("--moments", type=int, default=10, help="trials of each fault (and node), each at its own moment")
    parser.add_argument("--stop-seconds", type=float, default=20.0, help="how long nodes are stopped and streams silent")
    parser.add_argument("--trial", nargs=3, metavar=("FAULT", "NODE", "SEED"), help="only this one, in this process")
    options = parser.parse_args()
    if options.trial:
        complaint = trial(options.trial[0], options.trial[1], options.trial[2], options.stop_seconds)
        print(complaint or "well", flush=True)
        os._exit(1 if complaint else 0)  # rospy's threads outlive a dead master
    failed = 0
    print("| fault | node | trials | well |\n|---|---|---|---|")
    for fault in options.faults:
        for node in NODES if fault in OF_A_NODE else ("-",):
            complaints = []
            for seed in range(options.moments):
                command = [sys.executable, __file__, "--stop-seconds", str(options.stop_seconds), "--trial", fault, node, str(seed)]
                said = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
                if said.returncode:
                    words = (said.stdout.strip() or said.stderr.strip()[-400:])
                    complaints.append(f"seed {seed}: {words}")
            print(f"| {fault} | {node} | {options.moments} | {options.moments - len(complaints)} |", flush=True)
            for complaint in complaints:
                print(f"  {fault} {node}, {complaint}", file=sys.stderr, flush=True)
            failed += len(complaints)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
