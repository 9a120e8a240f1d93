"""sweep: ratslam_run over a grid of parameters, the error of each run, and its figure over each parameter.

Every finished run leaves a folder with `result.json`; a sweep that was interrupted goes on where it stopped.
"""

import argparse
import csv
import itertools
import json
import os
import shutil
from concurrent.futures import ThreadPoolExecutor, as_completed
from typing import Dict, List, Tuple

import numpy as np

from ratslam_tools import evaluation, plotting
from ratslam_tools.datasets import truth
from ratslam_tools.evaluation import metrics
from ratslam_tools.runs import run_figures, runner
from ratslam_tools.errors import InputError
from ratslam_tools.cli.plot_run import add_truth_options
from ratslam_tools.progress import Progress
from ratslam_tools.runs.run_folder import Run

MAX_RUNS = 10000
RESULT = "result.json"
LOG_SPAN = 20  # values that span more than this factor stand on a logarithmic axis
FIGURES = ("max", "mean", "median", "min", "rmse")


def parse_vary(text: str) -> Tuple[str, List[str]]:
    """`key=start:stop:step` (stop included) or `key=v1,v2,...` as (key, values). @throws InputError for any
    other form.
    """
    key, separator, values = text.partition("=")
    key = key.strip()
    if not separator or not key:
        raise InputError(f"--vary: '{text}' is not allowed: key=start:stop:step or key=v1,v2,...")
    if ":" not in values:
        words = [word.strip() for word in values.split(",")]
        if not all(words) or len(set(words)) != len(words):
            raise InputError(f"--vary: '{text}' is not allowed: distinct values separated by commas")
        return key, words
    try:
        start, stop, step = (float(word) for word in values.split(":"))
    except ValueError:
        raise InputError(f"--vary: '{text}' is not allowed: three numbers start:stop:step") from None
    if not np.isfinite([start, stop, step]).all() or step <= 0 or stop < start:
        raise InputError(
            f"--vary: '{text}' is not allowed: finite numbers, step above 0 and stop not below start"
        )
    # Half a millionth of a step of slack, so that 0.05:0.5:0.05 ends with 0.5 whatever the rounding.
    count = int(np.floor((stop - start) / step + 5e-7)) + 1
    if count > MAX_RUNS:
        raise InputError(f"--vary: '{text}' is not allowed: {count} values; at most {MAX_RUNS}")
    return key, [f"{start + index * step:.10g}" for index in range(count)]


def grid(varied: List[Tuple[str, List[str]]]) -> List[Dict[str, str]]:
    """All combinations of the varied values."""
    keys = [key for key, _ in varied]
    if len(set(keys)) != len(keys):
        raise InputError("--vary: a key is given twice")
    points = [dict(zip(keys, values)) for values in itertools.product(*(values for _, values in varied))]
    if len(points) > MAX_RUNS:
        raise InputError(f"--vary: {len(points)} runs; at most {MAX_RUNS}")
    return points


def folder_name(point: Dict[str, str]) -> str:
    """Name of the folder of one run."""
    return "_".join(f"{key}={value}" for key, value in point.items()).replace("/", "_")


def evaluate(folder: str, known, t_max_diff: float) -> Dict[str, Dict[str, float]]:
    """APE figures and coverage of the online and final trajectory of a run folder."""
    aligned = run_figures.Aligned(Run(folder), known, t_max_diff)
    figures = {}
    for result in aligned.results:
        figures[result.name] = dict(metrics.statistics(result.errors), coverage=result.compared.coverage)
        if result.ground_errors is not None:
            figures[result.name]["ground_mean"] = float(result.ground_errors.mean())
    return figures


