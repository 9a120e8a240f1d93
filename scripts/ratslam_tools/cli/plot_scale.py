"""plot_scale: scale along the path of a map whose odometry's unit of length drifts."""

import argparse
import json
import os

import numpy as np

from ratslam_tools import evaluation, plotting
from ratslam_tools.datasets import truth
from ratslam_tools.datasets.sources import tell_later_files
from ratslam_tools.evaluation import comparison
from ratslam_tools.trajectory.association import MAX_STAMP_DIFFERENCE_S
from ratslam_tools.errors import InputError, require_folder
from ratslam_tools.runs import run_folder
from ratslam_tools.trajectory import geometry, read_trajectory

WINDOW_M = 60.0  # of true way, over which lengths are compared
MAY_DIFFER = ("exp_scale", "exp_scale_sigma", "threads")  # between the two runs
SAME_ODOMETRY_M = 1e-3


def local_scale(reference: np.ndarray, estimate: np.ndarray, window: float = WINDOW_M):
    """Length of an estimate / length of the reference, along the path.

    reference, estimate: positions (n, 3) of the same poses [m]. Returns (way, ratio): the path length [m] at the
    middle of each stretch of `window` metres of the reference, and the ratio over that stretch. @throws InputError if
    the reference is shorter than one window.
    """
    driven = geometry.path_length(reference)
    if driven[-1] < window:
        raise InputError(f"the true path is {driven[-1]:.1f} m long; {window:.0f} m are needed")
    starts = np.arange(np.searchsorted(driven, driven[-1] - window, side="right"))
    ends = np.minimum(np.searchsorted(driven, driven[starts] + window), len(driven) - 1)
    length = geometry.path_length(estimate)
    ratio = (length[ends] - length[starts]) / (driven[ends] - driven[starts])
    return 0.5 * (driven[starts] + driven[ends]), ratio


def scale_figure(reference, estimates: dict):
    """Figure of the maps over the truth, and of the scale along the path.

    reference: true trajectory in base axes; estimates: label -> (trajectory, colour). Each is aligned by
    similarity. Returns the figure and the mean APE of each [m].
    """
    settings = comparison.Settings(
        align=True,
        correct_scale=True,
        t_max_diff=MAX_STAMP_DIFFERENCE_S,
        ref_frame="base",
        est_frame="base",
    )
    pyplot = plotting.load()
    figure, (plan, along) = pyplot.subplots(
        1, 2, figsize=(12, 6.2), constrained_layout=True, gridspec_kw={"width_ratios": [1.15, 1.0]}
    )
    true = reference.positions
    plan.plot(true[:, 0], true[:, 1], color=plotting.TRUTH, linewidth=1.2, linestyle="--", label="truth")
    means = {}
    for label, (trajectory, colour) in estimates.items():
        result = evaluation.evaluate_ape(reference, [trajectory], settings)[0]
        means[label] = float(result.errors.mean())
        fitted = result.compared.estimate.positions
        plan.plot(
            fitted[:, 0], fitted[:, 1], color=colour, linewidth=1.4, label=plotting.literal(f"{label}: {means[label]:.2f} m")
        )
        way, ratio = local_scale(result.compared.reference.positions, fitted)
        along.plot(way, ratio, color=colour, linewidth=1.4, label=plotting.literal(label))
    plan.set_aspect("equal", adjustable="datalim")
    plotting.scale_bar(plan)
    plan.set_xlabel("x [m]")
    plan.set_ylabel("y [m]")
    plan.set_title("aligned by similarity; mean APE")
    along.axhline(1.0, color=plotting.TRUTH, linewidth=1.2, linestyle="--")
    along.set_xlabel("way [m]")
    along.set_ylabel(f"length / true length, over {WINDOW_M:.0f} m")
    along.set_title("scale along the way")
    for axes in (plan, along):
        axes.grid(alpha=0.25)
        axes.legend(loc="best", fontsize=9)
    return figure, means


