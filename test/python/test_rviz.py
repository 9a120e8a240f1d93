"""The rviz configuration shows topics that the nodes publish."""

import copy
import glob
import importlib.machinery
import importlib.util
import os
import re

import pytest

from conftest import SOURCE

yaml = pytest.importorskip("yaml")
PRIVATE = re.compile(r"^ratslam_[a-z_]+/")  # topics of one node's own


@pytest.fixture(name="config")
def rviz_config():
    with open(os.path.join(SOURCE, "config", "rviz", "ratslam.rviz"), encoding="utf-8") as file:
        return yaml.safe_load(file)


@pytest.fixture(name="open_rviz")
def open_rviz_script():
    loader = importlib.machinery.SourceFileLoader("open_rviz", os.path.join(SOURCE, "scripts", "open_rviz"))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("open_rviz", loader))
    loader.exec_module(module)
    return module


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
    assert len(images) == 3


def all_topics(config):
    manager = config["Visualization Manager"]
    keys = ("Topic", "Image Topic", "Marker Topic")
    return [entry[key] for entry in manager["Displays"] + manager["Tools"] for key in keys if key in entry]


def test_no_topic_is_absolute_so_that_two_robots_have_two_pictures(config):
    assert not [topic for topic in all_topics(config) if topic.startswith("/")]


def test_everything_is_drawn_at_the_size_of_the_map(config, open_rviz):
    small = open_rviz.adapted(copy.deepcopy(config), 0.02, "irat_red", "rat/map", "rat/base_link")

    def arrow(which):
        shown = {entry["Class"]: entry for entry in which["Visualization Manager"]["Displays"]}["rviz/Pose"]
        return shown["Shaft Length"] + shown["Head Length"]

    assert arrow(config) == 9
    assert arrow(small) == pytest.approx(0.18)
    manager = small["Visualization Manager"]
    assert manager["Global Options"]["Fixed Frame"] == "rat/map"
    assert manager["Views"]["Current"]["Target Frame"] == "rat/base_link"
    assert "irat_red/ExperienceMap/MapMarker" in all_topics(small)
    assert "ratslam_orb_vo/landmarks" in all_topics(small)


@pytest.mark.parametrize("content", ["", "fx: 50\n", "[1, 2", "Visualization Manager: {Displays: []}\n", "a\0b"])
def test_what_is_no_configuration_of_rviz_is_refused_in_one_line(content, tmp_path, fails):
    (tmp_path / "my.rviz").write_text(content)
    assert "my.rviz: " in fails("open_rviz", tmp_path / "my.rviz")
    assert "no.rviz: cannot be read" in fails("open_rviz", tmp_path / "no.rviz")
    os.mkfifo(tmp_path / "pipe.rviz")
    assert "no regular file" in fails("open_rviz", tmp_path / "pipe.rviz")


def test_without_rviz_its_package_is_named(fails, monkeypatch):
    monkeypatch.setenv("PATH", "/nowhere")
    assert "apt install rviz" in fails("open_rviz", os.path.join(SOURCE, "config", "rviz", "ratslam.rviz"))


@pytest.mark.parametrize("words", [("--topic-root", ""), ("--topic-root=",)])
def test_topics_may_have_no_root(words, tmp_path, run, monkeypatch):
    """ratslam.launch always passes its argument root, which is empty by default."""
    (tmp_path / "rviz").write_text('#!/bin/sh\ncat "$2"\n')
    (tmp_path / "rviz").chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    shown = run("open_rviz", os.path.join(SOURCE, "config", "rviz", "ratslam.rviz"), "--scale", "1", *words)
    assert shown.returncode == 0, shown.stderr
    assert "ExperienceMap/MapMarker" in all_topics(yaml.safe_load(shown.stdout))