class Sweep:
    """The runs of one grid in one output folder."""

    def __init__(
        self, words_of, points: List[Dict[str, str]], out: str, known, t_max_diff: float, keep: bool
    ):
        """@param words_of function (settings, folder) -> command line; @param keep leaves every run's
        files.
        """
        self.words_of, self.points, self.out = words_of, points, out
        self.known, self.t_max_diff, self.keep = known, t_max_diff, keep
        self.runner = runner.Runner()

    def finished(self, point: Dict[str, str]):
        """The figures of a point computed earlier by the same command, or None."""
        path = os.path.join(self.out, "runs", folder_name(point), RESULT)
        if not os.path.isfile(path):
            return None
        try:
            with open(path, encoding="utf-8") as file:
                record = json.load(file)
        except (OSError, ValueError):
            return None  # cut off while it was written: computed anew
        return record["ape"] if record.get("command") == self._command(point) else None

    def _command(self, point: Dict[str, str]) -> List[str]:
        return self.words_of(point, os.path.join(self.out, "runs", folder_name(point)))

    def compute(self, point: Dict[str, str]):
        """Runs one point and leaves its figures."""
        folder = os.path.join(self.out, "runs", folder_name(point))
        shutil.rmtree(folder, ignore_errors=True)
        os.makedirs(folder)
        words = self._command(point)
        self.runner.run(words)
        figures = evaluate(folder, self.known, self.t_max_diff)
        if not self.keep:
            for name in os.listdir(folder):
                if name not in ("summary.json", RESULT):
                    os.unlink(os.path.join(folder, name))
        part = os.path.join(folder, RESULT + ".part")
        evaluation.write_json(part, {"command": words, "settings": point, "ape": figures})
        os.replace(part, os.path.join(folder, RESULT))
        return figures

    def run(self, jobs: int):
        """All points, `jobs` at a time; (figures by index of the point, messages of the points that
        failed).
        """
        found = {
            index: figures
            for index, figures in ((i, self.finished(p)) for i, p in enumerate(self.points))
            if figures
        }
        failures: List[str] = []
        missing = [index for index in range(len(self.points)) if index not in found]
        progress = Progress(len(missing), f"sweep ({len(found)} done before)" if found else "sweep")
        with ThreadPoolExecutor(jobs) as pool:
            futures = {pool.submit(self.compute, self.points[index]): index for index in missing}
            try:
                for future in as_completed(futures):
                    try:
                        found[futures[future]] = future.result()
                    except InputError as error:
                        failures.append(f"{folder_name(self.points[futures[future]])}: {error}")
                    progress.advance()
            except KeyboardInterrupt:
                self.runner.stop()
                raise
            finally:
                progress.close()
        return found, failures


