"""The command lines evaluate_ape, evaluate_rpe and evaluate_kitti: options (evo's names), table, JSON file,
figure.
"""

import argparse
from dataclasses import asdict
from typing import List

from ratslam_tools import plotting, text_file
from ratslam_tools.datasets import sources
from ratslam_tools.evaluation import comparison, metrics
from ratslam_tools.trajectory import frames
from ratslam_tools.errors import InputError, finite
from ratslam_tools.evaluation import Result, evaluate_ape, evaluate_rpe, print_results, tell_collapse, write_json
from ratslam_tools.table import format_table

RELATION_WORDS = {
    "trans_part": "translation part",
    "angle_deg": "rotation angle",
    "angle_rad": "rotation angle",
    "full": "full transformation",
}


def add_input_options(parser: argparse.ArgumentParser) -> None:
    """Options for the trajectories to compare, their matching and alignment."""
    parser.add_argument(
        "reference", metavar="REF", help="true trajectory: a TUM or KITTI file, a bag with a topic ground_truth, or a topic "
        "with --bag"
    )
    parser.add_argument("estimates", metavar="EST", nargs="+", help="estimated trajectories: files, or topics with --bag")
    parser.add_argument("--bag", metavar="FILE", help="take REF and EST from topics of this bag")
    parser.add_argument(
        "--format",
        choices=("auto", "tum", "kitti"),
        default="auto",
        help="form of all files (default: by columns)",
    )
    parser.add_argument("--times", metavar="FILE", help="times.txt that gives KITTI poses their stamps")
    group = parser.add_argument_group("alignment and matching")
    group.add_argument("-a", "--align", action="store_true", help="align rotation and translation (Umeyama)")
    group.add_argument("-s", "--correct_scale", action="store_true", help="correct the scale as well")
    group.add_argument("--n_to_align", type=int, metavar="N", help="align by the first N matched poses only")
    group.add_argument(
        "--t_max_diff",
        type=finite,
        default=0.01,
        metavar="S",
        help="largest difference of matched stamps (0.01 s)",
    )
    group.add_argument("--t_offset", type=finite, default=0.0, metavar="S", help="added to the stamps of EST")
    group.add_argument(
        "--ref_frame", choices=frames.FRAMES, help="convention of REF; it is converted to base"
    )
    group.add_argument(
        "--est_frame", choices=frames.FRAMES, help="convention of EST; it is converted to base"
    )


def add_relation_options(parser: argparse.ArgumentParser) -> None:
    """Options for the part of the error to evaluate."""
    parser.add_argument(
        "-r",
        "--pose_relation",
        choices=tuple(metrics.RELATIONS),
        default="trans_part",
        help="trans_part [m] (default), angle_deg, angle_rad, or full (translation and rotation, unit-less)",
    )
    parser.add_argument(
        "--project_to_plane", choices=tuple(frames.PLANES), help="project both to this plane before aligning"
    )


def add_output_options(parser: argparse.ArgumentParser, with_plot: bool = True) -> None:
    """Options for output files and windows."""
    group = parser.add_argument_group("output")
    group.add_argument("--save_results", metavar="FILE.json", help="write figures and settings")
    if with_plot:
        group.add_argument(
            "--save_plot",
            type=plotting.picture_file,
            metavar="FILE",
            help="write error over time and coloured trajectories (.png or .pdf)",
        )
        group.add_argument("-p", "--plot", action="store_true", help="show the same in a window")


