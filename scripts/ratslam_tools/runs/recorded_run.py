"""A run of the nodes from a bag with their recorded topics: ours, or OpenRatSLAM's of the same names."""

import os
from typing import Dict, List, Optional, Set

import numpy as np

from ratslam_tools.datasets import bags
from ratslam_tools.errors import InputError
from ratslam_tools.runs.run_folder import EXPERIENCE_KEYS, Map, Run
from ratslam_tools.trajectory import Trajectory, geometry

MAP, POSE, VIEW, STATE, ACTION = (
    "ExperienceMap/Map",
    "ExperienceMap/RobotPose",
    "LocalView/Template",
    "PoseCell/State",
    "PoseCell/TopologicalAction",
)
CREATE_NODE = 1


class RecordedRun(Run):
    """A run in a bag: the last map, the online path, view cells and decisions over time.

    If the decisions were recorded, `final` is the path over the experiences at their times of creation; else the
    online path.
    """

    def __init__(self, path: str):  # pylint: disable=super-init-not-called
        self.folder = os.path.dirname(os.path.abspath(path))
        self.name = os.path.basename(path)
        self.summary, self.activity, self.odometry, self.pose_cells = {}, None, None, None
        messages = _read(path)
        if not messages.get(MAP):
            raise InputError(f"{path}: no topic that ends with {MAP}: record it with rosbag record")
        self.map: Optional[Map] = _map_of(messages[MAP][-1], path)
        self.online = _path_of(messages.get(POSE, []), "online")
        self.templates = _columns(messages.get(VIEW, []), template_id="current_id", relative_rad="relative_rad")
        if self.templates is not None:
            self.templates["error"] = np.full(len(self.templates["stamp"]), -1.0)
        decisions = messages.get(STATE) or messages.get(ACTION, [])
        self.actions = _columns(decisions, action="action", src_id="src_id", dest_id="dest_id", x="x", y="y", th="th")
        self.final = self._path_over_experiences()
        if self.final is None and self.online is not None:
            self.final = Trajectory(self.online.positions, self.online.rotations, self.online.stamps, "final")
        if self.final is None:
            raise InputError(f"{path}: neither {POSE} nor the pose cells' decisions: there is no path to show")

    def _path_over_experiences(self) -> Optional[Trajectory]:
        if self.actions is None:
            return None
        created = self.actions["action"] == CREATE_NODE
        stamps = dict(zip(self.actions["dest_id"][created].astype(int), self.actions["stamp"][created]))
        rows = [row for row, node in enumerate(self.map.nodes["id"]) if int(node) in stamps]
        if len(rows) < 2:
            return None
        nodes = {key: self.map.nodes[key][rows] for key in EXPERIENCE_KEYS}
        rotations = np.array([geometry.rotation_about_z(yaw) for yaw in nodes["yaw"]])
        times = [stamps[int(node)] for node in nodes["id"]]
        order = np.argsort(times, kind="stable")
        positions = np.column_stack([nodes[key] for key in ("x", "y", "z")])
        return Trajectory(positions[order], rotations[order], np.array(times)[order], "final")


def _read(path: str) -> Dict[str, list]:
    """Messages by the ends of their topics' names; of the map only the last."""
    found: Dict[str, list] = {}
    with bags.reading(path) as bag:
        topics = {
            name: ending
            for name in bag.get_type_and_topic_info().topics
            for ending in (MAP, POSE, VIEW, STATE, ACTION)
            if name == ending or name.endswith("/" + ending)
        }
        for ending in set(topics.values()):
            names = [name for name, which in topics.items() if which == ending]
            if len(names) > 1:
                raise InputError(f"{path}: several runs: {', '.join(sorted(names))}; take one by rosbag filter")
        for topic, message, _ in bag.read_messages(topics=list(topics)) if topics else ():  # no topics means all
            messages = found.setdefault(topics[topic], [])
            if topics[topic] == MAP:
                messages.clear()
            messages.append(message)
    return found


def _map_of(message, path: str) -> Map:
    poses = [node.pose for node in message.node]
    if not poses:
        raise InputError(f"{path}: the last {MAP} is empty")
    nodes = {key: np.zeros(len(poses)) for key in EXPERIENCE_KEYS}
    nodes["id"] = np.array([node.id for node in message.node], dtype=float)
    nodes["x"], nodes["y"], nodes["z"] = np.array([[p.position.x, p.position.y, p.position.z] for p in poses]).T
    nodes["yaw"] = np.array([2.0 * np.arctan2(p.orientation.z, p.orientation.w) for p in poses])
    ends = np.array([[edge.source_id, edge.destination_id] for edge in message.edge], dtype=float).reshape(-1, 2)
    links = {"id": np.arange(len(ends), dtype=float), "from": ends[:, 0], "to": ends[:, 1]}
    order = np.argsort([edge.id for edge in message.edge], kind="stable")
    links["recall"] = np.array(_by_recall(ends.astype(int), order), dtype=bool)
    return Map(nodes, links, path)


def _by_recall(ends: np.ndarray, order: np.ndarray) -> List[bool]:
    """Whether each link (from, to) was made by a recall. A link that was driven came with its new experience: no link before it
    names that one. A recall may lead to an older or, on a way driven before, to a newer experience. @param order of the links'
    making"""
    named: Set[int] = set()
    by_recall = [True] * len(ends)
    for row in order:
        start, end = map(int, ends[row])
        by_recall[row] = end < start or end in named
        named.update((start, end))
    return by_recall


def _path_of(messages: list, name: str) -> Optional[Trajectory]:
    if len(messages) < 2:
        return None
    poses = [message.pose for message in messages]
    positions = np.array([[p.position.x, p.position.y, p.position.z] for p in poses])
    turns = np.array([[p.orientation.x, p.orientation.y, p.orientation.z, p.orientation.w] for p in poses])
    stamps = np.array([message.header.stamp.to_sec() for message in messages])
    later = np.concatenate([[True], np.diff(stamps) > 0])
    return Trajectory(positions[later], geometry.matrices_from_quaternions(turns)[later], stamps[later], name)


def _columns(messages: list, **fields: str) -> Optional[Dict[str, np.ndarray]]:
    """Arrays of the messages' stamps and fields; a field that they do not have counts as 0."""
    if not messages:
        return None
    columns = {"stamp": np.array([message.header.stamp.to_sec() for message in messages])}
    for name, field in fields.items():
        columns[name] = np.array([float(getattr(message, field, 0.0)) for message in messages])
    return columns


def open_run(path: str) -> Run:
    """A folder that ratslam_run left, FILE of the nodes' trajectory_file, or a bag of the nodes' topics."""
    return RecordedRun(path) if bags.is_bag(path) else Run(path)
