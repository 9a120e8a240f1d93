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
