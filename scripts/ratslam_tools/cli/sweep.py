"""sweep: ratslam_run over a grid of parameters, with the figures of merit of each run and a plot for each
parameter."""

import argparse
import os
import sys

from ratslam_tools.cli.plot_run import add_truth_options, complete_truth_options
from ratslam_tools.datasets import truth
from ratslam_tools.errors import InputError, require_effect
from ratslam_tools.runs import grid, runner, shards


def main(argv=None) -> None:
    """sweep."""
    parser = argparse.ArgumentParser(
        prog="sweep",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Runs ratslam_run over a grid of parameters; writes sweep.csv (errors, counts and times of every run) "
        "and the goal over each parameter. "
        "ORB odometry is computed once where no varied parameter can change it. "
        "Started again after an interruption, it computes only what is missing. " + runner.PASSED_ON,
        epilog="examples:\n  sweep dataset/sequences/00 --config config/kitti.yaml --truth "
        "dataset/sequences/00 \\\n"
        "        --vary pc_vt_inject_energy=0.05:0.5:0.05 --out out/inject\n"
        "  sweep drive.bag --config config/kitti.yaml --truth drive.bag --vary pc_cell_x_size=0.5,1,2,4 \\\n"
        "        --vary vt_match_threshold=0.03,0.04,0.05 --jobs 2 --out out/grid\n"
        "  sweep drive.bag --config my.yaml --vary vt_match_threshold=0.02:0.1:0.01 --goal counts.recalls --largest \\\n"
        "        --out out/recalls\n"
        "on four machines that share a folder, then together:\n"
        "  sweep drive.bag --config my.yaml --truth drive.bag --vary pc_cell_x_size=0.5:4:0.5 --out out/grid --shard 1/4\n"
        "  sweep --vary pc_cell_x_size=0.5:4:0.5 --out out/grid --merge out/grid",
    )
    parser.add_argument("input", nargs="?", metavar="INPUT", help="bag or KITTI sequence folder, as for ratslam_run")
    parser.add_argument("--config", metavar="FILE", help="configuration the varied keys are set on top of")
    add_truth_options(parser)
    parser.add_argument(
        "--vary",
        action="append",
        required=True,
        metavar="KEY=VALUES",
        help="start:stop:step (stop included) or v1,v2,...; several make a grid",
    )
    parser.add_argument("--out", required=True, metavar="DIR", help="folder for runs, sweep.csv and figures")
    parser.add_argument(
        "--odometry", metavar="KIND", help="passed on: profile, topic, orb or an odometry CSV"
    )
    parser.add_argument("--max-frames", type=int, metavar="N", help="passed on: stop after so many frames")
    parser.add_argument("--jobs", type=int, metavar="N", help="runs at a time (default: one for each core)")
    parser.add_argument(
        "--goal",
        action="append",
        metavar="NAME",
        help="figure of sweep.csv that says how good a run is: ape.final.mean, counts.experiences, timing.odometry, "
        f"... (default: {grid.Goal().name})",
    )
    parser.add_argument("--largest", action="store_true", help="the largest goal is the best, not the smallest")
    division = parser.add_mutually_exclusive_group()
    division.add_argument(
        "--shard", metavar="K/N", help="compute only the Kth of N equal parts of the runs, for --merge later"
    )
    division.add_argument(
        "--merge", nargs="+", metavar="DIR", help="compute nothing: put together what shards left in these folders; "
        "takes only --vary, --out and --goal besides"
    )
    parser.add_argument("--keep", action="store_true", help="keep every run's files, not only its figures")
    parser.add_argument("--ratslam_run", metavar="FILE", help="the program, if it is not found by itself")
    own, more = runner.split(argv)
    arguments = parser.parse_args(own)
    arguments.more = more
    _require_sense(parser, arguments)
    complete_truth_options(arguments)
    if arguments.jobs is not None and arguments.jobs < 1:
        raise InputError(f"--jobs: {arguments.jobs} is not allowed: at least 1")
    if os.path.exists(arguments.out) and not os.path.isdir(arguments.out):
        raise InputError(f"--out: {arguments.out} is a file; a folder is needed")
    if not arguments.merge:
        runner.require_apart(arguments.out, arguments.input)
    varied = [grid.parse_vary(text) for text in arguments.vary]
    points = grid.grid(varied)
    runner.require_not_set([key for key, _ in varied], more)
    goal = _goal(arguments)
    if arguments.truth is None and goal.name.startswith("ape.") and not arguments.merge:
        raise InputError(f"--goal: {goal.name} needs --truth FILE; without the truth take another, such as counts.recalls")
    if arguments.merge:
        found, missing = shards.merge(arguments.merge, points)
        failures = [f"{name}: no shard has left it" for name in missing]
        if not found:
            raise InputError(f"--merge: none of the {len(points)} runs is in {', '.join(arguments.merge)}")
        grid.leave(arguments.out, varied, points, found, goal)
    else:
        found, failures = compute(arguments, varied, points, goal)
    if arguments.shard:
        print(f"shard {arguments.shard}: {len(found)} runs in {arguments.out}; put the shards together with --merge")
    else:
        tell_best(goal, points, found)
        print(f"wrote {os.path.join(arguments.out, 'sweep.csv')} and its figures")
    if failures:
        raise InputError(f"{len(failures)} of {len(points)} runs failed; the first: {failures[0]}")


