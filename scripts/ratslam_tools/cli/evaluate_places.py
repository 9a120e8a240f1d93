"""evaluate_places: quality of place recognition."""

import argparse
import os
import subprocess
import sys
import tempfile

import numpy as np

from ratslam_tools import plotting, text_file
from ratslam_tools.datasets import bags, images, recorder
from ratslam_tools.datasets.truth import read_plane_poses
from ratslam_tools.errors import InputError, finite
from ratslam_tools.evaluation import places
from ratslam_tools.runs import runner

EXAMPLES = """\
examples:
  evaluate_places nordland/summer nordland/winter --descriptor orientation --recall belief
  evaluate_places kitti_00 --truth kitti_00/poses.txt --radius 3 --min-gap 100 --config config/kitti_orb.yaml
  evaluate_places nordland/summer nordland/winter --config my.yaml --open
  evaluate_places nordland/summer nordland/winter --config my.yaml --starts 300
"""


def _arguments(argv):
    parser = argparse.ArgumentParser(
        description="Recall at rank 1, precision and recall of place recognition.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("ref", help="pass to learn, or the only recording: images, a KITTI sequence or a bag")
    parser.add_argument("query", nargs="?", help="pass of the same route to ask with, image for image")
    parser.add_argument("--tolerance", type=int, help="two passes: images that a right answer may be off (default 1)")
    parser.add_argument("--descriptor", help="vt_descriptor: blocks, orientation")
    parser.add_argument("--recall", help="vt_recall: nearest, belief")
    parser.add_argument("--config", help="configuration with crop and view")
    parser.add_argument("--truth", help="one recording: its true poses, KITTI format or a bag's ground_truth")
    parser.add_argument("--radius", type=finite, help="with --truth: distance of a right place [m] (default 3)")
    parser.add_argument("--min-gap", type=int, help="one recording: frames that a revisit lies apart (default 100)")
    parser.add_argument("--open", action="store_true", help="map, and judge what the system itself recalls")
    parser.add_argument("--starts", type=int, metavar="N", help="wake up at so many images of QUERY without knowing where")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="overrides the configuration")
    parser.add_argument("--plot", type=plotting.picture_file, help="file for the precision-recall curve")
    parser.add_argument("--csv", help="keep the answers in this file")
    arguments = parser.parse_args(argv)
    _require_sense(arguments)
    for name, value in (("tolerance", 1), ("radius", 3.0), ("min_gap", 100)):
        if getattr(arguments, name) is None:
            setattr(arguments, name, value)
    return arguments


def _require_sense(arguments):
    """Refuses options out of range, and those that would have no effect. @throws InputError"""
    for option, value, least in (
        ("--tolerance", arguments.tolerance, 0),
        ("--min-gap", arguments.min_gap, 1),
        ("--starts", arguments.starts, 1),
    ):
        if value is not None and value < least:
            raise InputError(f"{option}: {value} is not allowed: at least {least}")
    if arguments.radius is not None and arguments.radius <= 0.0:
        raise InputError(f"--radius: {arguments.radius:g} is not allowed: above 0 m")
    if arguments.query is None and arguments.truth is None:
        raise InputError("one recording needs --truth FILE; two passes of one route need none")
    if arguments.query is not None and arguments.truth is not None:
        raise InputError(f"--truth: {arguments.truth} has no effect: of two passes the images belong together by their order")
    if arguments.tolerance is not None and arguments.query is None:
        raise InputError(f"--tolerance: {arguments.tolerance} has no effect: of one recording --radius says what is right")
    if arguments.radius is not None and arguments.truth is None:
        raise InputError(f"--radius: {arguments.radius:g} has no effect: of two passes --tolerance says what is right")
    if arguments.min_gap is not None and arguments.query is not None:
        raise InputError(f"--min-gap: {arguments.min_gap} has no effect: of two passes the second revisits the first")
    if arguments.starts is not None and (arguments.query is None or arguments.open):
        raise InputError("--starts: it needs a second pass, and has no effect with --open")
    if arguments.plot and (arguments.open or arguments.starts is not None):
        raise InputError("--plot: with --open and --starts there is no curve")
    chosen = [key for key, value in (("vt_descriptor", arguments.descriptor), ("vt_recall", arguments.recall)) if value]
    runner.require_not_set(chosen, [f"--set={assignment}" for assignment in arguments.set])
    text_file.require_other("--plot", arguments.plot, [arguments.csv], "written")
    read = [*text_file.files_of(arguments.ref), *text_file.files_of(arguments.query), arguments.config, arguments.truth]
    for option, path in (("--csv", arguments.csv), ("--plot", arguments.plot)):
        text_file.require_other(option, path, read)


