#!/usr/bin/python3
"""The experience map node alone, fed by hand: what it makes of decisions, and what it tells the world."""
import math
import os
import signal
import sys

import rospy
import rostest
import tf2_msgs.msg
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry, Path
from ratslam_ros.msg import PoseCellState, TopologicalAction, TopologicalMap
from std_srvs.srv import Trigger
from visualization_msgs.msg import Marker

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import harness  # noqa: E402  (lies beside this file)

CREATE, LINK = TopologicalAction.CREATE_NODE, TopologicalAction.CREATE_EDGE
# A square of 4 m: at each corner a new place, at the end the first one is recognised.
STEPS = [(CREATE, 0, 0), (CREATE, 0, 1), (CREATE, 1, 2), (CREATE, 2, 3), (LINK, 3, 0)]


class Map(harness.NodeTest):
    def setUp(self):
        super().setUp()
        self.name = self.root[1:]
        self.received = {}

    def start(self, **parameters):
        self.trajectory = os.path.join(self.folder, self.name)
        self.node = harness.start_node("ratslam_em", f"__name:=em_{self.name}", topic_root=self.root, map_period=0.0,
                                       exp_initial_em_deg=0.0, trajectory_file=self.trajectory, **parameters)
        self.nodes.append(self.node)

    def listen(self, topic, kind):
        self.received[topic] = self.collected(topic, kind, connected=True)
        return self.received[topic]

    def drive(self, odometry, decide):
        """Round the square, 1 s a side at 4 m/s, turning at the corners."""
        for corner, step in enumerate(STEPS):
            for tick in range(10):
                at = harness.START_NS + (10 * corner + tick) * 100000000
                odometry.publish(harness.odometry_message(at, 4.0, 0.0))
            at = harness.START_NS + (10 * corner + 9) * 100000000
            # A quarter turn in the last instant before the corner's next side.
            odometry.publish(harness.odometry_message(at + 10000000, 0.0, 3.141592653589793 / 2 / 0.01))
            decide(at, step)

    def drive_by_actions(self):
        """As recordings of OpenRatSLAM have it: without states of the pose cells."""
        odometry, actions = self.publisher("odom", Odometry), self.publisher("PoseCell/TopologicalAction", TopologicalAction)
        self.drive(odometry, lambda at, step: actions.publish(self.fill(TopologicalAction(), at, step)))

    @staticmethod
    def fill(message, at, step):
        message.header.stamp = harness.stamp(at)
        message.action, message.src_id, message.dest_id = step
        return message

    def test_frame_of_the_odometry_is_that_of_its_messages(self):
        self.start()
        transforms = self.listen("/tf", tf2_msgs.msg.TFMessage)
        odometry, states = self.publisher("odom", Odometry), self.publisher("PoseCell/State", PoseCellState)

        class Renamed:
            @staticmethod
            def publish(message):
                message.header.frame_id = "/wheels/odom"
                odometry.publish(message)

        self.drive(Renamed, lambda at, step: states.publish(self.fill(PoseCellState(), at, step)))
        self.assertTrue(harness.wait_until(lambda: transforms), self.node.output())
        names = {(t.header.frame_id, t.child_frame_id) for m in transforms for t in m.transforms}
        self.assertEqual(names, {("map", "wheels/odom")})

    def check_square(self, maps, frame="map"):
        self.assertTrue(harness.wait_until(lambda: maps and maps[-1].edge_count == 4), self.node.output())
        last = maps[-1]
        self.assertEqual((last.node_count, len(last.node), len(last.edge)), (4, 4, 4))
        self.assertEqual(last.header.frame_id, frame)
        self.assertEqual((last.edge[3].source_id, last.edge[3].destination_id), (3, 0))
        self.assertAlmostEqual(last.edge[0].duration.to_sec(), 1.0, places=6)
        diagonal = ((last.node[2].pose.position.x - last.node[0].pose.position.x) ** 2 +
                    (last.node[2].pose.position.y - last.node[0].pose.position.y) ** 2) ** 0.5
        self.assertAlmostEqual(diagonal, 4.0 * 2.0 ** 0.5, delta=0.8)

    def test_map_from_actions_alone_as_recorded_bags_have_them(self):
        self.start()
        maps = self.listen("ExperienceMap/Map", TopologicalMap)
        self.drive_by_actions()
        self.check_square(maps)

    def test_every_signal_that_ends_a_node_leaves_the_trajectories(self):
        root = self.root
        for number in (signal.SIGTERM, signal.SIGHUP):
            self.root = f"{root}/{number.name}"  # where nothing of the node before is left in a connection
            self.start()
            maps = self.listen("ExperienceMap/Map", TopologicalMap)
            self.drive_by_actions()
            self.check_square(maps)
            self.node.process.send_signal(number)
            self.assertEqual(self.node.ended(), 0, self.node.output())
            for ending in ("_online.tum", "_final.tum", "_map.yaml"):
                self.assertGreater(os.path.getsize(self.trajectory + ending), 100)
                os.remove(self.trajectory + ending)
            self.assertEqual([name for name in os.listdir(self.folder) if name.endswith(".part")], [])

    def test_trajectories_that_cannot_be_written_are_said_at_the_start(self):
        os.makedirs(os.path.join(self.folder, self.name + "_final.tum"))
        self.start()
        self.assertEqual(self.node.ended(), 1, self.node.output())
        self.assertEqual(self.node.count("_final.tum: cannot write this file"), 1, self.node.output())

    def test_without_a_map_frame_messages_name_none_and_no_transform_is_broadcast(self):
        """The scripts that came with OpenRatSLAM (show_em.py) expect an empty frame."""
        self.start(map_frame="")
        maps = self.listen("ExperienceMap/Map", TopologicalMap)
        poses = self.listen("ExperienceMap/RobotPose", PoseStamped)
        transforms = self.listen("/tf", tf2_msgs.msg.TFMessage)
        self.drive_by_actions()
        self.check_square(maps, frame="")
        self.assertTrue(harness.wait_until(lambda: poses))
        self.assertEqual({message.header.frame_id for message in maps + poses}, {""})
        self.assertEqual([t for message in transforms for t in message.transforms], [])
        self.assertEqual(self.node.count("map_frame is empty"), 1, self.node.output())

    def test_the_odometry_has_another_frame_than_the_map_or_no_transform_is_broadcast(self):
        self.start(map_frame="odom")
        transforms = self.listen("/tf", tf2_msgs.msg.TFMessage)
        poses = self.listen("ExperienceMap/RobotPose", PoseStamped)
        self.drive_by_actions()
        self.assertTrue(harness.wait_until(lambda: poses))
        self.assertEqual([t for message in transforms for t in message.transforms], [])
        self.assertEqual(self.node.count("map_frame: 'odom' is also the frame of the odometry"), 1, self.node.output())

    def test_states_rule_out_actions_and_everything_is_published(self):
        states = rospy.Publisher(self.root + "/PoseCell/State", PoseCellState, queue_size=1000)
        self.start()
        maps = self.listen("ExperienceMap/Map", TopologicalMap)
        poses = self.listen("ExperienceMap/RobotPose", PoseStamped)
        paths = self.listen("ExperienceMap/PathToGoal", Path)
        transforms = self.listen("/tf", tf2_msgs.msg.TFMessage)
        odometry = self.publisher("odom", Odometry)
        actions = self.publisher("PoseCell/TopologicalAction", TopologicalAction)
        self.assertTrue(harness.wait_for_links(lambda: states.get_num_connections() > 0))

        def decide(at, step):
            actions.publish(self.fill(TopologicalAction(), at, step))
            states.publish(self.fill(PoseCellState(), at, step))

        self.drive(odometry, decide)
        self.check_square(maps)
        self.assertTrue(harness.wait_until(lambda: len(poses) == len(STEPS)), self.node.output())
        ends = [harness.stamp(harness.START_NS + (10 * corner + 9) * 100000000) for corner in range(len(STEPS))]
        self.assertEqual([pose.header.stamp for pose in poses], ends)
        self.assertEqual(self.node.count("dropped"), 0, self.node.output())

        # Latched: who comes late gets the map all the same.
        markers = self.listen("ExperienceMap/MapMarker", Marker)
        self.assertTrue(harness.wait_until(lambda: markers))
        self.assertEqual(len(markers[-1].points), 8)

        ours = [t for message in transforms for t in message.transforms if t.child_frame_id == "odom"]
        self.assertTrue(ours)
        self.assertEqual({t.header.frame_id for t in ours}, {"map"})

        goals = self.publisher("ExperienceMap/SetGoalPose", PoseStamped)
        goal = PoseStamped()
        goal.header.frame_id = "map"
        goal.pose.position = maps[-1].node[2].pose.position
        goals.publish(goal)
        self.assertTrue(harness.wait_until(lambda: paths and len(paths[-1].poses) > 1), self.node.output())
        self.assertAlmostEqual(paths[-1].poses[-1].pose.position.x, goal.pose.position.x, places=6)
        # While no decision moves the robot, odometry alone does not publish the path again.
        ways = len(paths)
        for tick in range(1, 6):
            odometry.publish(harness.odometry_message(harness.START_NS + (10 * len(STEPS) + tick) * 100000000))
        self.assertFalse(harness.wait_until(lambda: len(paths) > ways, 1.0))
        goal.pose.position.x = 1e6
        goals.publish(goal)
        self.assertTrue(self.node.said("goal failed: "), self.node.output())

        # By service at any time, and again at the end; TUM lines of eight numbers.
        answer = rospy.ServiceProxy(self.root + "/ExperienceMap/WriteTrajectories", Trigger)()
        self.assertTrue(answer.success, answer.message)
        with open(self.trajectory + "_online.tum", encoding="utf-8") as file:
            by_service = file.read()
        self.assertTrue(all(len(line.split()) == 8 for line in by_service.splitlines()))
        self.assertEqual(len(by_service.splitlines()[-1].split()[0].split(".")[1]), 9)
        os.remove(self.trajectory + "_online.tum")
        self.assertEqual(self.node.interrupt(), 0)
        with open(self.trajectory + "_online.tum", encoding="utf-8") as file:
            self.assertEqual(file.read(), by_service)

    def test_transform_holds_between_decisions_while_the_unit_of_length_drifts(self):
        """Three laps of a ring, a decision every fifth sample; the odometry's metre shrinks by 10 %."""
        places, samples, laps, step = 60, 5, 3, 0.4
        self.start(decision_source="action", exp_scale=True)
        transforms = self.listen("/tf", tf2_msgs.msg.TFMessage)
        poses = self.listen("ExperienceMap/RobotPose", PoseStamped)
        odometry = self.publisher("odom", Odometry)
        actions = self.publisher("PoseCell/TopologicalAction", TopologicalAction)
        turn = 2 * math.pi / (places * samples)
        in_odom, true = {}, {}
        x = y = true_x = true_y = yaw = 0.0
        current = 0
        for k in range(1, places * samples * laps + 1):
            unit = math.exp(-0.1 * k / (places * samples * laps))
            yaw += turn
            true_x, true_y = true_x + step * math.cos(yaw), true_y + step * math.sin(yaw)
            x, y = x + unit * step * math.cos(yaw), y + unit * step * math.sin(yaw)
            at = harness.START_NS + k * 100000000
            message = harness.odometry_message(at, 10 * unit * step, 10 * turn)
            message.pose.pose.position.x, message.pose.pose.position.y = x, y
            message.pose.pose.orientation.z, message.pose.pose.orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
            odometry.publish(message)
            in_odom[at], true[at] = complex(x, y), complex(true_x, true_y)
            if k % samples == 0:
                place = k // samples - 1
                kind = CREATE if place < places else LINK
                actions.publish(self.fill(TopologicalAction(), at, (kind, current, place % places)))
                current = place % places
                # So that the decision has been made before the next odometry comes.
                self.assertTrue(harness.wait_until(lambda: len(poses) == k // samples, step=0.002), self.node.output())
        end = at
        self.assertTrue(harness.wait_until(lambda: any(
            t.header.stamp.to_nsec() >= end - 200000000 for m in transforms for t in m.transforms)))
        in_map = {}
        for message in transforms:
            for t in message.transforms:
                at = t.header.stamp.to_nsec()
                rotation, moved = t.transform.rotation, t.transform.translation
                turned = complex(rotation.w, rotation.z) ** 2
                in_map[at] = complex(moved.x, moved.y) + turned * in_odom[at]
        # The metre of the map is that of the first lap, on the mean; between decisions the odometry's is carried to it.
        ratios = []
        for decision in range(places * samples, places * samples * laps, samples):
            begin, last = (harness.START_NS + (decision + k) * 100000000 for k in (1, samples - 2))
            if begin in in_map and last in in_map:
                ratios.append(abs(in_map[last] - in_map[begin]) / abs(true[last] - true[begin]))
        self.assertGreater(len(ratios), 20)
        middle = sorted(ratios)[len(ratios) // 2]
        self.assertLess(max(abs(ratio / middle - 1) for ratio in ratios), 0.01)

    def test_impossible_actions_are_reported_and_leave_the_map_unharmed(self):
        self.start(decision_source="action", trajectory_format="kitti")
        maps = self.listen("ExperienceMap/Map", TopologicalMap)
        odometry = self.publisher("odom", Odometry)
        actions = self.publisher("PoseCell/TopologicalAction", TopologicalAction)

        def decide(at, step):
            actions.publish(self.fill(TopologicalAction(), at, step))
            actions.publish(self.fill(TopologicalAction(), at, (LINK, step[2], 77)))
            actions.publish(self.fill(TopologicalAction(), at, (9, 0, 0)))

        self.drive(odometry, decide)
        self.check_square(maps)
        # Of warnings in quick succession only one is printed: either says which value is wrong.
        self.assertTrue(self.node.said("decision of the pose cells dropped: (.*77|action 9)"), self.node.output())
        self.assertEqual(self.node.interrupt(), 0)
        with open(self.trajectory + "_final.txt", encoding="utf-8") as file:
            self.assertTrue(all(len(line.split()) == 12 for line in file))


if __name__ == "__main__":
    rostest.rosrun("ratslam_ros", "map", Map, sys.argv)
