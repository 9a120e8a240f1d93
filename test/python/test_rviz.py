"""The rviz configuration shows topics that the nodes publish."""

import glob
import os
import re

import pytest

from conftest import SOURCE

yaml = pytest.importorskip("yaml")
PRIVATE = re.compile(r"^/ratslam_[a-z_]+/")  # topics of one node's own


@pytest.fixture(name="config")
def rviz_config():
    with open(os.path.join(SOURCE, "config", "rviz", "ratslam.rviz"), encoding="utf-8") as file:
        return yaml.safe_load(file)


def names_in_nodes():
    """Every string literal of the ROS storey: topic names are among them."""
    names = set()
    for path in glob.glob(os.path.join(SOURCE, "src", "ratslam_ros", "**", "*.cpp"), recursive=True):
        with open(path, encoding="utf-8") as file:
            names.update(re.findall(r'"([A-Za-z_/]+)"', file.read()))
    return names


def test_every_topic_is_one_of_the_nodes(config):
    manager = config["Visualization Manager"]
    entries = manager["Displays"] + manager["Tools"]
    keys = ("Topic", "Image Topic", "Marker Topic")
    topics = [entry[key] for entry in entries for key in keys if key in entry]
    assert len(topics) >= 7
    missing = [topic for topic in topics if PRIVATE.sub("", topic) not in names_in_nodes()]
    assert not missing


def test_relative_names_follow_the_namespace_of_the_launch_file(config):
    displays = config["Visualization Manager"]["Displays"]
    shown = {display["Class"] for display in displays}
    assert {"rviz/TF", "rviz/Marker", "rviz/Pose", "rviz/Path", "rviz/Image"} <= shown
    images = [display["Image Topic"] for display in displays if display["Class"] == "rviz/Image"]
    assert len(images) == 3 and not any(topic.startswith("/") for topic in images)
