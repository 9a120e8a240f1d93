"""Evaluation, pictures and data-set conversion for ratslam_ros.

Rooms: `trajectory` (poses, their files, axes, matching), `evaluation` (errors), `datasets` (recordings and what
they consist of), `runs` (what a run of ratslam_run leaves, starting one) and `cli` (one module a command; the
commands in the folder above only call the `main` functions found there).
Positions are in metres, angles in radians and stamps in seconds unless a name says otherwise.
"""

import os

# The folder of the commands, in the source tree or installed.
SCRIPTS = os.path.dirname(os.path.dirname(os.path.realpath(__file__)))