def settings_of(arguments) -> comparison.Settings:
    """The comparison settings of parsed options."""
    if not arguments.t_max_diff >= 0:
        raise InputError(f"--t_max_diff: {arguments.t_max_diff} is not allowed: at least 0 s")
    sources.require_effects(
        [arguments.reference, *arguments.estimates], arguments.format, arguments.times, arguments.bag
    )
    if arguments.n_to_align is not None and not (arguments.align or arguments.correct_scale):
        raise InputError(f"--n_to_align: {arguments.n_to_align} poses are to be aligned, but nothing is: add -a, -s or -as")
    for option in ("save_results", "save_plot"):
        text_file.require_other(
            f"--{option}",
            getattr(arguments, option, None),
            [arguments.reference, *arguments.estimates, arguments.bag, arguments.times],
        )
    text_file.require_other("--save_plot", getattr(arguments, "save_plot", None), [arguments.save_results], "written")
    return comparison.Settings(
        arguments.align,
        arguments.correct_scale,
        arguments.n_to_align,
        arguments.t_max_diff,
        arguments.t_offset,
        arguments.ref_frame,
        arguments.est_frame,
        getattr(arguments, "project_to_plane", None),
    )


def finish(arguments, title: str, unit: str, metric: str, reference, results: List[Result], settings) -> None:
    """Prints, saves and plots the results according to the options."""
    print_results(title, reference, results)
    if arguments.save_results:
        record = {
            "metric": metric,
            "relation": arguments.pose_relation,
            "unit": unit,
            "reference": reference.name,
            "settings": asdict(settings),
            "results": [result.record() for result in results],
        }
        for key in ("delta", "delta_unit", "all_pairs"):
            if hasattr(arguments, key):
                record[key] = getattr(arguments, key)
        write_json(arguments.save_results, record)
    if arguments.save_plot or arguments.plot:
        from ratslam_tools.evaluation import error_plots  # matplotlib takes a second to load

        error_plots.plot_errors(
            results, title, f"{metric.upper()} [{unit}]", arguments.save_plot, arguments.plot
        )


def _title(metric: str, arguments, settings, results: List[Result], extra: str = "") -> str:
    """First line of the table: metric, relation, unit, alignment, frames."""
    unit = metrics.RELATIONS[arguments.pose_relation]
    plane = f", projected to {settings.plane}" if settings.plane else ""
    converted = [
        f"{who} from {frame}"
        for who, frame in (("REF", settings.ref_frame), ("EST", settings.est_frame))
        if frame == "camera"
    ]
    axes = f"; converted to base axes: {', '.join(converted)}" if converted else ""
    poses = max(len(result.compared.reference) for result in results)
    relation = f"{metric} {RELATION_WORDS[arguments.pose_relation]} [{unit}]"
    return f"{relation}{extra}, {settings.describe(poses)}{plane}{axes}"


def ape_main(argv=None) -> None:
    """evaluate_ape."""
    parser = argparse.ArgumentParser(
        prog="evaluate_ape",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Absolute pose error of estimated trajectories, in space and on the ground plane "
        "(docs/evaluation.md).",
        epilog="examples:\n  evaluate_ape -as truth.tum trajectory_online.tum trajectory_final.tum "
        "--save_plot ape.png\n"
        "  evaluate_ape -as poses.txt trajectory_final.tum --times times.txt\n"
        "  evaluate_ape -a --bag run.bag /ground_truth /odom --save_results ape.json",
    )
    add_input_options(parser)
    add_relation_options(parser)
    add_output_options(parser)
    arguments = parser.parse_args(argv)
    settings = settings_of(arguments)
    reference = sources.read_reference(arguments.reference, arguments.format, arguments.times, arguments.bag)
    estimates = sources.read_estimates(arguments.estimates, arguments.format, arguments.times, arguments.bag)
    results = evaluate_ape(reference, estimates, settings, arguments.pose_relation)
    finish(
        arguments,
        _title("APE", arguments, settings, results),
        metrics.RELATIONS[arguments.pose_relation],
        "ape",
        reference,
        results,
        settings,
    )


