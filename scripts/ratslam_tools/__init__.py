"""Evaluation, pictures and data-set conversion for ratslam_ros.

One concept a module; the command lines in the folder above only call the `main` functions found here.
Positions are in metres, angles in radians and stamps in seconds unless a name says otherwise.
"""
