"""plot_run: figures of one run, with its errors if the truth is known."""

import argparse
import os

from ratslam_tools import evaluation, plotting, text_file
from ratslam_tools.datasets import kitti, truth
from ratslam_tools.errors import InputError, finite, require_effect
from ratslam_tools.runs import recorded_run, run_figures, run_folder
from ratslam_tools.table import format_table
from ratslam_tools.trajectory.association import MAX_STAMP_DIFFERENCE_S


def add_run_argument(parser: argparse.ArgumentParser) -> None:
    """The run to read."""
    parser.add_argument(
        "folder",
        metavar="RUN",
        help="folder that ratslam_run left, what was the nodes' trajectory_file, or a bag in which their topics were recorded",
    )


def add_truth_options(parser: argparse.ArgumentParser, required: bool = False) -> None:
    """Options for the ground truth."""
    parser.add_argument(
        "--truth",
        metavar="FILE",
        required=required,
        help="true trajectory: TUM or KITTI file, KITTI sequence folder, or bag with a topic ground_truth",
    )
    parser.add_argument(
        "--times", metavar="FILE", help="times.txt of KITTI poses, if it does not lie beside them"
    )
    parser.add_argument(
        "--t_max_diff",
        type=finite,
        metavar="S",
        help="largest difference of matched stamps (0.01 s)",
    )


def require_own_output(option: str, path, run: str, arguments) -> None:
    """@throws InputError if a file to write is one of the run or of its truth. Pages, pictures and saved results may be
    replaced."""
    known = arguments.truth
    poses = kitti.poses_file(known) if known and os.path.isdir(known) else None
    read = [*run_folder.files_of_run(run), run, *text_file.files_of(known), poses, arguments.times]
    text_file.require_other(option, path, read)


def default_output(run: str, name: str) -> str:
    """Path for a picture or page about a run: within its folder, or beside a bag or what the nodes have left."""
    if os.path.isdir(run):
        return os.path.join(run, name)
    return (run[: -len(".bag")] if run.endswith(".bag") else run) + "_" + name


def complete_truth_options(arguments) -> None:
    """@throws InputError for options about a truth that is not given, or out of range."""
    require_effect(arguments.truth is not None, "there is no --truth", times=arguments.times, t_max_diff=arguments.t_max_diff)
    if arguments.t_max_diff is None:
        arguments.t_max_diff = MAX_STAMP_DIFFERENCE_S
    if arguments.t_max_diff < 0.0:
        raise InputError(f"--t_max_diff: {arguments.t_max_diff:g} is not allowed: at least 0 s")


def aligned_run(arguments) -> run_figures.Aligned:
    """The run of parsed options, aligned with its truth if there is one."""
    complete_truth_options(arguments)
    known = None if arguments.truth is None else truth.read_truth(arguments.truth, arguments.times)
    return run_figures.Aligned(recorded_run.open_run(arguments.folder), known, arguments.t_max_diff)


def main(argv=None) -> None:
    """plot_run."""
    parser = argparse.ArgumentParser(
        prog="plot_run",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Pictures of a run: map with truth, online and final "
        "trajectory and loop "
        "links; view cells, experiences and pose cells over time; timing. Prints the APE if there is a "
        "truth.",
        epilog="examples:\n  plot_run out/kitti_00\n  plot_run out/kitti_00 --truth dataset/sequences/00 "
        "--out run.pdf\n"
        "  plot_run out/demo --truth out/demo/truth.tum --map_only --out map.png\n"
        "  plot_run out/demo/ros/trajectory\n"
        "  plot_run recorded.bag        (as OpenRatSLAM's show_em.py and show_id.py)",
    )
    add_run_argument(parser)
    add_truth_options(parser)
    parser.add_argument(
        "--out",
        type=plotting.picture_file,
        metavar="FILE",
        help="picture to write, .png or .pdf (default: RUN/run.png, or RUN_run.png if it is no folder)",
    )
    part = parser.add_mutually_exclusive_group()
    part.add_argument("--map_only", action="store_true", help="the map without the panels beside it")
    part.add_argument("--timing_only", action="store_true", help="the time of each module alone")
    parser.add_argument("--save_results", metavar="FILE.json", help="write the errors")
    arguments = parser.parse_args(argv)
    require_effect(arguments.truth is not None, "without --truth there are no errors", save_results=arguments.save_results)
    for option, path in (("--out", arguments.out), ("--save_results", arguments.save_results)):
        require_own_output(option, path, arguments.folder, arguments)
    text_file.require_other("--save_results", arguments.save_results, [arguments.out], "written")
    aligned = aligned_run(arguments)
    path = arguments.out or default_output(arguments.folder, "run.png")
    if arguments.map_only:
        figure = run_figures.map_figure(aligned)
    elif arguments.timing_only:
        figure = run_figures.timing_figure(aligned.run)
    else:
        figure = run_figures.overview_figure(aligned)
    plotting.finish(plotting.load(), figure, path)
    if aligned.results:
        print("APE, aligned (rotation, translation, scale)" + (", but for the notes below" if aligned.notes else ""))
        print(format_table(run_figures.error_rows(aligned)))
        if len(aligned.run.final.stretches) > 1:
            print(run_figures.stretch_words(aligned.run))
        for note in aligned.notes.values():
            print(f"note: {note}")
    if arguments.save_results:
        final = aligned.run.final
        own = aligned.run.own_stretches(final)
        evaluation.write_json(
            arguments.save_results,
            {
                "metric": "ape",
                "reference": arguments.truth,
                "stretches": {"evaluated": [number + 1 for number in own], "of": len(final.stretches)},
                "results": [result.record() for result in aligned.results],
            },
        )
    print(f"wrote {path}")
