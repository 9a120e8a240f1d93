"""reproduce_paper: the table and Figures 5, 6 and 7 of the source paper, from KITTI sequences.

Malichev & Yakhno, Biomorphic navigation system version, Izvestiya VUZ. Applied Nonlinear Dynamics 32(5),
2024.
1. Both systems run over each sequence: RatSLAM with its profile odometry, and with the ORB odometry in its
place.
2. APE and RPE of the final trajectories, aligned by similarity, stand beside the published ones.
3. Fig. 5: both trajectories coloured by APE. Fig. 6, 7: mean APE over the injected energy and over the pose
cells' size.
"""

import argparse
import os
from dataclasses import dataclass

from ratslam_tools import evaluation, plotting, text_file
from ratslam_tools.datasets import flat_yaml, kitti, truth
from ratslam_tools.evaluation import comparison, error_plots, metrics
from ratslam_tools.runs import grid, run_folder, runner
from ratslam_tools.errors import InputError, require_effect
from ratslam_tools.table import format_table


@dataclass(frozen=True)
class System:
    """One of the two systems that the paper compares."""

    name: str
    title: str
    config: str
    odometry: str


SYSTEMS = (
    System("profile", "RatSLAM (profile odometry)", "kitti.yaml", "profile"),
    System("orb", "modified (ORB odometry)", "kitti_orb.yaml", "orb"),
)
FIGURES = ("max", "mean", "median", "min")
# Published for sequence 00, in metres.
PUBLISHED = {
    ("profile", "APE"): (98.51, 39.81, 35.81, 0.57),
    ("orb", "APE"): (42.17, 19.68, 19.90, 6.03),
    ("profile", "RPE"): (5.38, 1.75, 1.58, 0.05),
    ("orb", "RPE"): (8.17, 2.83, 2.57, 0.17),
}
PUBLISHED_SEQUENCE = "00"
SWEEPS = (("fig6", "pc_vt_inject_energy"), ("fig7", "pc_cell_x_size"))
# The options that give the values of these sweeps, and their defaults.
SWEPT = {
    "inject_energy": "0.01,0.02,0.05,0.1,0.15,0.2,0.3,0.5,1,2,5",
    "cell_size": "0.25,0.5,1,1.5,2,2.5,3,4,6,8,12",
}


def sequence_names(words) -> list:
    """The sequences that --sequences names, in whichever way: `00 02` or `00,02`. @throws InputError if one is empty"""
    names = [name for word in words or () for name in word.split(",")]
    if not all(names):
        raise InputError(f"--sequences: '{' '.join(words)}' is not allowed: names such as 00 02 or 00,02")
    return list(dict.fromkeys(names))


def sequence_folders(folder: str, names) -> list:
    """(name, folder) of the sequences: those of the benchmark's root, or the one sequence that `folder`
    itself is.
    """
    if os.path.isfile(os.path.join(folder, "times.txt")):
        if names:
            raise InputError(f"--sequences: {folder} is one sequence itself; leave the option out")
        return [(os.path.basename(os.path.abspath(folder)), folder)]
    if not names:
        raise InputError(f"{folder}: no times.txt: not a sequence; for the benchmark's root give --sequences")
    folders = [(name, os.path.join(folder, "sequences", name)) for name in names]
    for name, path in folders:
        if not os.path.isfile(os.path.join(path, "times.txt")):
            raise InputError(f"--sequences: {name}: no {path}/times.txt")
    return folders


class Reproduction:
    """The runs and figures of one sequence."""

    def __init__(self, name: str, folder: str, arguments, program: str):
        self.name, self.folder, self.arguments, self.program = name, folder, arguments, program
        self.out = os.path.join(arguments.out, name)
        if kitti.poses_file(folder) is None:
            raise InputError(
                f"{folder}: no poses.txt, and none in ../../poses: there is no truth to compare with"
            )
        self.truth = truth.read_truth(folder)

    def words(self, system: System, settings, out: str, odometry: str):
        """The command line of one run of a system."""
        config = runner.find_config(system.config, self.arguments.config_dir)
        return runner.command(
            self.program, self.folder, config, out, settings, odometry, self.arguments.max_frames
        )

    def folder_of(self, system: System) -> str:
        """Folder of a system's run with its configuration. Runs it if there is none yet."""
        out = os.path.join(self.out, system.name)
        return runner.run_once(self.words(system, {}, out, system.odometry), out)

    def run(self, system: System) -> dict:
        """Runs a system, unless the same command has finished before, and evaluates its final trajectory."""
        final = run_folder.Run(self.folder_of(system)).final
        final.name = system.title
        settings = comparison.Settings(align=True, correct_scale=True, ref_frame="base", est_frame="base")
        return {
            "APE": evaluation.evaluate_ape(self.truth, [final], settings)[0],
            "RPE": evaluation.evaluate_rpe(self.truth, [final], settings)[0],
        }

    def sweep(self, system: System, figure: str, key: str, values) -> list:
        """The figure of mean APE over one parameter. Returns the messages of the runs that failed."""
        folder = os.path.join(self.out, f"sweep_{system.name}_{key}")
        odometry = system.odometry
        if runner.odometry_can_be_shared(odometry, [key]):
            odometry = runner.shared_odometry(self.folder_of(system), odometry)
        points, found, failures = grid.execute(
            lambda settings, out: self.words(system, settings, out, odometry),
            [(key, values)],
            folder,
            self.truth,
            jobs=self.arguments.jobs,
        )
        path = os.path.join(self.arguments.out, f"{figure}_{self.name}_{system.name}.png")
        config = runner.find_config(system.config, self.arguments.config_dir)
        in_use = flat_yaml.read(config).get(key)
        grid.plot_parameter(path, key, points, found, mark=None if in_use is None else float(in_use))
        print(f"wrote {path}")
        return failures


