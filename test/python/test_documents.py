"""What README and docs tell the reader to type exists: programs, their options, launch files and their arguments, files."""

import glob
import os
import re
import shlex
import subprocess
import xml.etree.ElementTree as ElementTree

import pytest

from conftest import SCRIPTS, SOURCE

DOCUMENTS = [os.path.join(SOURCE, "README.md")] + sorted(glob.glob(os.path.join(SOURCE, "docs", "*.md")))

def commands():
    """(document, line number, words) of every command: indented lines that begin with a program of ours or of ROS."""
    found = []
    for path in DOCUMENTS:
        with open(path, encoding="utf-8") as file:
            lines = file.read().splitlines()
        for number, line in enumerate(lines, 1):
            if not re.match(r"^ {4,}\S", line) or "..." in line:
                continue
            text = line.strip()
            while text.endswith("\\") and number < len(lines):
                text = text[:-1] + lines[number].strip()
                number += 1
            for part in re.split(r"&&|;|\|", text.split(" # ")[0]):
                try:
                    words = shlex.split(part)
                except ValueError:
                    continue
                if words:
                    found.append((os.path.relpath(path, SOURCE), number, words))
    return found


def script_of(words):
    """Words from the name of one of our scripts on; None for other commands."""
    if words[0] == "rosrun" and len(words) > 2 and words[1] == "ratslam_ros":
        words = words[2:]
    name = words[0][len("scripts/") :] if words[0].startswith("scripts/") else words[0]
    return [name, *words[1:]] if words[0].startswith("scripts/") or is_script(name) else None


def is_script(name):
    return "/" not in name and name not in ("test", "build", "setup", "report") and os.path.isfile(os.path.join(SCRIPTS, name))


COMMANDS = commands()
OURS = [(where, number, script_of(words)) for where, number, words in COMMANDS if script_of(words)]
LAUNCHES = [entry for entry in COMMANDS if entry[2][0] == "roslaunch"]


def test_there_are_commands():
    assert len(OURS) > 10 and len(LAUNCHES) > 3


_HELP = {}


def help_of(name):
    """The help of a script, or the text of a shell script."""
    if name not in _HELP:
        path = os.path.join(SCRIPTS, name)
        with open(path, encoding="utf-8") as file:
            text = file.read()
        if text.startswith("#!/usr/bin/python3"):
            done = subprocess.run(
                ["/usr/bin/python3", path, "--help"],
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                universal_newlines=True,
                check=False,
            )
            assert done.returncode == 0, done.stdout
            text = done.stdout
        _HELP[name] = text
    return _HELP[name]


@pytest.mark.parametrize("where, number, words", OURS, ids=[f"{w}:{n}" for w, n, _ in OURS])
def test_scripts_and_their_options(where, number, words):
    assert os.path.isfile(os.path.join(SCRIPTS, words[0])), f"{where}:{number}: no scripts/{words[0]}"
    if words[0] in ("test", "build"):  # what follows goes to ctest and cmake
        return
    options = [word.split("=")[0] for word in words[1:] if re.match(r"^--?[A-Za-z]", word)]
    for option in options:
        shown = option if option.startswith("--") else option[:2]
        assert re.search(re.escape(shown) + r"\b", help_of(words[0])), f"{where}:{number}: {words[0]} has no {option}"


def arguments_of(launch_file):
    root = ElementTree.parse(os.path.join(SOURCE, "launch", launch_file)).getroot()
    return {arg.get("name") for arg in root.findall("arg") if arg.get("value") is None}


@pytest.mark.parametrize("where, number, words", LAUNCHES, ids=[f"{w}:{n}" for w, n, _ in LAUNCHES])
def test_launch_files_and_their_arguments(where, number, words):
    names = [word for word in words[1:] if word.endswith(".launch")]
    if "ratslam_ros" not in words or not names:
        pytest.skip("another package's")
    given = {word.split(":=")[0] for word in words if ":=" in word}
    missing = given - arguments_of(names[0])
    assert not missing, f"{where}:{number}: {names[0]} has no {missing}"


@pytest.mark.parametrize("path", sorted(glob.glob(os.path.join(SOURCE, "launch", "*.launch"))), ids=os.path.basename)
def test_every_argument_says_what_it_is(path):
    root = ElementTree.parse(path).getroot()
    assert all(arg.get("doc") for arg in root.findall("arg")), path


@pytest.mark.parametrize("path", DOCUMENTS, ids=os.path.basename)
def test_links_lead_somewhere(path):
    with open(path, encoding="utf-8") as file:
        text = file.read()
    for target in re.findall(r"\]\(([^)]+)\)", text):
        if re.match(r"^[a-z]+:", target):
            continue
        name, _, anchor = target.replace("\n", "").partition("#")
        found = os.path.join(os.path.dirname(path), name) if name else path
        assert os.path.exists(found), f"{os.path.basename(path)}: {target}"
        if anchor and found.endswith(".md"):
            with open(found, encoding="utf-8") as file:
                heads = re.findall(r"^#+ (.*)$", file.read(), re.MULTILINE)
            anchors = {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}
            assert anchor in anchors, f"{os.path.basename(path)}: {target}"


def test_every_topic_of_the_nodes_is_described():
    with open(os.path.join(SOURCE, "docs", "nodes.md"), encoding="utf-8") as file:
        described = file.read()
    names = set()
    for path in glob.glob(os.path.join(SOURCE, "src", "ratslam_ros", "**", "*.cpp"), recursive=True):
        with open(path, encoding="utf-8") as file:
            names.update(re.findall(r'"((?:LocalView|PoseCell|ExperienceMap)/\w+)"', file.read()))
    assert len(names) > 10
    missing = {name for name in names if name not in described and name.split("/")[1] not in described}
    assert not missing


def test_configurations_that_are_named_exist():
    for where, number, words in COMMANDS:
        for word in words:
            if re.match(r"^config/[\w/]+\.(yaml|txt)$", word):
                assert os.path.isfile(os.path.join(SOURCE, word)), f"{where}:{number}: {word}"


def test_every_test_that_is_named_exists():
    """In docs/testing.md: Suite.Name of the unit tests, and functions of the Python file named before them."""
    suites = set()
    for path in glob.glob(os.path.join(SOURCE, "test", "unit", "*", "*.cpp")):
        with open(path, encoding="utf-8") as file:
            suites |= set(re.findall(r"TEST(?:_F|_P)?\((\w+),\s*(\w+)\)", file.read()))
    with open(os.path.join(SOURCE, "docs", "testing.md"), encoding="utf-8") as file:
        lines = file.read().splitlines()
    missing, named = [], 0
    for line in lines:
        text = ""
        for code in re.findall(r"`([^`]+)`", line):
            if code.endswith(".py"):
                path = glob.glob(os.path.join(SOURCE, "test", "*", code))
                with open(path[0], encoding="utf-8") as file:
                    text = file.read()
            elif re.fullmatch(r"test_\w+", code):
                named += 1
                missing += [] if f"def {code}(" in text else [code]
            elif re.fullmatch(r"[A-Z]\w+\.[A-Z]\w+", code):
                named += 1
                missing += [] if tuple(code.split(".")) in suites else [code]
    assert named > 50 and not missing
