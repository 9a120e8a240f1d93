#!/usr/bin/python3
"""Drives the nodes through a town, live, and says what the thread sanitizer reports in them: node_threads.py BAG PROGRAMS LOGS

BAG is a drive by ratslam_town; PROGRAMS the folder of the nodes, built with the sanitizer. Under a master of its own local view
(which verifies recalls), pose cells, map and both visual odometries take the drive twice: into a new map, and into the saved
one. Meanwhile each is looked at by a subscriber, takes checkpoints many times a second, is reconfigured, and its services are
called; then all are stopped by SIGINT. What they say goes to LOGS. Exits with 1 where one reports a race, ends by itself or
maps nothing.
"""
import argparse
import glob
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "integration"))

ROOT = "/town"
CROP = {"image_crop_y_min": 30, "image_crop_y_max": 150}
NODES = {
    "ratslam_lv": {"vt_verify": "orb", "image_transport": "compressed", "image_queue_size": 0, **CROP},
    "ratslam_pc": {},
    "ratslam_em": {},
    "ratslam_orb_vo": {"image_transport": "compressed", "image_queue_size": 0, "threads": 3},
    "ratslam_vo": {"image_transport": "compressed", "image_queue_size": 0, "publish_tf": False,
                   "map_dir": ""},  # where the other odometry has its share
}
PICTURES = ("LocalView/View", "PoseCell/Activity", "ExperienceMap/Picture")
LINKS = (("ratslam_lv", "LocalView/Template", "ratslam_pc"), ("ratslam_pc", "PoseCell/State", "ratslam_em"),
         *(("ratslam_orb_vo", "odom", listener) for listener in ("ratslam_lv", "ratslam_pc", "ratslam_em")))
PATIENCE_S = 300.0  # a sanitised node is up to twenty times as slow


def start(harness, name, options, folder):
    parameters = {"topic_root": ROOT, "map_dir": os.path.join(folder, "map"), "autosave_period": 0.2, **NODES[name]}
    if name == "ratslam_em":
        parameters["trajectory_file"] = os.path.join(folder, "run")
    command = [os.path.join(options.programs, name), harness.demo_config(), *(f"_{key}:={value}" for key, value in parameters.items())]
    if name == "ratslam_vo":
        command.append(f"{ROOT}/odom:={ROOT}/odom_of_profiles")
    return harness.Process(command)


def foreign_libraries(process, options):
    """Our libraries that a running node has loaded from elsewhere: in those the sanitizer sees nothing."""
    with open(f"/proc/{process.pid}/maps", encoding="utf-8") as maps:
        loaded = {line.split()[-1] for line in maps if "/libratslam" in line}
    own = os.path.realpath(os.path.join(options.programs, ".."))
    return sorted(path for path in loaded if not os.path.realpath(path).startswith(own + os.sep))


def disturb(rospy, step):
    """What a user does to running nodes."""
    from dynamic_reconfigure.client import Client
    from ratslam_ros.srv import MapPath
    from std_srvs.srv import SetBool, Trigger

    def call(name, kind, *arguments):
        name = f"{ROOT}/ExperienceMap/{name}"
        rospy.wait_for_service(name, PATIENCE_S)
        answer = rospy.ServiceProxy(name, kind)(*arguments)
        if not answer.success:
            raise RuntimeError(f"{name}: {answer.message}")

    if step == 10:
        for node, key, value in (("ratslam_lv", "vt_match_threshold", 0.05), ("ratslam_pc", "pc_vt_inject_energy", 0.2)):
            Client(node, timeout=PATIENCE_S).update_configuration({key: value})
    elif step == 25:
        call("SaveMap", MapPath, "saved.db")
        call("WriteTrajectories", Trigger)
    elif step == 35:
        call("Pause", SetBool, True)
    elif step == 40:
        call("Pause", SetBool, False)
    elif step == 50:
        call("SaveMap", MapPath, "")