def rpe_main(argv=None) -> None:
    """evaluate_rpe."""
    parser = argparse.ArgumentParser(
        prog="evaluate_rpe",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Relative pose error of estimated trajectories over a step in frames or metres "
        "(docs/evaluation.md).",
        epilog="examples:\n  evaluate_rpe -as truth.tum trajectory_final.tum\n"
        "  evaluate_rpe -s -d 100 -u m --all_pairs truth.tum trajectory_final.tum\n"
        "  evaluate_rpe -as poses.txt trajectory_final.tum --times times.txt --ref_frame camera --est_frame "
        "base --all_deltas",
    )
    add_input_options(parser)
    add_relation_options(parser)
    group = parser.add_argument_group("steps")
    group.add_argument("-d", "--delta", type=finite, default=1.0, help="length of a step (default 1)")
    group.add_argument(
        "-u",
        "--delta_unit",
        choices=("f", "m"),
        default="f",
        help="frames (default) or metres along the estimate",
    )
    group.add_argument(
        "--all_pairs", action="store_true", help="a step from every pose, not one after another"
    )
    group.add_argument(
        "--all_deltas", action="store_true", help="also the average of the RMSE over all steps, equation (11)"
    )
    add_output_options(parser)
    arguments = parser.parse_args(argv)
    settings = settings_of(arguments)
    reference = sources.read_reference(arguments.reference, arguments.format, arguments.times, arguments.bag)
    estimates = sources.read_estimates(arguments.estimates, arguments.format, arguments.times, arguments.bag)
    results = evaluate_rpe(
        reference,
        estimates,
        settings,
        arguments.pose_relation,
        arguments.delta,
        arguments.delta_unit,
        arguments.all_pairs,
        arguments.all_deltas,
    )
    step = f" over {arguments.delta:g} {'frames' if arguments.delta_unit == 'f' else 'm'}"
    step += ", overlapping" if arguments.all_pairs else ""
    finish(
        arguments,
        _title("RPE", arguments, settings, results, step),
        metrics.RELATIONS[arguments.pose_relation],
        "rpe",
        reference,
        results,
        settings,
    )


def kitti_main(argv=None) -> None:
    """evaluate_kitti."""
    parser = argparse.ArgumentParser(
        prog="evaluate_kitti",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        description="KITTI's drift: translation in % and rotation in deg per 100 m over sub-sequences of "
        "100 to 800 m.",
        epilog="examples:\n  evaluate_kitti poses.txt estimate.txt\n"
        "  evaluate_kitti -as poses.txt trajectory_final.tum --times times.txt --ref_frame camera "
        "--est_frame base",
    )
    add_input_options(parser)
    add_output_options(parser, with_plot=False)
    arguments = parser.parse_args(argv)
    settings = settings_of(arguments)
    reference = sources.read_reference(arguments.reference, arguments.format, arguments.times, arguments.bag)
    records, poses = [], 0
    rows = [["estimate", "length m", "count", "translation %", "rotation deg/100m", "coverage"]]
    for estimate in sources.read_estimates(
        arguments.estimates, arguments.format, arguments.times, arguments.bag
    ):
        compared = comparison.compare(reference, estimate, settings, needs_body=True)
        tell_collapse(estimate.name, compared.alignment)
        poses = max(poses, len(compared.reference))
        drift = metrics.kitti_drift(compared.reference, compared.estimate)
        average = metrics.kitti_average(drift)
        records.append(
            {
                "estimate": estimate.name,
                "coverage": compared.coverage,
                "scale": compared.alignment.scale,
                "lengths": drift,
                "average": average,
            }
        )
        for row in drift + [dict(average, length_m="average", count=sum(row["count"] for row in drift))]:
            rows.append(
                [
                    estimate.name,
                    str(row["length_m"]),
                    str(row["count"]),
                    f"{row['translation_percent']:.6g}",
                    f"{row['rotation_deg_per_100m']:.6g}",
                    f"{100 * compared.coverage:.1f} %",
                ]
            )
    print(f"KITTI drift, {settings.describe(poses)}")
    print(format_table(rows))
    if arguments.save_results:
        write_json(
            arguments.save_results,
            {
                "metric": "kitti",
                "reference": reference.name,
                "settings": asdict(settings),
                "results": records,
            },
        )