def table_rows(name: str, results: dict) -> list:
    """Rows of the paper's table for one sequence; the published figures where they are of this sequence."""
    rows = []
    for metric in ("APE", "RPE"):
        for system in SYSTEMS:
            result = results[system.name][metric]
            figures = metrics.statistics(result.errors)
            coverage = f"{100 * result.compared.coverage:.1f} %"
            rows.append([name, metric, system.title, *(f"{figures[key]:.2f}" for key in FIGURES), coverage])
            if metric == "APE" and result.ground_errors is not None:
                ground = metrics.statistics(result.ground_errors)
                rows.append(
                    ["", "", "  on the ground plane", *(f"{ground[key]:.2f}" for key in FIGURES), coverage]
                )
            published = PUBLISHED[system.name, metric]
            rows.append(
                [
                    "",
                    "",
                    f"  published (sequence {PUBLISHED_SEQUENCE})",
                    *(f"{value:.2f}" for value in published),
                    "",
                ]
            )
    return rows


NOTE = (
    "Final trajectories, aligned by rotation, translation and scale; metres. RPE over one frame, both in "
    "base axes; the\n"
    "published RPE compares poses of different body axes, which adds about sqrt(2) times the step to every "
    "pair."
)


def swept_values(option: str, text) -> list:
    """The values of a sweep, which are numbers; None: the usual ones. @throws InputError"""
    text = SWEPT[option] if text is None else text
    values = grid.parse_values(f"--{option}", text, text)
    for value in values:
        try:
            text_file.finite_number(value)
        except ValueError as error:
            raise InputError(f"--{option}: {error}") from None
    return values


def main(argv=None) -> None:
    """reproduce_paper."""
    parser = argparse.ArgumentParser(
        prog="reproduce_paper",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        description="The paper's table beside its published figures, and its Fig. 5, 6 and 7, from KITTI "
        "sequences. Started "
        "again after an interruption, it computes only what is missing.",
        epilog="examples:\n  reproduce_paper dataset/sequences/00 --out out/paper\n"
        "  reproduce_paper dataset --sequences 00 02 --out out/paper --skip_sweeps",
    )
    parser.add_argument(
        "folder", metavar="KITTI_FOLDER", help="one sequence, or the benchmark's root (sequences/, poses/)"
    )
    parser.add_argument("--sequences", nargs="+", metavar="NN", help="sequences of the root, also as NN,NN")
    parser.add_argument("--out", required=True, metavar="DIR", help="folder for runs, table.txt and figures")
    parser.add_argument("--max-frames", type=int, metavar="N", help="only the first N frames")
    parser.add_argument(
        "--skip_sweeps", action="store_true", help="leave out Fig. 6 and 7, which take most of the time"
    )
    parser.add_argument(
        "--sweep_systems",
        nargs="+",
        choices=[system.name for system in SYSTEMS],
        help="systems whose parameters are swept (default: orb)",
    )
    parser.add_argument(
        "--inject_energy",
        metavar="VALUES",
        help=f"values of Fig. 6 (default {SWEPT['inject_energy']})",
    )
    parser.add_argument(
        "--cell_size",
        metavar="VALUES",
        help=f"values of Fig. 7 (default {SWEPT['cell_size']})",
    )
    parser.add_argument(
        "--jobs", type=int, metavar="N", help="runs at a time in the sweeps (default: one for each core)"
    )
    parser.add_argument(
        "--config_dir",
        metavar="DIR",
        help="folder with kitti.yaml and kitti_orb.yaml, if not the shipped one",
    )
    parser.add_argument("--ratslam_run", metavar="FILE", help="the program, if it is not found by itself")
    arguments = parser.parse_args(argv)
    runner.require_apart(arguments.out, arguments.folder)
    swept = ("sweep_systems", "inject_energy", "cell_size", "jobs")
    given = {name: getattr(arguments, name) for name in swept}
    require_effect(not arguments.skip_sweeps, "there are no sweeps with --skip_sweeps", **given)
    if arguments.jobs is not None and arguments.jobs < 1:
        raise InputError(f"--jobs: {arguments.jobs} is not allowed: at least 1")
    systems = arguments.sweep_systems or ["orb"]
    values = {key: swept_values(option, given[option]) for (_, key), option in zip(SWEEPS, SWEPT)}
    program = runner.find(arguments.ratslam_run)
    reproductions = [
        Reproduction(name, folder, arguments, program)
        for name, folder in sequence_folders(arguments.folder, sequence_names(arguments.sequences))
    ]
    rows = [["sequence", "metric", "system", *FIGURES, "coverage"]]
    pyplot = plotting.load()
    for reproduction in reproductions:
        results = {system.name: reproduction.run(system) for system in SYSTEMS}
        rows += table_rows(reproduction.name, results)
        figure = error_plots.errors_figure(
            pyplot,
            [results[system.name]["APE"] for system in SYSTEMS],
            f"APE on {reproduction.name}",
            "APE [m]",
        )
        plotting.finish(pyplot, figure, os.path.join(arguments.out, f"fig5_{reproduction.name}.png"))
    text = f"{format_table(rows)}\n\n{NOTE}"
    print(text)
    with text_file.writing(os.path.join(arguments.out, "table.txt")) as file:
        file.write(text + "\n")
    failures = []
    if not arguments.skip_sweeps:
        for reproduction in reproductions:
            for system in SYSTEMS:
                if system.name in systems:
                    for figure, key in SWEEPS:
                        failures += reproduction.sweep(system, figure, key, values[key])
    if failures:
        raise InputError(f"{len(failures)} runs of the sweeps failed; the first: {failures[0]}")