def drive(harness, options, folder, later_s):
    """One drive, its stamps so much later than those of the bag. @return nodes, and what is wrong, by node"""
    import genpy
    import rosbag
    import rospy
    from diagnostic_msgs.msg import DiagnosticArray
    from geometry_msgs.msg import PoseStamped
    from nav_msgs.msg import Odometry, Path
    from ratslam_ros.msg import TopologicalMap
    from sensor_msgs.msg import CameraInfo, CompressedImage, Image

    poses = []
    watched = [rospy.Subscriber(f"{ROOT}/ExperienceMap/RobotPose", PoseStamped, poses.append)]
    watched += [rospy.Subscriber(f"{ROOT}/{name}", Image, lambda message: None) for name in PICTURES]
    for topic, kind in ((f"{ROOT}/odom", Odometry), (f"{ROOT}/ExperienceMap/Map", TopologicalMap),
                        (f"{ROOT}/ExperienceMap/Path", Path), ("/diagnostics", DiagnosticArray)):
        watched.append(rospy.Subscriber(topic, kind, lambda message: None))
    nodes = {name: start(harness, name, options, folder) for name in NODES}

    def ended():
        return any(node.process.poll() is not None for node in nodes.values())

    images = rospy.Publisher(f"{ROOT}/camera/image/compressed", CompressedImage, queue_size=1000)
    infos = rospy.Publisher(f"{ROOT}/camera/camera_info", CameraInfo, queue_size=1000)

    def connected():
        return (images.get_num_connections() >= 3 and infos.get_num_connections() >= 2 and watched[0].get_num_connections() > 0
                and all((f"{ROOT}/{topic}", "/" + listener) in harness.links("/" + name) for name, topic, listener in LINKS))

    wrong = {}
    if not harness.wait_for_links(connected, PATIENCE_S):
        wrong["all"] = "the nodes did not connect"
    for name, node in nodes.items():
        if node.process.poll() is None and foreign_libraries(node.process, options):
            wrong["all"] = f"{name} runs with {foreign_libraries(node.process, options)[0]}, which the sanitizer does not see"
    step = 0
    try:
        for topic, message, _ in rosbag.Bag(options.bag).read_messages():
            if wrong or ended():
                break
            if topic.endswith("camera_info") or topic.endswith("compressed"):
                message.header.stamp += genpy.Duration(later_s)
                (images if topic.endswith("compressed") else infos).publish(message)
            if topic.endswith("compressed"):
                step += 1
                print(f"{step} images, {len(poses)} robot poses", file=sys.stderr, flush=True)
                disturb(rospy, step)
                time.sleep(0.2)
                # Whoever is far behind would be asked for what it does not know yet; the ORB odometry begins with some images' delay.
                harness.wait_until(lambda: len(poses) >= step - 30 or ended(), PATIENCE_S)
        harness.wait_until(lambda: len(poses) >= step - 2 or ended(), PATIENCE_S)
        if len(poses) < step - 5:
            wrong["all"] = wrong.get("all", f"{len(poses)} robot poses of {step} images")
        for name, node in nodes.items():
            if node.process.poll() is not None:
                wrong[name] = "ended by itself"
    finally:
        for node in nodes.values():
            if node.process.poll() is None:
                node.process.send_signal(signal.SIGINT)
        codes = {name: node.interrupt(PATIENCE_S) for name, node in nodes.items()}
    for name, node in nodes.items():
        reports = node.count("WARNING: ThreadSanitizer")
        if codes[name] != 0 or reports:
            wrong[name] = f"{wrong.get(name, '')} ended with {codes[name]}, {reports} reports".strip()
    for subscriber in watched:
        subscriber.unregister()
    return nodes, wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("bag", "programs", "logs"):
        parser.add_argument(name)
    options = parser.parse_args()
    os.makedirs(options.logs, exist_ok=True)
    for former in glob.glob(os.path.join(options.logs, "ratslam_*.log")):
        os.remove(former)
    with socket.socket() as free:
        free.bind(("", 0))
        port = free.getsockname()[1]
    failed = False
    with tempfile.TemporaryDirectory() as folder:
        os.environ.update(ROS_MASTER_URI=f"http://localhost:{port}", ROS_HOSTNAME="localhost", ROS_HOME=folder, ROS_LOG_DIR=folder)
        os.mkdir(os.path.join(folder, "map"))
        master = subprocess.Popen(["rosmaster", "--core", "-p", str(port)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        import harness
        import rosgraph
        import rospy
        try:
            if not harness.wait_until(rosgraph.is_master_online, 60.0):
                sys.exit("node_threads.py: the master did not start")
            rospy.init_node("node_threads", disable_signals=True)
            for part, later_s in (("new", 0), ("again", 100)):
                nodes, wrong = drive(harness, options, folder, later_s)
                for name, node in nodes.items():
                    with open(os.path.join(options.logs, f"{name}_{part}.log"), "w", encoding="utf-8") as log:
                        log.write(node.output() + "\n")
                    print(f"{name}, {part} map: {wrong.get(name, 'no race')}", flush=True)
                if "all" in wrong:
                    print(f"{part} map: {wrong['all']}", flush=True)
                failed = failed or bool(wrong)
        finally:
            master.kill()
            master.wait()
    sys.stdout.flush()
    os._exit(1 if failed else 0)  # rospy's threads outlive a dead master


if __name__ == "__main__":
    main()
