"""reproduce_records: the map's errors on the KITTI sequences at hand, and published figures."""

import argparse
import os

from ratslam_tools import evaluation
from ratslam_tools.cli.reproduce_paper import sequence_folders, sequence_names
from ratslam_tools.datasets import truth
from ratslam_tools.errors import InputError
from ratslam_tools.evaluation import comparison, metrics
from ratslam_tools.runs import run_folder, runner
from ratslam_tools.table import format_table

# ORB-SLAM2 with one camera and its loop closing, whole sequences: rmse after similarity alignment [m].
PUBLISHED_RMSE = {"00": 6.03, "02": 14.76, "05": 4.04, "06": 11.16, "07": 2.19, "08": 38.85, "09": 8.39}
# One camera whose height above the road is known, without loop closing: mean translation error [%], metric.
PUBLISHED_METRIC_PERCENT = 1.19
SEQUENCES = tuple(f"{number:02d}" for number in range(11))
HEAD = (
    "sequence",
    "trajectory",
    "poses",
    "scale-aligned mean m",
    "rmse m",
    "published rmse m",
    "metric mean m",
    "rmse m",
    "drift %",
    "published %",
    "deg/100m",
)


def present(folder: str, names) -> list:
    """(name, folder) of the requested sequences, or of all in the folder.

    @throws InputError if there is none.
    """
    if names or os.path.isfile(os.path.join(folder, "times.txt")):
        return sequence_folders(folder, names)
    found = [name for name in SEQUENCES if os.path.isfile(os.path.join(folder, "sequences", name, "times.txt"))]
    if not found:
        raise InputError(f"{folder}: neither a sequence (times.txt) nor a folder with sequences/00 ... sequences/10")
    return [(name, os.path.join(folder, "sequences", name)) for name in found]


def record(name: str, known, estimate) -> dict:
    """Errors of one trajectory: aligned by similarity, and metric."""
    figures = {"sequence": name, "trajectory": estimate.name}
    for kind, scale in (("scale_aligned", True), ("metric", False)):
        settings = comparison.Settings(align=True, correct_scale=scale)
        compared = comparison.compare(known, estimate, settings, needs_body=False)
        figures[kind] = metrics.statistics(metrics.ape(compared.reference, compared.estimate))
        figures["coverage"] = compared.coverage
    compared = comparison.compare(known, estimate, comparison.Settings(), needs_body=True)
    figures["drift"] = metrics.kitti_average(metrics.kitti_drift(compared.reference, compared.estimate))
    return figures


def row(figures: dict) -> list:
    """One line of the table."""
    final = figures["trajectory"] == "final"
    published = PUBLISHED_RMSE.get(figures["sequence"])
    return [
        figures["sequence"],
        figures["trajectory"],
        f"{100 * figures['coverage']:.1f} %",
        f"{figures['scale_aligned']['mean']:.2f}",
        f"{figures['scale_aligned']['rmse']:.2f}",
        f"{published:.2f}" if final and published is not None else "",
        f"{figures['metric']['mean']:.2f}",
        f"{figures['metric']['rmse']:.2f}",
        f"{figures['drift']['translation_percent']:.2f}",
        f"{PUBLISHED_METRIC_PERCENT:.2f}" if figures["trajectory"] == "odometry" else "",
        f"{figures['drift']['rotation_deg_per_100m']:.3f}",
    ]


def main(argv=None) -> None:
    """reproduce_records."""
    parser = argparse.ArgumentParser(
        prog="reproduce_records",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Runs the ORB odometry and the map over the KITTI sequences that FOLDER holds, with the shipped "
        "configuration, and prints the errors beside published ones: scale-aligned against ORB-SLAM2 with one camera "
        "and loop closing, metric against methods that know the camera's height. Sequences done before are not run "
        "again.",
        epilog="examples:\n  reproduce_records dataset --out out/records\n"
        "  reproduce_records dataset --sequences 05 07 --out out/records",
    )
    parser.add_argument("folder", metavar="FOLDER", help="root with sequences/ and poses/, or one sequence")
    parser.add_argument(
        "--sequences", nargs="+", metavar="NN", help="only these, also as NN,NN (default: all that are there)"
    )
    parser.add_argument("--out", default="out/records", metavar="DIR", help="folder for the runs (default: %(default)s)")
    parser.add_argument("--config", metavar="FILE", help="another configuration than the shipped kitti_orb.yaml")
    parser.add_argument("--max-frames", type=int, metavar="N", help="stop each run after so many frames")
    parser.add_argument("--ratslam_run", metavar="FILE", help="the program, if it is not found by itself")
    arguments = parser.parse_args(argv)
    runner.require_apart(arguments.out, arguments.folder)
    sequences = present(arguments.folder, sequence_names(arguments.sequences))
    program = runner.find(arguments.ratslam_run)
    config = arguments.config or runner.find_config("kitti_orb.yaml")
    records = []
    for name, folder in sequences:
        known = truth.read_truth(folder)
        out = os.path.join(arguments.out, name)
        words = runner.command(program, folder, config, out, {}, "orb", arguments.max_frames)
        run = run_folder.Run(runner.run_once(words, out))
        if run.odometry is not None:
            records.append(record(name, known, run.odometry))
        records.append(record(name, known, run.final))
        print(f"{name}: done, {out}", flush=True)
    print(format_table([list(HEAD)] + [row(figures) for figures in records]))
    evaluation.write_json(os.path.join(arguments.out, "records.json"), {"config": config, "records": records})
    print(f"wrote {os.path.join(arguments.out, 'records.json')}")
