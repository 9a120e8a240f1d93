"""Local view, pose cells and map as one chain of nodes: what the tests of services and of map files share."""
import os
import sys

import rospy
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Image

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import harness  # noqa: E402  (lies beside this file)


class ChainTest(harness.NodeTest):
    """Tests of local view, pose cells and map together, with a map folder, fed with images and odometry by hand."""
    LINKS = {"ratslam_lv": ("LocalView/Template", "ratslam_pc"), "ratslam_pc": ("PoseCell/State", "ratslam_em")}
    PARAMETERS = {}  # of all nodes

    def setUp(self):
        super().setUp()
        self.home = self.path(self.root[1:])
        os.makedirs(self.home)
        self.map_dir = os.path.join(self.home, "map")
        self.next, self.started, self.feeds = 0, set(), []
        self.poses = self.collected("ExperienceMap/RobotPose", PoseStamped)

    def chain(self, *names, **parameters):
        """Starts nodes and waits until all that run are connected. @return them by name"""
        if not self.feeds:
            self.feeds = [rospy.Publisher(self.root + "/odom", Odometry, queue_size=1000),
                          rospy.Publisher(self.root + "/camera/image", Image, queue_size=1000)]
        nodes = {}
        for name in names:
            own = {"map_dir": self.map_dir, **self.PARAMETERS, **({"wait_for_subscribers": 1} if name in self.LINKS else {})}
            nodes[name] = self.start(name, **{**own, **parameters})
        self.started |= set(names)
        self.assertTrue(harness.wait_for_links(self.connected), self.words())
        return nodes

    def connected(self):
        wanted = [len(self.started & {"ratslam_pc", "ratslam_em"}), len(self.started & {"ratslam_lv"})]
        return ([feed.get_num_connections() for feed in self.feeds] == wanted
                and all((f"{self.root}/{topic}", "/" + self.named(listener)) in harness.links("/" + self.named(name))
                        for name, (topic, listener) in self.LINKS.items() if {name, listener} <= self.started)
                and ("ratslam_em" not in self.started
                     or all(s.get_num_connections() for s in self.subscribers if "ExperienceMap" in s.name)))

    def kill(self, nodes):
        for name, node in nodes.items():
            node.process.kill()
            node.ended()
            self.started.discard(name)
        for feed in self.feeds:  # they count nodes that are no more
            feed.unregister()
        self.feeds = []

    def drive(self, frames, turned=False):
        """Round the loop, a frame once the map has the one before it; `turned`: along a street that nobody has seen."""
        strip = self.strip[:, ::-1] if turned else self.strip
        odometry, images = self.feeds
        for self.next in range(self.next, self.next + frames):
            at = harness.frame_stamp(self.next)
            odometry.publish(harness.odometry_message(at))
            images.publish(harness.image_message(harness.frame(strip, self.next), at))
            self.assertTrue(harness.wait_until(lambda: self.poses and self.poses[-1].header.stamp == harness.stamp(at), 30.0, 0.002), self.words())
        self.next += 1
