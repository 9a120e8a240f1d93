"""The copy of the package that `scripts/endurance workspaces` makes within the tree is not taken for a part of it."""

import os
import re
import shutil
import subprocess

import pytest

from conftest import SCRIPTS

PACKAGE = """<package format="2"><name>lonely</name><version>0.0.1</version><description>d</description>
<maintainer email="alice@example.com">Alice</maintainer><license>BSD</license></package>"""


def test_roslaunch_finds_a_launch_file_once_while_a_workspace_is_in_the_tree(tmp_path):
    """roslaunch looks for a file by its name in all of a package's folders but those whose name begins with a dot."""
    if shutil.which("roslaunch") is None:
        pytest.skip("roslaunch is absent")
    with open(os.path.join(SCRIPTS, "endurance"), encoding="utf-8") as file:
        (workspace,) = re.findall(r'workspaces\.sh" "\$sources" "\$results/(\S+)"', file.read())
    package = tmp_path / "lonely"
    for folder in (package, package / "out" / "endurance" / workspace / "src" / "lonely"):
        (folder / "launch").mkdir(parents=True)
        (folder / "package.xml").write_text(PACKAGE)
        (folder / "launch" / "only.launch").write_text("<launch/>\n")
    environment = dict(os.environ, ROS_PACKAGE_PATH=str(tmp_path), ROS_HOME=str(tmp_path / "home"), CMAKE_PREFIX_PATH="")
    found = subprocess.run(
        ["roslaunch", "--files", "lonely", "only.launch"],
        env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True, check=False,
    )
    assert found.stdout.splitlines() == [str(package / "launch" / "only.launch")], found.stdout + found.stderr


TOOLS = {  # what a built package would put on PATH; $FAILING is the one that fails
    "rospack": 'echo "$WORKSPACE/src/ratslam_ros"',
    "rosrun": 'case "$*" in *--out\\ run*) mkdir run; echo 1 >run/trajectory_final.tum ;; esac',
    "roslaunch": "echo 1 >nodes_final.tum",
    "cmp": "",
    "trajectory_convert": "",
    "evaluate_ape": "",
}


@pytest.mark.parametrize("failing", ["nothing", "catkin_make", *TOOLS])
def test_every_command_that_fails_in_a_workspace_counts(tmp_path, failing):
    if os.path.exists("/opt/ros/noetic/setup.bash"):
        pytest.skip("its own catkin_make would come before the one that stands in for it")
    package, programs, workspace = tmp_path / "package", tmp_path / "programs", tmp_path / "workspace"
    (package / "file").mkdir(parents=True)
    (package / "file" / "of_it.txt").write_text("text\n")
    subprocess.run(["git", "init", "-q", str(package)], check=True)
    programs.mkdir()
    setup = f"export PATH={programs}:$PATH PYTHONPATH={programs}\n"
    (programs / "ratslam").mkdir()
    (programs / "ratslam" / "__init__.py").write_text(
        "class PoseCellNetwork:\n    def __init__(self, **_):\n        import numpy\n        self.activity = numpy.zeros(3)\n")
    (programs / "ratslam" / "tools.py").write_text("")
    make = {"catkin_make": f"mkdir devel; echo '{setup}' >devel/setup.bash"}
    for name, content in {**make, **TOOLS}.items():
        ending = "exit 1" if name == failing else "exit 0"
        (programs / name).write_text(f"#!/bin/bash\n{content}\n{ending}\n")
        (programs / name).chmod(0o755)
    done = subprocess.run(
        [os.path.join(os.path.dirname(SCRIPTS), "test", "endurance", "workspaces.sh"), str(package), str(workspace), "catkin_make"],
        env=dict(os.environ, PATH=f"{programs}:{os.environ['PATH']}", WORKSPACE=str(workspace)),
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True, check=False,
    )
    assert done.returncode == (0 if failing == "nothing" else 1), done.stdout
    assert ("catkin_make: FAILED" in done.stdout) == (failing != "nothing")