def _ask(arguments, out):
    """Runs ratslam_places, which writes the CSV file `out`. Returns its rows as an array, one for each answer; the columns
    are those of the file. @throws InputError if it fails or gives no answer."""
    command = [os.path.join(os.path.dirname(runner.find()), "ratslam_places"), arguments.ref, "--out", out]
    if arguments.query:
        command.insert(2, arguments.query)
    for key, value in (("vt_descriptor", arguments.descriptor), ("vt_recall", arguments.recall)):
        if value:
            command += ["--set", f"{key}={value}"]
    for assignment in arguments.set:
        command += ["--set", assignment]
    if arguments.config:
        command += ["--config", arguments.config]
    if arguments.open:
        command.append("--open")
    elif arguments.starts:
        command += ["--starts", str(arguments.starts)]
    elif not arguments.query:
        command += ["--min-gap", str(arguments.min_gap)]
    done = subprocess.run(command, stderr=subprocess.PIPE, check=False)
    told = done.stderr.decode("utf-8", "surrogateescape")
    if done.returncode != 0:
        raise InputError(told.strip() or f"{command[0]} failed")
    sys.stderr.write(told)  # what it says of images that were left out
    with open(out, encoding="utf-8") as file:
        head, *rows = file.read().splitlines()
    return np.array([[float(word) for word in row.split(",")] for row in rows]).reshape(len(rows), head.count(",") + 1)


def _answers(table):
    """The Answers in the columns frame, place, score, claimed of a table (n, 4 or more)."""
    return places.Answers(table[:, 0].astype(int), table[:, 1].astype(int), table[:, 2], table[:, 3] > 0)


def _images(path):
    """The image files of a pass; None of a bag."""
    if not os.path.isdir(path):
        return None
    if recorder.is_recording(path):
        return recorder.read_images(path)
    folders = (os.path.join(path, name) for name in ("image_0", "images"))
    return images.list_images(next(filter(os.path.isdir, folders), path))


def _count(path):
    """Number of images of a pass."""
    files = _images(path)
    return bags.image_count(path) if files is None else len(files)


def _true_poses(path, recording):
    """Positions and headings of the recording's images. The numbers in the images' names decide which poses are theirs if
    there are more poses, as ratslam_run decides about times. @throws InputError if it is not clear
    """
    positions, headings = read_plane_poses(path)
    files, count = _images(recording), _count(recording)
    if files is None and len(positions) != count:
        raise InputError(f"{path}: {len(positions)} poses for {count} images of {recording}: which pose is whose is not clear")
    rows = range(count) if files is None else images.times_of(files, len(positions), path, "pose")
    if len(positions) > count:
        told = "each image takes the pose of the number in its name"
        print(f"note: {path}: {len(positions)} poses for {count} images: {told}", file=sys.stderr)
    return positions[rows], headings[rows]


def _tell_lengths(arguments, learned, asked):
    """Tells if two passes have not the same number of images."""
    if learned != asked:
        told = "images belong together by their order, those beyond the shorter pass have no counterpart"
        print(f"note: {arguments.ref} has {learned} images and {arguments.query} {asked}: {told}", file=sys.stderr)


