"""What the tests share: the package on the path, the command lines, synthetic trajectories, the data
folder.
"""

import os
import struct
import subprocess
import sys
import zlib

import numpy as np
import pytest

SOURCE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SCRIPTS = os.path.join(SOURCE, "scripts")
sys.path.insert(0, SCRIPTS)

from ratslam_tools.errors import InputError  # noqa: E402
from ratslam_tools.runs import runner  # noqa: E402
from ratslam_tools.trajectory import geometry  # noqa: E402
from ratslam_tools.trajectory import Trajectory  # noqa: E402


def built(*names):
    """Paths of ratslam_run and of the programs beside it; skips where one is not built."""
    try:
        found = [runner.find()]
    except InputError as error:
        pytest.skip(str(error))
    found += [os.path.join(os.path.dirname(found[0]), name) for name in names]
    for program in found:
        if not os.path.isfile(program):
            pytest.skip(f"{program} is absent")
    return found


def png(width, height):
    """A black grey image as the bytes of a PNG."""
    chunks = [
        (b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)),
        (b"IDAT", zlib.compress(b"\0" * (width + 1) * height)),
        (b"IEND", b""),
    ]
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)) for kind, data in chunks
    )


@pytest.fixture
def run():
    """Calls a command line; returns the finished process with text output."""

    def call(name, *words, **options):
        environment = dict(os.environ, **options.pop("env", {}))
        return subprocess.run(
            [sys.executable, os.path.join(SCRIPTS, name), *map(str, words)],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            universal_newlines=True,
            check=False,
            env=environment,
            **options,
        )

    return call


@pytest.fixture
def fails(run):
    """Calls a command line that must end with status 1, one line on stderr and nothing on stdout; returns
    that line.
    """

    def call(name, *words):
        result = run(name, *words)
        assert result.returncode == 1, result
        assert result.stderr.startswith("error: ") and result.stderr.count("\n") == 1, result.stderr
        assert result.stdout == ""
        return result.stderr

    return call


@pytest.fixture
def data():
    """Path of a file of the evaluation data; skips the test where it is absent."""

    def path(*parts):
        folder = os.environ.get("RATSLAM_DATA", os.path.join(SOURCE, "..", "shared", "data"))
        found = os.path.join(folder, *parts)
        if not os.path.exists(found):
            pytest.skip(f"{found} is absent (set RATSLAM_DATA)")
        return found

    return path


@pytest.fixture
def drive():
    """A vehicle's path in base convention: x forward along a winding, hilly way; 10 Hz, about 0.8 m a
    step.
    """

    def make(count=200, name="drive"):
        time = np.arange(count) * 0.1
        yaw = 1.3 * np.sin(0.21 * time) + 0.1 * time
        pitch = 0.05 * np.sin(0.4 * time)
        rotations = np.array(
            [geometry.rotation_about_z(a) @ geometry.rotation_about_y(b) for a, b in zip(yaw, pitch)]
        )
        steps = 0.8 * rotations[:, :, 0]
        positions = np.vstack([np.zeros(3), np.cumsum(steps, axis=0)[:-1]])
        return Trajectory(positions, rotations, time, name)

    return make


@pytest.fixture
def turn():
    """A rotation about a skew axis."""
    return geometry.rotation_about_z(0.7) @ geometry.rotation_about_x(-1.1) @ geometry.rotation_about_y(0.3)
