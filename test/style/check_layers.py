#!/usr/bin/python3
"""The storeys of the house: the core knows no ROS, and of its models only the map knows another: odometry.

Usage: check_layers.py SOURCE_TREE. Lists each include that breaks a rule and exits with 1 if there is any.
"""
import pathlib
import re
import sys

INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]')
ROS_PACKAGES = (
    "ros", "rosbag", "roscpp", "std_msgs", "std_srvs", "nav_msgs", "sensor_msgs", "geometry_msgs", "diagnostic_msgs",
    "visualization_msgs", "ratslam_ros", "tf2", "tf2_ros", "tf2_eigen", "tf2_geometry_msgs", "cv_bridge",
    "image_transport", "diagnostic_updater", "message_filters", "pluginlib", "nodelet",
)
# Headers that describe the nodes' parameters and need nothing of ROS.
WITHOUT_ROS = {"ratslam_ros/support/node_params.h", "ratslam_ros/support/system_keys.h"}
# What each part of the core may use of the rest of it; system is where they all meet, view shows all of it.
COMMON = {"common", "simd", "events.h", "version.h"}
ALLOWED = {
    "common": {"common"},
    "simd": {"common"},
    "camera": COMMON,
    "vision": COMMON | {"camera"},
    "odometry": COMMON | {"camera", "vision"},
    "local_view": COMMON | {"camera", "vision"},
    "pose_cells": COMMON,
    "experience_map": COMMON | {"odometry"},
    "dataset": COMMON | {"odometry", "camera"},
}


def includes(path):
    """Yields (line number, included path) of a source file."""
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        match = INCLUDE.match(line)
        if match:
            yield number, match.group(1)


def complaints(tree):
    """Yields a line of text for each include that breaks a rule."""
    for folder in ("include/ratslam", "src/ratslam"):
        root = tree / folder
        for path in sorted(list(root.rglob("*.h")) + list(root.rglob("*.cpp"))):
            module = path.relative_to(root).parts[0]
            for number, included in includes(path):
                first = included.split("/")[0]
                where = f"{path.relative_to(tree)}:{number}: includes {included}"
                if first in ROS_PACKAGES and "/" in included:
                    yield where + ", but the core knows no ROS"
                elif first == "ratslam" and module in ALLOWED:
                    used = included.split("/")[1]
                    if used not in ALLOWED[module] | {module}:
                        yield where + f", but {module} may only use {', '.join(sorted(ALLOWED[module]))}"
    for folder in ("include/town", "src/town"):
        for path in sorted(list((tree / folder).glob("*.h")) + list((tree / folder).glob("*.cpp"))):
            for number, included in includes(path):
                if included.split("/")[0] in ROS_PACKAGES and "/" in included:
                    yield f"{path.relative_to(tree)}:{number}: includes {included}, but the town knows no ROS"
    for path in sorted(list((tree / "src/tools").glob("*.h")) + list((tree / "src/tools").glob("*.cpp"))):
        for number, included in includes(path):
            if included.split("/")[0] in ROS_PACKAGES and "/" in included and included not in WITHOUT_ROS:
                yield (f"{path.relative_to(tree)}:{number}: includes {included}, but the tools build without ROS; "
                       "what needs it lies in src/tools/with_ros")
    nodes = tree / "src" / "nodes"
    for path in sorted(nodes.glob("*.cpp")):
        lines = len(path.read_text(encoding="utf-8").splitlines())
        if lines > 20:
            yield f"{path.relative_to(tree)}: {lines} lines; a main has at most 20"


def main():
    found = list(complaints(pathlib.Path(sys.argv[1])))
    print("\n".join(found) if found else "the layers hold")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