def write_csv(path: str, keys: List[str], points, found) -> None:
    """One row a point: the settings, then the figures of the final and the online trajectory."""
    columns = [
        (name, figure) for name in ("final", "online") for figure in (*FIGURES, "ground_mean", "coverage")
    ]
    part = path + ".part"
    with open(part, "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(keys + [f"{name}_{figure}" for name, figure in columns])
        for index in sorted(found):
            figures = found[index]
            writer.writerow(
                [points[index][key] for key in keys]
                + [figures.get(name, {}).get(figure, "") for name, figure in columns]
            )
    os.replace(part, path)


def plot_parameter(path: str, key: str, points, found, trajectory: str = "final", mark=None) -> None:
    """Mean APE over one parameter (the paper's Fig. 6 and 7): the best of the other parameters, and all runs
    as dots.

    @param mark value of the parameter to mark, or None.
    """
    pyplot = plotting.load()
    figure, axes = pyplot.subplots(figsize=(8, 5), constrained_layout=True)
    numeric = all(_is_number(points[index][key]) for index in found)
    labels = sorted({points[index][key] for index in found}, key=float if numeric else str)
    places = {label: float(label) if numeric else float(number) for number, label in enumerate(labels)}
    rows = [(places[points[index][key]], found[index][trajectory]["mean"]) for index in sorted(found)]
    values, errors = np.array(rows).T
    best = [(place, errors[values == place].min()) for place in sorted(set(values))]
    several = len(rows) > len(best)
    if several:
        axes.plot(values, errors, ".", color="0.6", markersize=5, label="every run")
    axes.plot(
        *zip(*best),
        marker="o",
        color=plotting.FINAL,
        label="best of the other parameters" if several else trajectory,
    )
    lowest = min(best, key=lambda item: item[1])
    axes.annotate(
        f"{lowest[1]:.3g} m",
        lowest,
        textcoords="offset points",
        xytext=(0, -16),
        ha="center",
        color=plotting.FINAL,
    )
    if mark is not None:
        axes.axvline(mark, color="0.5", linestyle=":", label=f"in use: {mark:g}")
    if not numeric:
        axes.set_xticks(range(len(labels)))
        axes.set_xticklabels(labels)
    elif len(best) > 2 and min(values) > 0 and max(values) >= LOG_SPAN * min(values):
        axes.set_xscale("log")
        axes.set_xticks(sorted(set(values)))
        axes.set_xticklabels([f"{value:g}" for value in sorted(set(values))])
        axes.minorticks_off()
    axes.set_xlabel(key)
    axes.set_ylabel(f"mean APE of the {trajectory} trajectory [m]")
    axes.set_ylim(bottom=0.0)
    axes.grid(alpha=0.3)
    axes.legend(loc="best", fontsize=9)
    plotting.finish(pyplot, figure, path)


def _is_number(text: str) -> bool:
    try:
        return bool(np.isfinite(float(text)))
    except ValueError:
        return False


def execute(words_of, varied, out: str, known, t_max_diff=0.01, jobs=None, keep=False):
    """A whole sweep: runs, `sweep.csv`, and `ape_over_<key>.png` for each key. Returns points and figures by
    index.

    @throws InputError if no run succeeds; the failures of some are returned as the third value.
    """
    points = grid(varied)
    os.makedirs(out, exist_ok=True)
    found, failures = Sweep(words_of, points, out, known, t_max_diff, keep).run(jobs or os.cpu_count() or 1)
    if not found:
        raise InputError(f"all {len(points)} runs failed; the first: {failures[0]}")
    write_csv(os.path.join(out, "sweep.csv"), [key for key, _ in varied], points, found)
    for key, values in varied:
        if len(values) > 1:
            plot_parameter(os.path.join(out, f"ape_over_{key}.png"), key, points, found)
    return points, found, failures


def main(argv=None) -> None:
    """sweep."""
    parser = argparse.ArgumentParser(
        prog="sweep",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Runs ratslam_run over a grid of parameters; writes sweep.csv and the mean APE over "
        "each parameter. "
        "ORB odometry is computed once where no varied parameter can change it. "
        "Started again after an interruption, it computes only what is missing.",
        epilog="examples:\n  sweep dataset/sequences/00 --config config/kitti.yaml --truth "
        "dataset/sequences/00 \\\n"
        "        --vary pc_vt_inject_energy=0.05:0.5:0.05 --out out/inject\n"
        "  sweep drive.bag --config config/kitti.yaml --truth drive.bag --vary pc_cell_x_size=0.5,1,2,4 \\\n"
        "        --vary vt_match_threshold=0.03,0.04,0.05 --jobs 2 --out out/grid",
    )
    parser.add_argument("input", metavar="INPUT", help="bag or KITTI sequence folder, as for ratslam_run")
    parser.add_argument(
        "--config", required=True, metavar="FILE", help="configuration the varied keys are set on top of"
    )
    add_truth_options(parser, required=True)
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
    parser.add_argument("--keep", action="store_true", help="keep every run's files, not only its figures")
    parser.add_argument("--ratslam_run", metavar="FILE", help="the program, if it is not found by itself")
    arguments = parser.parse_args(argv)
    if arguments.jobs is not None and arguments.jobs < 1:
        raise InputError(f"--jobs: {arguments.jobs} is not allowed: at least 1")
    program = runner.find(arguments.ratslam_run)
    varied = [parse_vary(text) for text in arguments.vary]
    known = truth.read_truth(arguments.truth, arguments.times)

    def words_of(settings, folder, odometry):
        return runner.command(
            program, arguments.input, arguments.config, folder, settings, odometry, arguments.max_frames
        )

    odometry = arguments.odometry
    if runner.odometry_can_be_shared(odometry, [key for key, _ in varied]):
        folder = os.path.join(arguments.out, "odometry")
        runner.run_once(words_of({}, folder, odometry), folder)
        odometry = os.path.join(folder, "odometry.csv")

    points, found, failures = execute(
        lambda settings, folder: words_of(settings, folder, odometry),
        varied,
        arguments.out,
        known,
        arguments.t_max_diff,
        arguments.jobs,
        arguments.keep,
    )
    best = min(found, key=lambda index: found[index]["final"]["mean"])
    figures = found[best]["final"]
    print(
        f"{len(found)} of {len(points)} runs; best final APE {figures['mean']:.4g} m mean (coverage "
        f"{100 * figures['coverage']:.1f} %) with "
        + ", ".join(f"{key}={value}" for key, value in points[best].items())
    )
    print(f"wrote {os.path.join(arguments.out, 'sweep.csv')} and its figures")
    if failures:
        raise InputError(f"{len(failures)} of {len(points)} runs failed; the first: {failures[0]}")