def _parameters(folder: str) -> dict:
    """Parameters of a run. @throws InputError if it does not state exp_scale"""
    require_folder(folder)
    path = os.path.join(folder, "summary.json")
    stated = run_folder.read_json(path).get("parameters")
    if not isinstance(stated, dict) or "exp_scale" not in stated:
        raise InputError(f"{path}: it states no exp_scale: not the summary of a run that ratslam_run left")
    return stated


def require_pair(without: str, with_scale: str) -> None:
    """@throws InputError unless the folders are of one drive with one odometry, without and with scale in the map."""
    stated = {folder: _parameters(folder) for folder in (without, with_scale)}
    for folder, name, wanted in ((without, "WITHOUT", False), (with_scale, "WITH", True)):
        found = stated[folder]["exp_scale"]
        if found is not wanted:
            raise InputError(
                f"{folder}: its run has exp_scale={json.dumps(found)}; {name} must be the one with {json.dumps(wanted)}"
            )
    first, second = stated[without], stated[with_scale]
    for key in sorted({*first, *second} - {*MAY_DIFFER}):
        if first.get(key) != second.get(key):
            values = [json.dumps(each[key]) if key in each else "none" for each in (first, second)]
            raise InputError(
                f"{with_scale}: its run has {key}={values[1]}, that of {without} {values[0]}; only exp_scale may differ"
            )
    ways = [read_trajectory(os.path.join(folder, "trajectory_odometry.tum")) for folder in (without, with_scale)]
    same = len(ways[0]) == len(ways[1]) and np.array_equal(ways[0].stamps, ways[1].stamps)
    if not same or np.abs(ways[0].positions - ways[1].positions).max() > SAME_ODOMETRY_M:
        raise InputError(
            f"{with_scale}: its trajectory_odometry.tum is not that of {without}; both runs need the same recording and odometry"
        )


def main(argv=None) -> None:
    """plot_scale."""
    parser = argparse.ArgumentParser(
        prog="plot_scale",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        description="One drive mapped without and with scale, over the truth, beside the odometry alone; and "
        "the scale of each along the way.",
        epilog="examples:\n"
        "  ratslam_run K --config config/kitti_orb.yaml --odometry orb --out out/with\n"
        "  ratslam_run K --config config/kitti_orb.yaml --odometry orb --set exp_scale=false --out out/without\n"
        "  plot_scale out/without out/with --truth K --out scale.png",
    )
    parser.add_argument("without", metavar="WITHOUT", help="folder of the run with exp_scale=false")
    parser.add_argument("with_scale", metavar="WITH", help="folder of the run with exp_scale=true")
    parser.add_argument(
        "--truth", required=True, metavar="FILE", help="true trajectory, as plot_run takes it"
    )
    parser.add_argument("--times", metavar="FILE", help="times.txt of KITTI poses, if it does not lie beside")
    parser.add_argument(
        "--out", required=True, type=plotting.picture_file, metavar="FILE", help="picture to write, .png or .pdf"
    )
    arguments = parser.parse_args(argv)
    require_pair(arguments.without, arguments.with_scale)
    final = "trajectory_final.tum"
    sources = {
        "odometry alone": (arguments.with_scale, "trajectory_odometry.tum", "0.6"),
        "map without scale": (arguments.without, final, plotting.ONLINE),
        "map with scale": (arguments.with_scale, final, plotting.FINAL),
    }
    estimates = {
        label: (read_trajectory(os.path.join(folder, name)), colour)
        for label, (folder, name, colour) in sources.items()
    }
    for folder, name, _ in sources.values():
        tell_later_files(os.path.join(folder, name))
    figure, means = scale_figure(truth.read_truth(arguments.truth, arguments.times), estimates)
    plotting.finish(plotting.load(), figure, arguments.out, dpi=100)
    for label, mean in means.items():
        print(f"{label:20} mean APE {mean:7.3f} m")
    print(f"wrote {arguments.out}")
