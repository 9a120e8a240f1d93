"""suggest_parameters: suggests crop, cell size, threshold and injection from the first minutes of a recording."""

import argparse
import os

from ratslam_tools import text_file
from ratslam_tools.datasets.odometry_file import read_odometry
from ratslam_tools.errors import InputError
from ratslam_tools.runs import run_folder, runner, suggestion


def lines_of(found) -> str:
    """The suggestion as YAML with its reasons."""
    lines = []
    for reason, settings in found:
        lines.append(f"# {reason}")
        lines += [f"{key}: {value}" for key, value in settings.items()]
    return "\n".join(lines) + "\n"


def suggest(runs, sampled: list) -> list:
    """List of (reason, settings) in the order of docs/tuning.md. @param sampled images as the runs see them"""
    found, settings = [], {}

    def add(reason, more):
        settings.update(more)
        found.append((reason, more))

    more = suggestion.crop(sampled)
    add("What changes and shows something." if more else "Crop: the whole image tells places apart.", more)
    first = runs(settings)
    odometry = read_odometry(os.path.join(first.folder, "odometry.csv"))
    cell = suggestion.cell_size(odometry[:, 1], odometry[:, 2])
    add(f"Scale: a cell is crossed in about {suggestion.FRAMES_A_CELL:g} frames.", {"pc_cell_x_size": f"{cell:g}"})
    key = suggestion.threshold_key(first)
    if key is None:
        add("Threshold: none is suggested, belief decides about recalls (vt_recall).", {})
    else:
        value, ratio = suggestion.threshold(runs, settings, key)
        add(f"Threshold: {ratio:.2f} experiences a template (between 1 and 2 is wanted).", {key: value})
    energy = suggestion.injection(runs, settings)
    if energy is None:
        add("Injection: no loop closed in these images; the default stays. Try some that come back to where they have been.", {})
    else:
        add("Injection: the least energy with which the map follows the views that come back.", {"pc_vt_inject_energy": energy})
    return found


def main(argv=None) -> None:
    """suggest_parameters."""
    parser = argparse.ArgumentParser(
        prog="suggest_parameters",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Proposes image crop, cell size, template threshold and injected energy for a recording, by runs over "
        "its first minutes, and prints them as YAML with the reasons. docs/tuning.md explains them. " + runner.PASSED_ON,
        epilog="examples:\n  suggest_parameters drive.bag --config robot.yaml --odometry topic > found.yaml\n"
        "  suggest_parameters dataset/sequences/00 --config config/kitti.yaml --out out/tuning",
    )
    parser.add_argument("input", metavar="INPUT", help="bag, KITTI sequence or recorder folder, as for ratslam_run")
    parser.add_argument("--config", required=True, metavar="FILE", help="configuration to start from")
    parser.add_argument("--odometry", metavar="KIND", help="passed on: profile, topic, orb or an odometry CSV")
    parser.add_argument("--frames", type=int, default=1800, metavar="N", help="images looked at (default: %(default)s)")
    parser.add_argument("--out", default="out/tuning", metavar="DIR", help="folder for the runs (default: %(default)s)")
    parser.add_argument("--yaml", metavar="FILE", help="write the suggestion here, not to stdout")
    parser.add_argument("--ratslam_run", metavar="FILE", help="the program, if it is not found by itself")
    own, more = runner.split(argv)
    arguments = parser.parse_args(own)
    if arguments.frames < 10:
        raise InputError(f"--frames: {arguments.frames} is not allowed: at least 10")
    runner.require_apart(arguments.out, arguments.input)
    runner.require_not_set(suggestion.KEYS, more)
    text_file.require_other(
        "--yaml", arguments.yaml, [*text_file.files_of(arguments.input), arguments.config, arguments.odometry]
    )
    program = runner.find(arguments.ratslam_run)
    odometry = [arguments.odometry]

    def runs(settings):
        """The run folder (run_folder.Run) of the recording with these settings (parameter: value), which is made if it is
        missing."""
        name = "_".join(f"{key}={value}" for key, value in sorted(settings.items())) or "first"
        folder = os.path.join(arguments.out, name)
        words = runner.command(
            program, arguments.input, arguments.config, folder, settings, odometry[0], arguments.frames, more
        )
        run = run_folder.Run(runner.run_once(words, folder))
        if odometry[0] == "orb":  # the settings do not change it
            odometry[0] = runner.shared_odometry(folder, odometry[0])
        return run

    sampled = suggestion.sample_images(arguments.input, arguments.frames, view=suggestion.View.of_options(more))
    text = lines_of(suggest(runs, sampled))
    if arguments.yaml is None:
        print(text, end="")
        return
    with text_file.writing(arguments.yaml) as file:
        file.write(text)
    print(f"wrote {arguments.yaml}")
