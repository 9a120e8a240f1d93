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
    parser.add_argument("--tolerance", type=int, default=1, help="images that a right answer may be off (default 1)")
    parser.add_argument("--descriptor", help="vt_descriptor: blocks, orientation")
    parser.add_argument("--recall", help="vt_recall: nearest, belief")
    parser.add_argument("--config", help="configuration with crop and view")
    parser.add_argument("--truth", help="one recording: its true poses, KITTI format")
    parser.add_argument("--radius", type=finite, default=3.0, help="distance of a right place [m] (default 3)")
    parser.add_argument("--min-gap", type=int, default=100, help="frames that a revisit lies apart (default 100)")
    parser.add_argument("--open", action="store_true", help="map, and judge what the system itself recalls")
    parser.add_argument("--starts", type=int, metavar="N", help="wake up at so many images of QUERY without knowing where")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="overrides the configuration")
    parser.add_argument("--plot", type=plotting.picture_file, help="file for the precision-recall curve")
    parser.add_argument("--csv", help="keep the answers in this file")
    arguments = parser.parse_args(argv)
    _require_sense(arguments)
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
    if arguments.radius <= 0.0:
        raise InputError(f"--radius: {arguments.radius:g} is not allowed: above 0 m")
    if arguments.query is None and arguments.truth is None:
        raise InputError("one recording needs --truth FILE; two passes of one route need none")
    if arguments.query is not None and arguments.truth is not None:
        raise InputError(f"--truth: {arguments.truth} has no effect: of two passes the images belong together by their order")
    if arguments.starts is not None and (arguments.query is None or arguments.open):
        raise InputError("--starts: it needs a second pass, and has no effect with --open")
    if arguments.plot and (arguments.open or arguments.starts is not None):
        raise InputError("--plot: with --open and --starts there is no curve")
    for option, path in (("--csv", arguments.csv), ("--plot", arguments.plot)):
        text_file.require_other(option, path, [arguments.ref, arguments.query, arguments.config, arguments.truth])
    text_file.require_other("--csv", arguments.csv, _files_of(arguments.ref) + _files_of(arguments.query))


def _files_of(recording):
    """The files in a recording's folder."""
    return [os.path.join(recording, name) for name in os.listdir(recording)] if recording and os.path.isdir(recording) else []


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
    done = subprocess.run(command, stderr=subprocess.PIPE, text=True, check=False)
    if done.returncode != 0:
        raise InputError(done.stderr.strip() or f"{command[0]} failed")
    sys.stderr.write(done.stderr)  # its report on images that were left out
    table = np.loadtxt(out, delimiter=",", skiprows=1, ndmin=2)
    if len(table) == 0:
        raise InputError(f"{arguments.ref}: no image was answered")
    return table


def _answers(table):
    """The Answers in the columns frame, place, score, claimed of a table (n, 4 or more)."""
    return places.Answers(table[:, 0].astype(int), table[:, 1].astype(int), table[:, 2], table[:, 3] > 0)


def _count(path):
    """Number of images of a pass."""
    if not os.path.isdir(path):
        return bags.image_count(path)
    if recorder.is_recording(path):
        return len(recorder.read(path).images)
    folders = (os.path.join(path, name) for name in ("image_0", "images"))
    return len(images.list_images(next(filter(os.path.isdir, folders), path)))


def _report_open(arguments, answers, until, poses):
    """Reports the system's own recalls of places that were not active just before. A place is right for all images
    during which it was active when it was learned: a train that stands at a station learns one place there.
    """
    recalls = answers.claimed & (answers.frame - answers.place >= arguments.min_gap)
    if poses is not None:
        right, possible = places.by_truth(answers, *poses, arguments.radius, arguments.min_gap)
    else:
        first = _count(arguments.ref)
        possible = answers.frame >= first
        asked = answers.frame - first
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
    print(f"frames until the claim: median {np.median(needed):.0f}, 90 %: {np.percentile(needed, 90):.0f}")


def _percent(part, whole):
    return f"{100.0 * part / whole:.1f} %" if whole else "-"


def _report(arguments, answers, poses):
    if poses is None:
        right, possible = places.by_index(answers, arguments.tolerance)
    else:
        right, possible = places.by_truth(answers, *poses, arguments.radius, arguments.min_gap)
    scores = places.score(answers, right, possible)
    print(f"questions with a right place: {scores.questions} of {len(answers.frame)}")
    print(f"right at rank 1:              {100 * scores.right_at_1:.1f} %")
    print(f"area under the curve:         {100 * scores.auc:.1f} %")
    print(f"recall at 100 % precision:    {100 * scores.recall_at_100:.1f} %")
    print(f"recall at 99 % precision:     {100 * scores.recall_at_99:.1f} %")
    print(f"claimed: {scores.claimed}, of these right: {_percent(scores.claimed_right, scores.claimed)}")
    if arguments.plot:
        label = f"{arguments.descriptor or 'configured'}, {arguments.recall or 'recall'}"
        pyplot = plotting.load()
        plotting.finish(pyplot, places.figure({label: scores}, pyplot), arguments.plot)


def main(argv=None):
    arguments = _arguments(argv)
    poses = None if arguments.truth is None else read_plane_poses(arguments.truth)
    with tempfile.TemporaryDirectory() as folder:
        table = _ask(arguments, arguments.csv or os.path.join(folder, "answers.csv"))
    if poses is not None and len(poses[0]) <= table[:, 0].max():
        raise InputError(f"{arguments.truth}: {len(poses[0])} poses; {arguments.ref} has at least {table[:, 0].max() + 1:.0f} images")
    if arguments.starts:
        _report_starts(arguments, table)
    elif arguments.open:
        _report_open(arguments, _answers(table), table[:, 4].astype(int), poses)
    else:
        _report(arguments, _answers(table), poses)
    return 0
