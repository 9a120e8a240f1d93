"""However a command is asked to end, it stops the programs that it has started."""

import os
import signal
import subprocess
import sys
import time

import pytest

from conftest import SCRIPTS

HOLDS = """#!{python}
import os, time
with open({told!r} + ".new", "w") as file:
    file.write(str(os.getpid()))
os.rename({told!r} + ".new", {told!r})
time.sleep(60)
"""


def until(condition):
    deadline = time.monotonic() + 30.0
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.05)


@pytest.fixture(name="start")
def starting(tmp_path):
    """Starts a sweep over a program that takes a minute; returns the process, and the id of the program's."""

    def begin(*prefix):
        told = tmp_path / "id"
        program = tmp_path / "ratslam_run"
        program.write_text(HOLDS.format(python=sys.executable, told=str(told)))
        program.chmod(0o755)
        (tmp_path / "recording").mkdir()
        (tmp_path / "c.yaml").write_text("")
        words = [sys.executable, os.path.join(SCRIPTS, "sweep"), "recording", "--config", "c.yaml", "--vary", "k=1,2,3"]
        words += ["--goal", "counts.recalls", "--jobs", "1", "--out", "out", "--ratslam_run", program]
        process = subprocess.Popen(
            [*prefix, *words], cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, preexec_fn=heed_signals
        )
        until(lambda: told.exists() or process.poll() is not None)
        return process, int(told.read_text())

    return begin


def heed_signals():
    """Whoever was started in the background of a script ignores some, and so do its children."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)


def runs(number):
    try:
        os.kill(number, 0)
        return True
    except ProcessLookupError:
        return False


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_sweep_that_is_asked_to_end_stops_its_runs(start, number):
    process, program = start()
    try:
        process.send_signal(number)
        assert process.communicate(timeout=30)[1] == b"interrupted\n"
        assert process.returncode == 128 + number
        until(lambda: not runs(program))
    finally:
        if runs(program):
            os.kill(program, signal.SIGKILL)


def test_a_sweep_goes_on_where_the_end_of_its_terminal_is_ignored(start):
    process, program = start("nohup")
    try:
        process.send_signal(signal.SIGHUP)
        time.sleep(1.0)
        assert process.poll() is None and runs(program)
        process.terminate()
        process.communicate(timeout=30)
    finally:
        if runs(program):
            os.kill(program, signal.SIGKILL)
