"""Evaluation, pictures and data-set conversion for ratslam_ros.

Packages: `trajectory` (poses, their files, axes, matching), `evaluation` (errors), `datasets` (recordings and their
files), `runs` (starting ratslam_run, and its results) and `cli` (one module per command; the commands in the folder
above only call their `main` functions).
Positions are in metres, angles in radians and stamps in seconds unless a name says otherwise.
"""

import importlib
import os

PACKAGES = ("trajectory", "evaluation", "datasets", "runs", "cli")

# The folder of the commands, in the source tree or installed.
SCRIPTS = os.path.dirname(os.path.dirname(os.path.realpath(__file__)))


def __getattr__(name: str):
    """A package, loaded when it is first asked for."""
    if name in PACKAGES:
        return importlib.import_module(f"{__name__}.{name}")
    raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
