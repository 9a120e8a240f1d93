#!/usr/bin/python3
"""The services of the map's node, which act on local view, pose cells and map together: what each does, and what it refuses."""
import os
import signal
import subprocess
import sys
import threading
import time

import rosbag
import rospy
import rostest
from ratslam_ros.msg import TopologicalMap, ViewTemplate
from ratslam_ros.srv import MapPath, PartCommand, PartCommandRequest
from std_srvs.srv import SetBool, Trigger

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import chain  # noqa: E402  (lies beside this file)
import harness  # noqa: E402

LAP = harness.LAP_FRAMES


class Services(chain.ChainTest):
    PARAMETERS = {"map_period": 0.0}

    def setUp(self):
        super().setUp()
        self.maps = self.collected("ExperienceMap/Map", TopologicalMap)
        self.views = self.collected("LocalView/Template", ViewTemplate)

    def start(self, name, *arguments, **parameters):
        own = {"trajectory_file": self.home + "/paths/run"} if name == "ratslam_em" else {}
        return super().start(name, *arguments, **{**own, **parameters})

    def seen(self):
        return [view.current_id for view in self.views]

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

    def command(self, part, **fields):
        return rospy.ServiceProxy(f"{self.root}/{part}/Command", PartCommand)(PartCommandRequest(**fields))

    def experiences(self):
        return self.maps[-1].node_count if self.maps else 0

    def test_a_map_is_saved_forgotten_and_loaded_again(self):
        self.chain("ratslam_em", "ratslam_pc", "ratslam_lv")
        self.refused("nothing to save yet", "SaveMap", MapPath, "lap.db")
        self.refused("nothing to save yet", "SaveTrajectories", MapPath, "so_far")
        self.refused("nothing to save yet", "WriteTrajectories", Trigger)
        self.drive(LAP + 20)
        known, templates = self.experiences(), max(self.seen()) + 1
        self.assertGreater(known, 10)
        self.done("SaveMap", MapPath, "lap.db")
        kept = os.path.join(self.map_dir, "lap.db")
        told = subprocess.run([harness.executable("ratslam_map"), "info", kept], stdout=subprocess.PIPE, text=True, check=True).stdout
        self.assertIn(str(known), told)
        self.assertEqual([name for name in os.listdir(self.map_dir) if ".part" in name], [])

        self.done("Reset", Trigger)
        self.wait(lambda: self.experiences() == 0)  # the map that is latched is no longer there
        kept_bytes = harness.contents(kept)
        for service, arguments in (("SaveMap", "lap.db"), ("SaveTrajectories", "so_far")):
            self.refused("nothing to save yet", service, MapPath, arguments)
        self.assertEqual(harness.contents(kept), kept_bytes)
        del self.views[:]
        self.drive(10)
        self.assertLess(self.experiences(), known)
        self.wait(lambda: 0 in self.seen())  # views arrive on a connection of their own, perhaps after the poses

        self.done("LoadMap", MapPath, kept)
        self.wait(lambda: self.experiences() == known)
        del self.views[:]
        self.drive(20)
        self.assertEqual([view for view in self.seen() if view >= templates], [], "views that were known have been learned again")
        self.done("SaveMap", MapPath, "")
        for part in ("local_view", "pose_cells", "experience_map"):
            self.assertTrue(os.path.exists(os.path.join(self.map_dir, part + ".a.db")), part)

        # The runner goes on in a map of the nodes.
        bag = os.path.join(self.home, "on.bag")
        harness.write_bag(bag, self.root, LAP, odometry_period_ns=harness.FRAME_PERIOD_NS)
        run = harness.offline(bag, self.config, os.path.join(self.home, "run"), "--odometry", "topic", "--load-map", kept,
                              "--localise-only")
        self.assertEqual(run.returncode, 0, run.stdout)
        self.assertIn(f"{known} experiences", run.stdout)

    def recorded(self, name, frames):
        """A drive as a bag. @return its path"""
        bag = os.path.join(self.home, name)
        harness.write_bag(bag, self.root, frames, odometry_period_ns=harness.FRAME_PERIOD_NS)
        return bag

    def played(self, bag, at_frame=lambda frame: None):
        """Plays it without waiting for the map, as a robot drives; and waits for its end."""
        odometry, images = self.feeds
        frame, last = 0, None
        for topic, message, _ in rosbag.Bag(bag).read_messages():
            if not topic.endswith("/image"):
                odometry.publish(message)
                continue
            images.publish(message)
            last = message.header.stamp
            frame += 1
            at_frame(frame)
            time.sleep(0.01)
        self.wait(lambda: self.poses and self.poses[-1].header.stamp == last, 60.0)

    def tool(self, *words):
        return subprocess.run([harness.executable("ratslam_map"), *words], stdout=subprocess.PIPE, text=True, check=False)

    def sound(self, name):
        told = self.tool("check", os.path.join(self.map_dir, name))
        self.assertEqual(told.returncode, 0, told.stdout)

    def meanwhile(self, action):
        """Repeats an action in a thread. @return function that ends it"""
        over = threading.Event()

        def work():
            while not over.is_set():
                action()
                time.sleep(0.05)

        thread = threading.Thread(target=work)
        thread.start()

        def end():
            over.set()
            thread.join()
        return end

    def test_saved_in_mid_drive_the_parts_fit_and_the_drive_goes_on_as_without(self):
        self.chain("ratslam_em", "ratslam_pc", "ratslam_lv")
        bag = self.recorded("lap.bag", 2 * LAP)
        self.wait(self.connected)
        names, answers = [], []

        def save():
            names.append(f"{len(names)}.db")
            answers.append(self.call("SaveMap", MapPath, names[-1]))
            for part in ("LocalView", "PoseCell"):  # whether it can be loaded: that changes nothing either
                answers.append(self.command(part, command=PartCommandRequest.CHECK, path=os.path.join(self.map_dir, names[-1])))

        end = []
        try:
            self.played(bag, lambda frame: end.append(self.meanwhile(save)) if frame == 10 else None)
        finally:
            for each in end:
                each()
        self.assertGreater(len(names), 2)
        for answer in answers:
            self.assertTrue(answer.success, answer.message)
        for name in names:
            self.sound(name)
        self.done("WriteTrajectories", Trigger)
        run = harness.offline(bag, self.config, os.path.join(self.home, "run"), "--odometry", "topic")
        self.assertEqual(run.returncode, 0, run.stdout)
        self.assertEqual(harness.trajectories(self.home + "/paths/run"), harness.trajectories(self.home + "/run/trajectory"))

    def test_loaded_in_mid_drive_nothing_of_the_old_map_comes_after_it(self):
        self.chain("ratslam_em", "ratslam_pc", "ratslam_lv")
        self.drive(40)
        self.done("SaveMap", MapPath, "street.db")
        bag = self.recorded("lap.bag", LAP)

        def load(frame):
            if frame in (30, 45, 60):
                self.done("LoadMap", MapPath, "street.db")

        self.played(bag, load)
        self.done("SaveMap", MapPath, "end.db")
        self.sound("end.db")
        told = self.tool("info", os.path.join(self.map_dir, "end.db")).stdout
        self.assertEqual(told.count("session: "), 2, told)
        self.assertIn(f"from {harness.frame_stamp(0)} to {harness.frame_stamp(39)} ns", told)

    def test_a_stopped_node_is_named_and_the_map_goes_on(self):
        nodes = self.chain("ratslam_em", "ratslam_pc", "ratslam_lv")
        self.drive(10)
        nodes["ratslam_lv"].process.send_signal(signal.SIGSTOP)
        for service, arguments in (("Pause", (SetBool, True)), ("SaveMap", (MapPath, "lap.db"))):
            self.refused("LocalView/Command has not answered for 10 s: its node is stopped or too busy", service, *arguments)
        nodes["ratslam_lv"].process.send_signal(signal.SIGCONT)
        self.drive(5)
        self.done("SaveMap", MapPath, "lap.db")
        nodes["ratslam_pc"].process.send_signal(signal.SIGSTOP)
        answers = []
        asking = threading.Thread(target=lambda: answers.append(self.call("Pause", SetBool, True)))
        asking.start()
        time.sleep(1.0)
        self.assertEqual(nodes["ratslam_em"].interrupt(8.0), 0, nodes["ratslam_em"].output())
        asking.join()
        self.assertEqual([(answer.success, answer.message) for answer in answers], [(False, "the node ends")])

    def test_who_is_held_goes_on_when_the_map_is_no_more(self):
        nodes = self.chain("ratslam_em", "ratslam_pc", "ratslam_lv")
        self.drive(10)
        for part in ("LocalView", "PoseCell"):
            self.assertTrue(self.command(part, command=PartCommandRequest.HOLD, on=True).success)
        self.drive(2)
        for name in ("ratslam_lv", "ratslam_pc"):
            self.assertEqual(nodes[name].count("did not renew its hold within 10 s: processing continues"), 1, nodes[name].output())

    def test_who_has_lost_messages_is_named_also_when_everything_is_forgotten(self):
        nodes = self.chain("ratslam_em", "ratslam_pc", "ratslam_lv", sync_timeout=3.0)
        self.drive(10)
        self.kill({"ratslam_pc": nodes["ratslam_pc"]})
        self.chain("ratslam_pc", map_dir=self.map_dir + "_other")
        for service in ("Reset", "Pause"):
            arguments = (SetBool, True) if service == "Pause" else (Trigger,)
            answer = self.call(service, *arguments)
            self.assertEqual(answer.success, service == "Pause", answer.message)  # by then everybody has forgotten the messages
            if not answer.success:
                self.assertRegex(answer.message, "^pose_cells: it has not received the message at .*; it was done by .*, but not at one message")
        self.wait(lambda: self.experiences() == 0)

    def test_what_was_made_anew_before_a_restart_is_not_said_again(self):
        nodes = self.chain("ratslam_em", "ratslam_pc", "ratslam_lv")
        self.drive(LAP + 5)
        em, anew = nodes["ratslam_em"], "an experience that this map does not"
        self.kill({"ratslam_em": em})
        for turn in "ab":
            kept = os.path.join(self.map_dir, f"experience_map.{turn}.db")
            if os.path.exists(kept):
                os.remove(kept)
        em = self.chain("ratslam_em")["ratslam_em"]
        self.drive(20)
        self.assertTrue(em.said(anew), em.output())
        self.done("SaveMap", MapPath, "")
        self.kill({"ratslam_em": em})
        em = self.chain("ratslam_em")["ratslam_em"]
        self.assertTrue(em.said("resumed from the checkpoint"), em.output())
        self.drive(10, turned=True)
        self.assertEqual(em.count(anew), 0, em.output())

    def test_pause_and_localise_only_hold_for_a_node_that_starts_again(self):
        nodes = self.chain("ratslam_em", "ratslam_pc", "ratslam_lv")
        self.drive(20)
        for service in ("Pause", "LocaliseOnly"):
            self.done(service, SetBool, True)
            known = self.experiences()
            self.kill(nodes)
            nodes = self.chain("ratslam_em", "ratslam_pc", "ratslam_lv")
            for node in nodes.values():
                self.assertEqual(node.count(f"WARN.*ExperienceMap/{service} asked before it started"), 1, node.output())
            contents = {name: os.path.getmtime(os.path.join(self.map_dir, name)) for name in os.listdir(self.map_dir)}
            self.drive(20, turned=True)
            self.assertLessEqual(self.experiences(), known)
            if service == "LocaliseOnly":
                self.assertEqual({name: os.path.getmtime(os.path.join(self.map_dir, name)) for name in os.listdir(self.map_dir)}, contents)
            self.done(service, SetBool, False)
            self.drive(30)

    def test_what_is_refused(self):
        self.chain("ratslam_em")
        self.refused("nobody offers", "SaveMap", MapPath, "lap.db")
        self.refused("nobody offers", "Reset", Trigger)
        self.chain("ratslam_pc", "ratslam_lv")
        self.drive(30)
        os.makedirs(os.path.join(self.map_dir, "monday"))
        os.symlink(self.home, os.path.join(self.map_dir, "elsewhere"))
        os.symlink(os.path.join(self.home, "secret.db"), os.path.join(self.map_dir, "link.db"))
        for path, expected in (("a\nb.db", "control characters"), ("lap.db\0", "control characters"),
                               (300 * "x" + ".db", "must not be longer than 200 bytes"), ("../lap.db", "must not lead upwards"), ("monday/../../lap.db", "must not lead upwards"),
                               (os.path.join(self.home, "lap.db"), "inside " + self.map_dir), ("elsewhere/lap.db", "symbolic link"),
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
        self.assertFalse(os.path.exists(os.path.join(self.home, "secret.db")))
        self.drive(10)  # nothing has happened to the nodes

    def test_without_a_folder_nothing_is_kept_and_everybody_says_so(self):
        self.chain("ratslam_em", "ratslam_pc", "ratslam_lv", map_dir="", autosave_period=2.0)
        for node in self.nodes:
            self.assertEqual(node.count("map_dir is not set: .* starts without memory, and what it learns ends with"), 1, node.output())
            self.assertEqual(node.count("autosave_period = 2 has no effect: map_dir is not set"), 1, node.output())
        self.drive(30)
        for service in ("SaveMap", "LoadMap"):
            for path in ("", "lap.db", os.path.join(self.home, "lap.db")):
                self.refused("map_dir is not set", service, MapPath, path)
        self.done("Reset", Trigger)
        self.done("LocaliseOnly", SetBool, True)
        self.done("LocaliseOnly", SetBool, False)
        self.assertFalse([name for _, _, names in os.walk(self.home) for name in names if ".db" in name])

    def test_a_part_without_a_folder_is_named(self):
        self.chain("ratslam_em")
        self.chain("ratslam_pc", "ratslam_lv", map_dir="")
        self.drive(30)
        self.refused("local_view: the parameter map_dir is not set", "SaveMap", MapPath, "")
        self.refused("local_view: the parameter map_dir is not set", "SaveMap", MapPath, "lap.db")
        self.assertFalse(os.path.exists(os.path.join(self.map_dir, "lap.db")))

    def checkpoint(self):
        self.done("SaveMap", MapPath, "")
        return "local_view.a.db"

    def test_trajectories_go_where_the_request_says(self):
        self.chain("ratslam_em", "ratslam_pc", "ratslam_lv")
        self.drive(40)
        self.done("SaveTrajectories", MapPath, "so_far")
        self.done("WriteTrajectories", Trigger)
        for kind in ("_online.tum", "_final.tum", "_map.yaml"):
            self.assertEqual(harness.contents(self.home + "/paths/so_far" + kind), harness.contents(self.home + "/paths/run" + kind))
        self.done("SaveTrajectories", MapPath, os.path.join(self.map_dir, "so_far.tum"))
        self.assertTrue(os.path.exists(os.path.join(self.map_dir, "so_far_final.tum")))

    def test_paused_the_robot_moves_on_and_nothing_is_learned(self):
        self.chain("ratslam_em", "ratslam_pc", "ratslam_lv")
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
        self.chain("ratslam_em", "ratslam_pc", "ratslam_lv")
        self.drive(LAP + 10)
        self.done("LocaliseOnly", SetBool, True)
        for part in ("local_view", "pose_cells", "experience_map"):  # what is known so far is kept
            told = [self.tool("info", f"{self.map_dir}/{part}.{turn}.db").stdout for turn in "ab"]
            self.assertIn(f"checkpoint at {harness.frame_stamp(self.next - 1)} ns", "".join(told))
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
