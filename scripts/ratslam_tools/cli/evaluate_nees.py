"""evaluate_nees: consistency of a run's covariances with its errors."""

import argparse
import os
import sys

from ratslam_tools.cli.plot_run import require_own_output
from ratslam_tools.datasets import odometry_file, truth
from ratslam_tools.errors import InputError, require_folder
from ratslam_tools.evaluation import consistency, write_json
from ratslam_tools.runs import run_folder
from ratslam_tools.table import format_table
from ratslam_tools.trajectory import later_files, read_trajectory


def main(argv=None) -> None:
    """evaluate_nees."""
    parser = argparse.ArgumentParser(
        prog="evaluate_nees",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Normalised estimation error squared of the odometry's motion (6 degrees of freedom) and of the "
        "robot's pose in the map as it was known at the time (x, y, z, yaw), against the true path in metres. If "
        "the covariances are right, 95 % lie in the band.",
        epilog="example:\n  ratslam_run TOWN --config config/kitti_orb.yaml --odometry orb --out out/town\n"
        "  evaluate_nees out/town --truth TOWN/poses.txt",
    )
    parser.add_argument("run", metavar="RUN", help="folder that ratslam_run left")
    parser.add_argument("--truth", required=True, metavar="FILE", help="true trajectory, as plot_run takes it")
    parser.add_argument("--times", metavar="FILE", help="times.txt of KITTI poses, if it does not lie beside")
    parser.add_argument("--save_results", metavar="FILE.json", help="write the figures")
    arguments = parser.parse_args(argv)
    require_folder(arguments.run)
    require_own_output("--save_results", arguments.save_results, arguments.run, arguments)
    known = truth.read_truth(arguments.truth, arguments.times)
    poses = os.path.join(arguments.run, "pose_covariance.csv")
    if not os.path.isfile(poses):
        raise InputError(f"{poses}: no such file; a run with exp_solver=graph leaves it")
    odometry = os.path.join(arguments.run, "odometry.csv")
    stretches = [[path, *later_files(path)] for path in (odometry, poses, os.path.join(arguments.run, "trajectory_online.tum"))]
    odometry, poses, online = (files[-1] for files in stretches)  # the truth belongs to the recording of this run
    motions = odometry_file.read_motions(odometry)
    columns = run_folder.read_columns(poses, consistency.POSE_COLUMNS)
    path = read_trajectory(online)
    results = {}
    if motions is None:
        told = "it states no poses with covariances, as only this package's odometries do; only the pose in the map is judged"
        print(f"note: {odometry}: {told}", file=sys.stderr)
    else:
        results["odometry"] = consistency.summary(_of_file(odometry, consistency.motion_nees, motions, known), 6)
    results["map"] = consistency.summary(_of_file(poses, consistency.pose_nees, columns, path, known), 4)
    rows = [["NEES of", "count", "free", "mean", "median", "95 % band", "in band", "below", "above", "up to 95 %"]]
    for name, found in results.items():
        rows.append(
            [
                {"odometry": "odometry's motion", "map": "pose in the map"}[name],
                str(found["count"]),
                str(found["freedom"]),
                f"{found['mean']:.2f}",
                f"{found['median']:.2f}",
                f"{found['band'][0]:.2f} - {found['band'][1]:.2f}",
            ]
            + [f"{found[key]:.1f} %" for key in ("percent_in_band", "percent_below", "percent_above", "percent_to_95")]
        )
    print(format_table(rows))
    count = max(map(len, stretches))
    if count > 1:
        print(f"evaluated: the last stretch of {count} ({odometry}, {poses})")
    if arguments.save_results:
        write_json(arguments.save_results, {"metric": "nees", "run": arguments.run, "results": results})


def _of_file(path: str, nees, *values):
    """nees(*values), whose values are from the file. @throws InputError that names it"""
    try:
        return nees(*values)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