def _goal(arguments) -> grid.Goal:
    """The goal asked for. @throws InputError for several"""
    names = arguments.goal or [grid.Goal().name]
    if len(names) > 1:
        raise InputError(
            f"--goal: {' and '.join(names)} are not allowed together: a sweep has one goal; started again with the other, it "
            "computes nothing anew"
        )
    return grid.Goal(names[0], arguments.largest)


def _require_parameters(program: str, config: str, varied, points) -> None:
    """Refuses names and values that are none before anything is computed. Whether a value is in range is for the runs to say,
    because it may depend on others. @throws InputError with ratslam_run's message"""
    for key, values in varied:
        for value in values:
            point = next(point for point in points if point[key] == value)
            found = runner.objection(program, config, point)
            if found and "(from the command line)" in found[1]:
                raise InputError(f"--vary: {found[1].replace(' (from the command line)', '')}")


def _require_sense(parser, arguments) -> None:
    """Refuses a sweep of nothing, and what has no effect with --merge. @throws InputError"""
    needed = [name for name, value in (("INPUT", arguments.input), ("--config", arguments.config)) if value is None]
    if needed and not arguments.merge:
        parser.error(f"the following arguments are required: {', '.join(needed)}")
    why = "--merge computes nothing, and takes what the runs have left"
    if arguments.merge and arguments.input is not None:
        raise InputError(f"INPUT: {arguments.input} has no effect: {why}")
    if arguments.merge and arguments.more:
        raise InputError(f"--: {' '.join(arguments.more)} has no effect: {why}")
    others = ("config", "truth", "times", "t_max_diff", "odometry", "max-frames", "jobs", "keep", "ratslam_run")
    given = {name: getattr(arguments, name.replace("-", "_")) for name in others}
    require_effect(not arguments.merge, why, **given)


def compute(arguments, varied, points, goal):
    """Runs the sweep or a shard of it. Returns the results by index of the point (dicts, name: number), and the messages of the
    runs that failed."""
    program = runner.find(arguments.ratslam_run)
    _require_parameters(program, arguments.config, varied, points)
    known = None if arguments.truth is None else truth.read_truth(arguments.truth, arguments.times)
    odometry = arguments.odometry

    def words_of(settings, folder, kind):
        return runner.command(
            program, arguments.input, arguments.config, folder, settings, kind, arguments.max_frames, arguments.more
        )

    if runner.odometry_can_be_shared(odometry, [key for key, _ in varied]):
        # Shards run at the same time, so each has its own file.
        name = "odometry" if not arguments.shard else "odometry_" + arguments.shard.replace("/", "_of_")
        folder = os.path.join(arguments.out, name)
        runner.run_once(words_of({}, folder, odometry), folder)
        odometry = runner.shared_odometry(folder, odometry)

    def words(settings, folder):
        return words_of(settings, folder, odometry)

    jobs = arguments.jobs or os.cpu_count() or 1
    if arguments.shard:
        part = shards.shard(points, arguments.shard)
        return grid.Sweep(words, part, arguments.out, known, arguments.t_max_diff, arguments.keep).run(jobs)
    _, found, failures = grid.execute(
        words, varied, arguments.out, known, arguments.t_max_diff, jobs, arguments.keep, goal
    )
    return found, failures


def tell_best(goal, points, found) -> None:
    """Prints the best run, or that all runs are equal."""
    values = goal.of(found)
    if len(values) < len(found):
        print(f"note: {len(found) - len(values)} of {len(found)} runs have no {goal.name} and are left out", file=sys.stderr)
    value, best = goal.best(found)
    coverage = found[best[0]].get("ape.final.coverage")
    told = f" (coverage {100 * coverage:.1f} %)" if goal.name.startswith("ape.final") and coverage is not None else ""
    settings = [", ".join(f"{key}={word}" for key, word in points[index].items()) for index in best]
    if len(best) == 1:
        print(f"{len(found)} of {len(points)} runs; best {goal.name} {value:.4g}{told} with {settings[0]}")
    elif len(best) == len(values):
        print(f"{len(found)} of {len(points)} runs; all have the same {goal.name}, {value:.4g}{told}: none is the best")
    else:
        print(f"{len(found)} of {len(points)} runs; {len(best)} share the best {goal.name}, {value:.4g}{told}:")
        print("\n".join(f"  {entry}" for entry in settings))
