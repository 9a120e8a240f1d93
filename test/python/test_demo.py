"""The demos touch nothing that is not theirs."""

import os
import subprocess

from conftest import SCRIPTS


def test_demo_recorder_leaves_a_folder_of_somebody_else_alone(tmp_path):
    precious = tmp_path / "mine" / "thesis.txt"
    precious.parent.mkdir()
    precious.write_text("all of it")
    result = subprocess.run(
        [os.path.join(SCRIPTS, "demo_recorder"), "--out", "mine"],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        universal_newlines=True,
        check=False,
    )
    assert result.returncode == 2 and "not of this script's making" in result.stderr
    assert precious.read_text() == "all of it"


def test_site_makes_no_folder_of_an_option(tmp_path):
    result = subprocess.run(
        [os.path.join(SCRIPTS, "site"), "--help"],
        cwd=str(tmp_path),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        universal_newlines=True,
        check=False,
    )
    assert result.returncode == 2 and "Usage: scripts/site" in result.stderr
    assert not os.listdir(str(tmp_path))
