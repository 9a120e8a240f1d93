"""trajectory_convert: converts TUM, KITTI, bag topics and GPS logs to TUM or KITTI, on request with a change of axes.
"""

import argparse
import sys

from ratslam_tools import text_file
from ratslam_tools.datasets import bags, recorder, sources
from ratslam_tools.trajectory import frames
from ratslam_tools.errors import InputError, finite, require_effect
from ratslam_tools.trajectory import has_stamps, read_trajectory, write_kitti, write_tum

MAX_ACCURACY_M = 20.0


def read_gps(path: str, max_accuracy: float):
    """The accurate fixes of a recorder's GPS log (file or folder) in East-North-Up."""
    recording = recorder.read_gps_log(path)
    for reason, count in sorted(recording.dropped.items()):
        print(f"note: {reason}: {count}", file=sys.stderr)
    rows = recorder.good_fixes(recording, max_accuracy)
    if not len(rows):
        raise InputError(
            f"{path}: none of its {len(recording.gps)} GPS fixes has a stated accuracy of {max_accuracy:g} m or better"
        )
    return recorder.gps_track(recording, rows)


def main(argv=None) -> None:
    """trajectory_convert."""
    parser = argparse.ArgumentParser(
        prog="trajectory_convert",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        description=__doc__,
        epilog="examples:\n  trajectory_convert poses.txt truth.tum --times times.txt --from_frame camera "
        "--to_frame base\n"
        "  trajectory_convert trajectory_final.tum final.kitti --to kitti --from_frame base --to_frame "
        "camera\n"
        "  trajectory_convert run.bag truth.tum --topic /kitti/ground_truth\n"
        "  trajectory_convert data_gps.txt gps.tum --from gps",
    )
    parser.add_argument("input", help="TUM or KITTI file, bag, or a recorder's GPS log")
    parser.add_argument("output", help="file to write")
    parser.add_argument(
        "--from",
        dest="source",
        choices=("auto", "tum", "kitti", "gps"),
        default="auto",
        help="form of the input (default: bags by --topic, files by columns)",
    )
    parser.add_argument(
        "--to", choices=("tum", "kitti"), default="tum", help="form of the output (default tum)"
    )
    parser.add_argument("--topic", metavar="NAME", help="topic of the bag")
    parser.add_argument("--times", metavar="FILE", help="times.txt that gives KITTI poses their stamps")
    parser.add_argument(
        "--save_times", metavar="FILE", help="write the stamps of a KITTI output, as times.txt"
    )
    parser.add_argument("--from_frame", choices=frames.FRAMES, help="convention of the input")
    parser.add_argument("--to_frame", choices=frames.FRAMES, help="convention of the output")
    parser.add_argument(
        "--max_accuracy", type=finite, metavar="M", help="worst GPS fix to take (default 20 m)"
    )
    arguments = parser.parse_args(argv)
    if (arguments.from_frame is None) != (arguments.to_frame is None):
        raise InputError("--from_frame and --to_frame: give both or neither")
    if arguments.topic is None and bags.is_bag(arguments.input):
        raise InputError(f"{arguments.input}: of a bag one topic is converted: --topic NAME")
    from_gps = arguments.source == "gps"
    require_effect(from_gps, "it is about a GPS log (--from gps)", max_accuracy=arguments.max_accuracy)
    kind = None if arguments.source == "auto" or arguments.topic is None else arguments.source
    require_effect(False, "--topic names poses of a bag", **{"from": kind})
    require_effect(
        arguments.times is None or not (arguments.topic or from_gps or has_stamps(arguments.input, arguments.source)),
        f"{arguments.input} has stamps of its own",
        times=arguments.times,
    )
    for option, path in (("output", arguments.output), ("--save_times", arguments.save_times)):
        text_file.require_other(option, path, [*text_file.files_of(arguments.input), arguments.times])
    text_file.require_other("--save_times", arguments.save_times, [arguments.output], "written")
    if arguments.topic is not None:
        trajectory = sources.read_topic(arguments.input, arguments.topic)
    elif from_gps:
        trajectory = read_gps(arguments.input, MAX_ACCURACY_M if arguments.max_accuracy is None else arguments.max_accuracy)
    else:
        trajectory = read_trajectory(arguments.input, arguments.source, arguments.times)
    if arguments.from_frame is not None:
        trajectory = frames.convert(trajectory, arguments.from_frame, arguments.to_frame)
    if arguments.save_times and trajectory.stamps is None:
        raise InputError(f"--save_times: {arguments.input} has no stamps")
    (write_tum if arguments.to == "tum" else write_kitti)(arguments.output, trajectory)
    if arguments.save_times:
        with text_file.writing(arguments.save_times) as file:
            file.writelines(f"{stamp:.9f}\n" for stamp in trajectory.stamps)
    print(f"{arguments.output}: {len(trajectory)} poses, {trajectory.path_length()[-1]:.6g} m")
