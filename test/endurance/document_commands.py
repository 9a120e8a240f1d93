#!/usr/bin/python3
"""Executes the commands of README, CONTRIBUTING and docs as they stand there, on a tree that is built.

Usage: document_commands.py SOURCE_TREE [--short] [--only DOCUMENT] [--list]

Commands are the indented and the fenced `sh` lines whose first word is a program of ours or of ROS, and indented Python that
begins with an import. They run in a scratch folder that looks like the source tree, beside small synthetic recordings under
the names that documents use for a user's own: what is literal is the command, not the data. A comment before a block says
why it cannot run anywhere, or what it needs:

    <!-- not run: a robot -->        skipped, with that reason
    <!-- long -->                    skipped by --short: installs, builds or takes minutes
    <!-- beside: COMMAND -->         that runs meanwhile, such as the nodes of which a service is called

    <!-- commands -->                before a table: what stands in its cells as code is a command

Three things are changed, and said: there is no display (rviz:=true becomes false), what runs until it is stopped is
stopped once it runs, and what takes hours is given less to do (--whole leaves that out). A Slurm array is run task by task by
a stand-in where there is no sbatch. Exits with 1 where a command fails.
"""
import argparse
import contextlib
import os
import pathlib
import re
import shlex
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

OURS = re.compile(
    r"scripts/|build/|test/|[A-Z_]+=\S+ build/|ratslam_\w+ |\. |source |"
    r"(rosrun|roslaunch|rostopic|rosservice|roscp|python3|cmake|parallel|sbatch|sqlite3) "
)
PYTHON = re.compile(r"import \w+|from \w+ import ")
# They work on the source tree itself.
BUILDS = re.compile(r"scripts/(setup|build|test|demo|benchmark|endurance)\b|test/endurance|cmake ")
MARK = re.compile(r"<!-- (not run: (?P<why>.*?)|(?P<long>long)|beside: (?P<beside>.*?)|(?P<table>commands)) -->")
COMMENT = re.compile(r"\s{2,}#.*$")
TIMEOUT_S = 7200
SETTLED_S = 20  # that a live launch must last
RENDER = "ratslam_town --frames 60 --jpeg-quality 90"
TOWN = RENDER + " --wheel-noise 0.01,0.02,0.002"
LONGER = TOWN.replace("60", "120", 1)  # as far as a picture of its scale needs
FATAL = re.compile(r"\[FATAL\]|has died|Traceback|REQUIRED process")


# What takes hours, and what is run instead of it.
SHORTER = {
    "scripts/endurance fuzz": "scripts/endurance fuzz 300",
    "scripts/endurance fuzz-python": "scripts/endurance fuzz-python --inputs 100",
    "scripts/endurance soak": "scripts/endurance soak 20000",
    "scripts/endurance soak 500000 patrol": "scripts/endurance soak 20000 patrol",
    "scripts/endurance faults": "scripts/endurance faults --moments 1 --faults restart no_images --stop-seconds 5",
    "scripts/endurance restarts": "scripts/endurance restarts --moments 400 --nodes ratslam_em",
    "scripts/endurance laps": "scripts/endurance laps --laps 2",
}
# As much of sbatch as an array takes: each task in turn, with the variable that tells it which one it is.
SBATCH = """#!/usr/bin/env bash
set -euo pipefail
[[ "$1" =~ ^--array=([0-9]+)-([0-9]+)$ && "$2" = --wrap && $# -eq 3 ]] || { echo "sbatch --array=FIRST-LAST --wrap COMMAND" >&2; exit 2; }
for task in $(seq "${BASH_REMATCH[1]}" "${BASH_REMATCH[2]}"); do SLURM_ARRAY_TASK_ID=$task sh -c "$3"; done
"""


class Block:
    def __init__(self, document, line, mark):
        self.document, self.line, self.mark, self.commands = document, line, mark, []

    @property
    def python(self):
        return bool(self.commands and PYTHON.match(self.commands[0]))


