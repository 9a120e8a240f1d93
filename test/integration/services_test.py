#!/usr/bin/python3
"""The services of the map's node, which act on local view, pose cells and map together: what each does, and what it refuses."""
import os
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

import rospy
import rostest
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from ratslam_ros.msg import TopologicalMap, ViewTemplate
from ratslam_ros.srv import MapPath
from sensor_msgs.msg import Image
from std_srvs.srv import SetBool, Trigger

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import harness  # noqa: E402  (lies beside this file)

LAP = harness.LAP_FRAMES


class Services(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("services_test")
        cls.strip = harness.panorama()

    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.map_dir = os.path.join(self.folder, "map")
        self.config = os.path.join(self.folder, "config.yaml")
        harness.write_config(self.config)
        self.name = self.id().rsplit(".", 1)[-1]
        self.root = "/" + self.name
        self.poses, self.maps, self.views, self.next, self.nodes = [], [], [], 0, []
        self.images = rospy.Publisher(self.root + "/camera/image", Image, queue_size=1000)
        self.odometry = rospy.Publisher(self.root + "/odom", Odometry, queue_size=1000)
        self.listeners = [rospy.Subscriber(self.root + "/ExperienceMap/RobotPose", PoseStamped, self.poses.append),
                          rospy.Subscriber(self.root + "/ExperienceMap/Map", TopologicalMap, self.maps.append),
                          rospy.Subscriber(self.root + "/LocalView/Template", ViewTemplate,
                                           lambda message: self.views.append(message.current_id))]

    def tearDown(self):
        for node in self.nodes:
            node.interrupt()
        for listener in self.listeners:
            listener.unregister()
        shutil.rmtree(self.folder)

    def start(self, *names, **parameters):
        for name in names:
            own = {"wait_for_subscribers": 1} if name != "ratslam_em" else {"trajectory_file": self.folder + "/paths/run"}
            own = {"topic_root": self.root, "image_queue_size": 0, "map_period": 0.0, "map_dir": self.map_dir, **own, **parameters}
            self.nodes.append(harness.start_node(name, self.config, f"__name:={name}_{self.name}", **own))
        wanted = 2 if "ratslam_pc" in names else 1
        self.assertTrue(harness.wait_until(lambda: self.odometry.get_num_connections() == wanted and (
            wanted == 1 or self.images.get_num_connections() == 1), 30.0), self.words())
        time.sleep(0.3)

    def words(self):
        return "\n".join(node.output() for node in self.nodes)

    def drive(self, frames, turned=False):
        """Round the loop; `turned`: along a street that nobody has seen."""
        strip = self.strip[:, ::-1] if turned else self.strip
        for index in range(self.next, self.next + frames):
            at = harness.frame_stamp(index)
            self.odometry.publish(harness.odometry_message(at))
            self.images.publish(harness.image_message(harness.frame(strip, index), at))
            time.sleep(0.005)
        self.next += frames
        last = harness.stamp(harness.frame_stamp(self.next - 1))
        self.assertTrue(harness.wait_until(lambda: self.poses and self.poses[-1].header.stamp == last, 30.0), self.words())

    def call(self, name, kind, *arguments):
        service = self.root + "/ExperienceMap/" + name
        rospy.wait_for_service(service, 15.0)
        return rospy.ServiceProxy(service, kind)(*arguments)

    def done(self, name, kind, *arguments):
        answer = self.call(name, kind, *arguments)
        self.assertTrue(answer.success, answer.message)
        return answer.message

    def refused(self, expected, name, kind, *arguments):
        answer = self.call(name, kind, *arguments)
        self.assertFalse(answer.success, answer.message)
        self.assertIn(expected, answer.message)
        self.assertNotIn("\n", answer.message)

    def experiences(self):
        return self.maps[-1].node_count if self.maps else 0

    def test_a_map_is_saved_forgotten_and_loaded_again(self):
        self.start("ratslam_em", "ratslam_pc", "ratslam_lv")
        self.refused("nothing to save yet", "SaveMap", MapPath, "lap.db")
        self.drive(LAP + 20)
        known, templates = self.experiences(), max(self.views) + 1
        self.assertGreater(known, 10)
        self.done("SaveMap", MapPath, "lap.db")
        kept = os.path.join(self.map_dir, "lap.db")
        told = subprocess.run([harness.executable("ratslam_map"), "info", kept], stdout=subprocess.PIPE, text=True, check=True).stdout
        self.assertIn(str(known), told)
        self.assertEqual([name for name in os.listdir(self.map_dir) if ".part" in name], [])

        self.done("Reset", Trigger)
        del self.views[:]
        self.drive(10)
        self.assertLess(self.experiences(), known)
        self.assertEqual(min(self.views), 0)

        self.done("LoadMap", MapPath, kept)
        self.assertTrue(harness.wait_until(lambda: self.experiences() == known), self.words())
        del self.views[:]
        self.drive(20)
        self.assertEqual([view for view in self.views if view >= templates], [], "views that were known have been learned again")
        self.done("SaveMap", MapPath, "")
        for part in ("local_view", "pose_cells", "experience_map"):
            self.assertTrue(os.path.exists(os.path.join(self.map_dir, part + ".a.db")), part)

        # The runner goes on in a map of the nodes.
        bag = os.path.join(self.folder, "on.bag")
        harness.write_bag(bag, self.root, LAP, odometry_period_ns=harness.FRAME_PERIOD_NS)
        run = subprocess.run([harness.executable("ratslam_run"), bag, "--config", self.config, "--odometry", "topic", "--out",
                              os.path.join(self.folder, "run"), "--load-map", kept, "--localise-only"],
                             stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        self.assertEqual(run.returncode, 0, run.stdout)
        self.assertIn(f"{known} experiences", run.stdout)

    def test_what_is_refused(self):
        self.start("ratslam_em")
        self.refused("nobody offers", "SaveMap", MapPath, "lap.db")
        self.refused("nobody offers", "Reset", Trigger)
        self.start("ratslam_pc", "ratslam_lv")
        self.drive(30)
        os.makedirs(os.path.join(self.map_dir, "monday"))
        os.symlink(self.folder, os.path.join(self.map_dir, "elsewhere"))
        os.symlink(os.path.join(self.folder, "secret.db"), os.path.join(self.map_dir, "link.db"))
        for path, expected in (("../lap.db", "must not lead upwards"), ("monday/../../lap.db", "must not lead upwards"),
                               (os.path.join(self.folder, "lap.db"), "inside " + self.map_dir), ("elsewhere/lap.db", "symbolic link"),
                               ("link.db", "symbolic link"), ("tuesday/lap.db", "there is no folder"), ("monday", "it is a folder"),
                               ("lap.txt", "must end in .db"), ("local_view.a.db", "no other dot")):
            self.refused(expected, "SaveMap", MapPath, path)
        with open(os.path.join(self.map_dir, "letter.db"), "w", encoding="utf-8") as file:
            file.write("dear map")
        self.refused("not a map file", "SaveMap", MapPath, "letter.db")
        self.refused("no such map file", "LoadMap", MapPath, "never.db")
        self.refused("not a map file", "LoadMap", MapPath, "letter.db")
        self.refused("holds nothing of", "LoadMap", MapPath, "local_view.a.db" if os.path.exists(
            self.map_dir + "/local_view.a.db") else self.checkpoint())
        self.refused("must not lead upwards", "SaveTrajectories", MapPath, "../run")
        self.refused("must name a file inside", "SaveTrajectories", MapPath, "/etc/run")
        self.assertFalse(os.path.exists(os.path.join(self.folder, "secret.db")))
        self.drive(10)  # nothing has happened to the nodes

    def test_without_a_folder_nothing_is_kept_and_everybody_says_so(self):
        self.start("ratslam_em", "ratslam_pc", "ratslam_lv", map_dir="", autosave_period=2.0)
        for node in self.nodes:
            self.assertEqual(node.count("map_dir is not set: .* starts without memory, and what it learns ends with"), 1, node.output())
            self.assertEqual(node.count("autosave_period = 2 has no effect: map_dir is not set"), 1, node.output())
        self.drive(30)
        for service in ("SaveMap", "LoadMap"):
            for path in ("", "lap.db", os.path.join(self.folder, "lap.db")):
                self.refused("map_dir is not set", service, MapPath, path)
        self.done("Reset", Trigger)
        self.done("LocaliseOnly", SetBool, True)
        self.done("LocaliseOnly", SetBool, False)
        self.assertFalse([name for _, _, names in os.walk(self.folder) for name in names if ".db" in name])

    def test_a_part_without_a_folder_is_named(self):
        self.start("ratslam_em")
        self.start("ratslam_pc", "ratslam_lv", map_dir="")
        self.drive(30)
        self.refused("local_view: the parameter map_dir is not set", "SaveMap", MapPath, "")
        self.refused("local_view: the parameter map_dir is not set", "SaveMap", MapPath, "lap.db")
        self.assertFalse(os.path.exists(os.path.join(self.map_dir, "lap.db")))

    def checkpoint(self):
        self.done("SaveMap", MapPath, "")
        return "local_view.a.db"

    def test_trajectories_go_where_the_request_says(self):
        self.start("ratslam_em", "ratslam_pc", "ratslam_lv")
        self.drive(40)
        self.done("SaveTrajectories", MapPath, "so_far")
        self.done("WriteTrajectories", Trigger)
        for kind in ("_online.tum", "_final.tum", "_map.yaml"):
            with open(self.folder + "/paths/so_far" + kind, encoding="utf-8") as one, \
                    open(self.folder + "/paths/run" + kind, encoding="utf-8") as other:
                self.assertEqual(one.read(), other.read())
        self.done("SaveTrajectories", MapPath, os.path.join(self.map_dir, "so_far.tum"))
        self.assertTrue(os.path.exists(os.path.join(self.map_dir, "so_far_final.tum")))

    def test_paused_the_robot_moves_on_and_nothing_is_learned(self):
        self.start("ratslam_em", "ratslam_pc", "ratslam_lv")
        self.drive(20)
        known, poses = self.experiences(), len(self.poses)
        self.done("Pause", SetBool, True)
        self.drive(20)
        self.assertEqual(self.experiences(), known)
        before, after = self.poses[poses - 1].pose.position, self.poses[-1].pose.position
        self.assertGreater(abs(after.x - before.x) + abs(after.y - before.y), 1.0)
        self.done("Pause", SetBool, False)
        self.drive(20)
        self.assertGreater(self.experiences(), known)

    def test_localise_only_finds_places_and_leaves_map_and_files_as_they_are(self):
        self.start("ratslam_em", "ratslam_pc", "ratslam_lv")
        self.drive(LAP + 10)
        self.done("SaveMap", MapPath, "")
        self.done("LocaliseOnly", SetBool, True)
        known, poses = self.experiences(), len(self.poses)
        contents = {name: os.path.getmtime(os.path.join(self.map_dir, name)) for name in os.listdir(self.map_dir)}
        self.drive(30)
        self.drive(60, turned=True)
        self.assertEqual(self.experiences(), known)
        self.assertGreater(len(self.poses), poses + 80)
        self.refused("local_view: nothing is learned (localise_only)", "SaveMap", MapPath, "")
        self.assertEqual({name: os.path.getmtime(os.path.join(self.map_dir, name)) for name in os.listdir(self.map_dir)}, contents)
        self.done("LocaliseOnly", SetBool, False)
        self.drive(60, turned=True)
        self.assertGreater(self.experiences(), known)


if __name__ == "__main__":
    rostest.rosrun("ratslam_ros", "services", Services, sys.argv)
