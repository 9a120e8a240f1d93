"""Trajectories: their files, axes, turns, matching and alignment."""

from ratslam_tools.trajectory.poses import (  # noqa: F401
    Trajectory,
    breaks_of,
    has_stamps,
    later_files,
    read_stretches,
    read_table,
    read_times,
    read_trajectory,
    write_kitti,
    write_tum,
)
