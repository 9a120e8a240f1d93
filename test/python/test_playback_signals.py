"""However a playback is asked to end, it ends its player and leaves the master as it was."""

import os
import signal
import socket
import subprocess
import sys
import threading
import time
import xmlrpc.client
import xmlrpc.server

import pytest

rosbag = pytest.importorskip("rosbag")
rospy = pytest.importorskip("rospy")
pytest.importorskip("rosmaster")

from sensor_msgs.msg import CompressedImage  # noqa: E402
from std_msgs.msg import Header  # noqa: E402

from conftest import SCRIPTS  # noqa: E402

TOPIC = "/cam/image/compressed"
PATIENCE_S = 60.0


def free_port():
    with socket.socket() as probe:
        probe.bind(("localhost", 0))
        return probe.getsockname()[1]


def until(condition):
    deadline = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.1)


@pytest.fixture
def master(tmp_path):
    """A master of this test's own: its environment and its interface."""
    port = free_port()
    environment = dict(os.environ, ROS_MASTER_URI=f"http://localhost:{port}", ROS_HOSTNAME="localhost", ROS_HOME=str(tmp_path))
    process = subprocess.Popen(["rosmaster", "--core", "-p", str(port)], env=environment, stdout=subprocess.DEVNULL,
                               stderr=subprocess.DEVNULL)
    proxy = xmlrpc.client.ServerProxy(environment["ROS_MASTER_URI"])

    def up():
        try:
            return proxy.getPid("/test")[0] == 1
        except OSError:
            return False

    try:
        until(up)
        yield environment, proxy
    finally:
        process.terminate()
        process.wait(30)


def nodes(proxy):
    return {node for kind in proxy.getSystemState("/test")[2] for _, names in kind for node in names}


def play(tmp_path, environment, **options):
    """A playback of a minute."""
    path = str(tmp_path / "drive.bag")
    with rosbag.Bag(path, "w") as bag:
        for second in range(100, 160):
            bag.write(TOPIC, CompressedImage(header=Header(stamp=rospy.Time(second)), format="jpeg", data=b"x"), rospy.Time(second))
    words = [os.path.join(SCRIPTS, "playback"), path, "--image-topic", TOPIC, "--pose-topic", "/pose"]
    return subprocess.Popen([sys.executable, *words], env=environment, **options)


@pytest.mark.parametrize("option", ["--silence", "--rate"])
@pytest.mark.parametrize("value", ["nan", "inf", "-1", "soon"])
def test_times_that_are_none_are_refused(option, value):
    words = [os.path.join(SCRIPTS, "playback"), "x.bag", "--image-topic", TOPIC, "--pose-topic", "/pose", f"{option}={value}"]
    done = subprocess.run([sys.executable, *words], stderr=subprocess.PIPE, timeout=PATIENCE_S, check=False)
    assert done.returncode == 2 and f"argument {option}: ".encode() in done.stderr


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_a_playback_that_is_asked_to_end_leaves_nothing_behind(tmp_path, master, name):
    environment, proxy = master
    process, player = play(tmp_path, environment), None
    try:
        until(lambda: {"/player", "/playback"} <= nodes(proxy) or process.poll() is not None)
        assert proxy.getParam("/test", "/use_sim_time")[2] is True
        player = xmlrpc.client.ServerProxy(proxy.lookupNode("/test", "/player")[2]).getPid("/test")[2]
        process.send_signal(getattr(signal, name))
        assert process.wait(PATIENCE_S) == 0
        until(lambda: not os.path.exists(f"/proc/{player}"))  # rosbag's own program ends a moment after the command
        assert not nodes(proxy) & {"/player", "/playback"}
        assert proxy.hasParam("/test", "/use_sim_time")[2] is False
    finally:
        if process.poll() is None:
            process.kill()
            process.wait()
        if player is not None and os.path.exists(f"/proc/{player}"):
            os.kill(player, signal.SIGINT)


def test_a_playback_goes_on_where_the_end_of_its_terminal_is_ignored(tmp_path, master):
    """As under nohup."""
    environment, proxy = master
    process = play(tmp_path, environment, preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))
    try:
        until(lambda: {"/player", "/playback"} <= nodes(proxy) or process.poll() is not None)
        process.send_signal(signal.SIGHUP)
        time.sleep(1.0)
        assert process.poll() is None and "/player" in nodes(proxy)
        process.send_signal(signal.SIGTERM)
        assert process.wait(PATIENCE_S) == 0
    finally:
        if process.poll() is None:
            process.kill()
            process.wait()


def test_a_player_that_has_ended_is_not_taken_for_the_new_one(tmp_path, master):
    """The master still knows it, and another program listens at its port."""
    environment, proxy = master
    with xmlrpc.server.SimpleXMLRPCServer(("localhost", 0), logRequests=False) as other:
        threading.Thread(target=other.serve_forever, daemon=True).start()
        stale = f"http://localhost:{other.server_address[1]}"
        proxy.registerPublisher("/player", "/clock", "rosgraph_msgs/Clock", stale)
        process = play(tmp_path, environment)
        try:
            until(lambda: proxy.lookupNode("/test", "/player")[2] != stale or process.poll() is not None)
            assert process.poll() is None
            process.send_signal(signal.SIGINT)
            assert process.wait(PATIENCE_S) == 0
        finally:
            process.kill()
            other.shutdown()