def blocks(tree, document):
    """Blocks of commands of a document; a command may go on after a backslash."""
    lines = (tree / document).read_text(encoding="utf-8").splitlines()
    found, block, mark, fence, before = [], None, None, None, ""
    for number, line in enumerate(lines, 1):
        if line.startswith("```"):
            fence = None if fence is not None else line[3:].strip()
            block = None
            continue
        if mark is not None and mark["table"] and line.startswith("|"):
            if block is None:
                block = Block(document, number, mark)
                found.append(block)
            block.commands += [code for code in re.findall(r"`([^`]+)`", line) if OURS.match(code) and code not in block.commands]
            before = line
            continue
        indented = fence is None and line.startswith("    ") and (block is not None or not before.strip() or MARK.search(before))
        text = line if fence == "sh" else line[4:] if indented else None
        if text is None or not text.strip():
            block = block if text is not None or not line.strip() else None
            mark = MARK.search(line) or (mark if not line.strip() else None)
        elif block is not None and block.commands and block.commands[-1].endswith("\\"):
            block.commands[-1] = block.commands[-1][:-1] + text.strip()
        elif block is not None and block.python:
            block.commands[-1] += "\n" + text
        elif OURS.match(text) or (indented and PYTHON.match(text)):
            if block is None:
                block = Block(document, number, mark)
                found.append(block)
            block.commands.append(COMMENT.sub("", text).strip())
        before = line
    return found


class Sandbox:
    """The scratch folder with its stand-ins, and a shell that has sourced the devel space."""

    def __init__(self, tree, folder):
        self.tree, self.folder = tree, folder
        for name in ("scripts", "config", "devel", "build", "docs", "launch", "test"):
            (folder / name).symlink_to(tree / name)
        (folder / "home").mkdir()
        if not shutil.which("sbatch"):
            (folder / "bin").mkdir()
            (folder / "bin/sbatch").write_text(SBATCH, encoding="utf-8")
            (folder / "bin/sbatch").chmod(0o755)
        with socket.socket() as free:
            free.bind(("", 0))
            port = free.getsockname()[1]
        self.environment = {key: value for key, value in os.environ.items() if key in ("PATH", "LANG", "TERM")}
        self.environment.update(PATH=f"{folder}/bin:/usr/bin:" + os.environ["PATH"], HOME=str(folder / "home"), ROS_HOME=str(folder / "home/ros"),
                                ROS_HOSTNAME="localhost", ROS_MASTER_URI=f"http://localhost:{port}", MPLBACKEND="Agg",
                                ROSCONSOLE_STDOUT_LINE_BUFFERED="1", PYTHONDONTWRITEBYTECODE="1")
        self.make_recordings()
        self.master = self.start("roscore -p " + str(port))
        while self.run("rosparam list").returncode:
            time.sleep(0.5)

    def make_recordings(self):
        small = f"{TOWN} --size 416x240"
        phone = f"{RENDER} --layout recorder --gps-noise 1 --size 1280x960 --calibration 1000,1000,640,480"
        for command in (f"{LONGER} --out kitti/sequences/00", f"{TOWN} --out drive.bag --root kitti",
                        f"{small} --out irat.bag --root irat_red", f"{phone} --out phone",
                        "ln -s kitti/sequences/00 K", "ln -s kitti dataset", "ln -s K DISTURBED", "ln -s K DRIVE", "ln -s K OTHER",
                        "cp config/kitti.yaml C", "cp config/robot.yaml my.yaml", "cp phone/calibration.yaml phone.yaml",
                        "mv \"$(dirname phone/*/data_image.txt)\" '23-05-14 10:31:07'", "cp K/poses.txt 00.txt",
                        "cp K/poses.txt 02.txt", "cp K/times.txt times_00.txt", "mkdir -p out",
                        "ratslam_run K --config config/kitti.yaml --out whole --save-map map.db", "cp whole/odometry.csv .",
                        "ratslam_run K --config config/kitti.yaml --max-frames 60 --out first --save-map monday.db",
                        "ratslam_run K --config config/kitti.yaml --from-frame 60 --out second --save-map tuesday.db"):
            done = self.run(command)
            if done.returncode:
                raise SystemExit(f"stand-ins cannot be made: {command}\n{done.stdout}")

    def shell(self, command):
        ros = "[ -e /opt/ros/noetic/setup.bash ] && . /opt/ros/noetic/setup.bash; "
        return ["bash", "-c", f"{ros}. devel/setup.bash; {command}"]

    def run(self, command):
        folder = self.tree if BUILDS.match(command) else self.folder
        return subprocess.run(self.shell(command), cwd=folder, env=self.environment, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, timeout=TIMEOUT_S, check=False)

    def start(self, command, output=subprocess.DEVNULL):
        return subprocess.Popen(self.shell("exec " + command), cwd=self.folder, env=self.environment, stdout=output,
                                stderr=subprocess.STDOUT,
                                preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler))

    def run_live(self, command):
        """Starts what does not end, looks that it lasts, and stops it. @return (whether that went well, output)"""
        log = self.folder / "live.log"
        with open(log, "w", encoding="utf-8") as output:
            process = self.start(command, output)
            time.sleep(SETTLED_S)
            lasted = process.poll() is None
            process.send_signal(signal.SIGINT)
            try:
                process.wait(60.0)
            except subprocess.TimeoutExpired:
                process.kill()
                lasted = False
        text = log.read_text(encoding="utf-8")
        return lasted and not FATAL.search(text), text

    @contextlib.contextmanager
    def beside(self, command):
        """What a block needs runs meanwhile; nothing for None."""
        process = self.start(command) if command else None
        if process:
            time.sleep(SETTLED_S)
        yield
        if process:
            process.send_signal(signal.SIGINT)
            process.wait(60.0)

    def close(self):
        self.master.send_signal(signal.SIGINT)
        self.master.wait(30.0)