def _report_open(arguments, answers, until, poses, learned):
    """Reports the system's own recalls of places that were not active just before: of one recording those whose stay, in which
    they were learned, ended --min-gap images ago, of two passes those of the second pass. A place is right for all images
    during which it was active when it was learned: a train that stands at a station learns one place there.
    """
    if poses is not None:
        recalls = answers.claimed & (answers.frame - until >= arguments.min_gap)
        right, _ = places.by_truth(answers, *poses, arguments.radius, arguments.min_gap)
        possible = places.revisits(answers.frame, *poses, arguments.radius, arguments.min_gap)
    else:
        asked = answers.frame - learned
        recalls = answers.claimed & (asked >= 0) & (answers.frame > until + arguments.tolerance)
        possible = (asked >= 0) & (asked - arguments.tolerance < learned)
        right = (asked >= answers.place - arguments.tolerance) & (asked <= until + arguments.tolerance)
    right = right & recalls
    print(f"frames that revisit a place: {possible.sum()}")
    print(f"recalls: {recalls.sum()}, of these right: {right.sum()} ({_percent(right.sum(), recalls.sum())})")
    print(f"revisiting frames recalled: {_percent((recalls & possible).sum(), possible.sum())}")
    print(f"recalls where nothing is revisited: {(recalls & ~possible).sum()}")


def _report_starts(arguments, table):
    frames = table[:, 1].astype(int)
    right = np.abs(table[:, 2].astype(int) - frames) <= arguments.tolerance
    needed = frames - table[:, 0].astype(int) + 1
    print(f"starts: {arguments.starts}, places claimed: {len(table)}, of these right: {right.sum()}")
    if len(needed):
        print(f"frames until the claim: median {np.median(needed):.0f}, 90 %: {np.percentile(needed, 90):.0f}")


def _percent(part, whole):
    return f"{100.0 * part / whole:.1f} %" if whole else "-"


def _report(arguments, answers, poses, learned):
    if poses is None:
        right, possible = places.by_index(answers, arguments.tolerance, learned)
    else:
        right, possible = places.by_truth(answers, *poses, arguments.radius, arguments.min_gap)
    scores = places.score(answers, right, possible)
    print(f"questions with a right place: {scores.questions} of {len(answers.frame)}")
    for name, share in (
        ("right at rank 1:", scores.right_at_1),
        ("area under the curve:", scores.auc),
        ("recall at 100 % precision:", scores.recall_at_100),
        ("recall at 99 % precision:", scores.recall_at_99),
    ):
        print(f"{name:29} {_percent(share, min(scores.questions, 1))}")
    print(f"claimed: {scores.claimed}, of these right: {_percent(scores.claimed_right, scores.claimed)}")
    if not scores.questions:
        raise InputError(
            f"{arguments.ref}: none of its {len(answers.frame)} images has a right place, within --radius {arguments.radius:g} m "
            f"and --min-gap {arguments.min_gap} frames earlier: there is nothing to recall"
        )
    if arguments.plot:
        label = f"{arguments.descriptor or 'configured'}, {arguments.recall or 'recall'}"
        pyplot = plotting.load()
        plotting.finish(pyplot, places.figure({label: scores}, pyplot), arguments.plot)


def main(argv=None):
    arguments = _arguments(argv)
    for option, path in (("--csv", arguments.csv), ("--plot", arguments.plot)):
        if path and os.path.exists(path):
            files = [file for each in (arguments.ref, arguments.query) if each for file in _images(each) or ()]
            text_file.require_other(option, path, files)
    poses = None if arguments.truth is None else _true_poses(arguments.truth, arguments.ref)
    learned, asked = (_count(path) if poses is None else 0 for path in (arguments.ref, arguments.query))
    if arguments.starts is not None and arguments.starts > asked:
        raise InputError(f"--starts: {arguments.starts} is not allowed: {arguments.query} has {asked} images to start at")
    with tempfile.TemporaryDirectory() as folder:
        table = _ask(arguments, arguments.csv or os.path.join(folder, "answers.csv"))
    _tell_lengths(arguments, learned, asked)
    if arguments.starts:
        _report_starts(arguments, table)
    elif arguments.open:
        _report_open(arguments, _answers(table), table[:, 4].astype(int), poses, learned)
    else:
        _report(arguments, _answers(table), poses, learned)
    return 0