def is_live(command):
    return command.startswith("roslaunch") and "bag:=" not in command


def execute(sandbox, command, whole):
    """@return (word for the table, output)"""
    shorter = command if whole else SHORTER.get(command, command)
    shown = shorter.replace("rviz:=true", "rviz:=false")
    if PYTHON.match(command):
        shown = "python3 -c " + shlex.quote(command)
    try:
        if is_live(shown):
            good, output = sandbox.run_live(shown)
        else:
            done = sandbox.run(shown)
            good, output = done.returncode == 0, done.stdout
    except subprocess.TimeoutExpired as error:
        return f"FAILED after {error.timeout:.0f} s", str(error.stdout)
    changed = " (rviz:=false)" if "rviz:=true" in command else f" (as {shorter})" if shorter != command else ""
    return ("ok" if good else "FAILED") + changed, output


def reason_to_skip(block, command, short):
    """Why a command of a block does not run; None for one that does."""
    mark = block.mark.groupdict() if block.mark else {}
    absent = next((word for word in (command.split()[0] for command in block.commands)
                   if word == "parallel" and not shutil.which(word)), None)
    if absent:
        return absent + " is not installed"
    long = mark.get("long") or BUILDS.match(command)
    return mark.get("why") or ("long" if short and long else None)


def run_block(sandbox, block, commands, whole):
    """Runs the commands of a block and says how each went. @return number of those that failed"""
    failed = 0
    with sandbox.beside(block.mark and block.mark["beside"]):
        for command in commands:
            begin = time.monotonic()
            word, output = execute(sandbox, command, whole)
            print(f"{block.document}:{block.line}: {word}, {time.monotonic() - begin:.0f} s: {command}", flush=True)
            if word.startswith("FAILED"):
                failed += 1
                print("    " + "\n    ".join(output.splitlines()[-25:]), flush=True)
    return failed


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tree", type=pathlib.Path)
    parser.add_argument("--short", action="store_true", help="leave out what is marked as long")
    parser.add_argument("--whole", action="store_true", help="what takes hours is not made shorter")
    parser.add_argument("--only", help="this document, such as docs/robot.md")
    parser.add_argument("--list", action="store_true", help="only say what would run")
    options = parser.parse_args()
    tree = options.tree.resolve()
    documents = [options.only] if options.only else ["README.md", "CONTRIBUTING.md"] + sorted(
        str(path.relative_to(tree)) for path in (tree / "docs").glob("*.md"))
    failed, sandbox = 0, None
    folder = pathlib.Path(tempfile.mkdtemp(prefix="documents_"))
    try:
        for block in [block for document in documents for block in blocks(tree, document)]:
            commands = []
            for command in block.commands:
                reason = reason_to_skip(block, command, options.short)
                if reason or options.list:
                    print(f"{block.document}:{block.line}: {'skipped: ' + reason if reason else 'runs'}: {command}", flush=True)
                else:
                    commands.append(command)
            if commands:
                sandbox = sandbox or Sandbox(tree, folder)
                failed += run_block(sandbox, block, commands, options.whole)
    finally:
        if sandbox:
            sandbox.close()
        shutil.rmtree(folder)
    print(f"{failed} commands failed" if failed else "nothing was run" if sandbox is None else "every command works")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
