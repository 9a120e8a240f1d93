"""Runs of ratslam_run over a grid of parameters: the grid, its runs, their results, table and figures.

Every finished run leaves a folder with `result.json`. From these files an interrupted sweep continues where it
stopped, and a sweep divided among machines is merged.
"""

import csv
import hashlib
import itertools
import json
import os
import shutil
import sys
import threading
from collections import Counter
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from typing import Dict, List, Optional, Tuple

import numpy as np

from ratslam_tools import evaluation, plotting, text_file
from ratslam_tools.errors import InputError, one_line
from ratslam_tools.evaluation import metrics
from ratslam_tools.progress import Progress
from ratslam_tools.runs import fingerprint, run_figures, runner
from ratslam_tools.runs.run_folder import Run

MAX_RUNS = 10000
MOST_REMARKS = 5  # printed at the end of a sweep
RESULT = "result.json"
LOG_SPAN = 20  # a larger range of values gets a logarithmic axis
FIGURES = ("max", "mean", "median", "min", "rmse")


def parse_vary(text: str) -> Tuple[str, List[str]]:
    """`key=start:stop:step` (stop included) or `key=v1,v2,...` as (key, values). @throws InputError for any
    other form.
    """
    key, separator, values = text.partition("=")
    key = key.strip()
    if not separator or not key:
        raise InputError(f"--vary: '{text}' is not allowed: key=start:stop:step or key=v1,v2,...")
    return key, parse_values("--vary", text, values)


def parse_values(option: str, text: str, values: str) -> List[str]:
    """The values `start:stop:step` or `v1,v2,...`. @throws InputError naming the option and its text"""
    if ":" not in values:
        words = [word.strip() for word in values.split(",")]
        if not all(words) or len(set(words)) != len(words):
            raise InputError(f"{option}: '{text}' is not allowed: distinct values separated by commas")
        return words
    try:
        start, stop, step = (float(word) for word in values.split(":"))
    except ValueError:
        raise InputError(f"{option}: '{text}' is not allowed: three numbers start:stop:step") from None
    if not np.isfinite([start, stop, step]).all() or step <= 0 or stop < start:
        raise InputError(
            f"{option}: '{text}' is not allowed: finite numbers, step above 0 and stop not below start"
        )
    # Half a millionth of a step of slack, so that 0.05:0.5:0.05 ends with 0.5 whatever the rounding.
    count = np.floor((stop - start) / step + 5e-7) + 1  # may be infinite
    if count > MAX_RUNS:
        raise InputError(f"{option}: '{text}' is not allowed: {count:.10g} values; at most {MAX_RUNS}")
    return [f"{start + index * step:.10g}" for index in range(int(count))]


def grid(varied: List[Tuple[str, List[str]]]) -> List[Dict[str, str]]:
    """All combinations of the varied values."""
    keys = [key for key, _ in varied]
    names = [runner.parameter(key) for key in keys]
    for index, name in enumerate(names):
        if name in names[:index]:
            first = keys[names.index(name)]
            raise InputError(f"--vary: {keys[index]} is given twice" + (f", first as {first}" if first != keys[index] else ""))
    points = [dict(zip(keys, values)) for values in itertools.product(*(values for _, values in varied))]
    if len(points) > MAX_RUNS:
        raise InputError(f"--vary: {len(points)} runs; at most {MAX_RUNS}")
    return points


def folder_name(point: Dict[str, str]) -> str:
    """Name of the folder of one run. Values with a slash, such as files, have it as %2F."""
    return "_".join(f"{key}={value}" for key, value in point.items()).replace("%", "%25").replace("/", "%2F")


def evaluate(folder: str, known, t_max_diff: float) -> Tuple[Dict[str, float], List[str]]:
    """Results of a run folder, by name; and remarks on them.

    ape.final.mean and similar ones (also coverage, ground_mean) if the truth is known; every number of the summary's
    counts and timing, such as counts.experiences and timing.odometry; counts.recalls, the number of links by recall.
    """
    run = Run(folder)
    figures: Dict[str, float] = {}
    aligned = run_figures.Aligned(run, known, t_max_diff)
    for result in aligned.results:
        values = dict(metrics.statistics(result.errors), coverage=result.compared.coverage)
        if result.ground_errors is not None:
            values["ground_mean"] = float(result.ground_errors.mean())
        figures.update({f"ape.{result.name}.{name}": value for name, value in values.items()})
    counts = run.summary.get("counts", {})
    figures.update({f"counts.{name}": float(value) for name, value in counts.items()})
    figures.update({f"timing.{name}": value for name, value in run.timing.items()})
    if run.map is not None:
        figures["counts.recalls"] = float(len(run.map.loop_ends))
    return figures, [f"no scale fits {name} to the truth; its errors are without scale" for name in aligned.notes]


def _judge(known, t_max_diff: float) -> str:
    """A text that is the same for the same truth (or none) and the same matching of stamps [s]."""
    if known is None:
        return "no truth"
    values = np.ascontiguousarray(np.hstack([known.stamps[:, None], known.positions]))
    return f"{hashlib.sha256(values.tobytes()).hexdigest()} within {t_max_diff:g} s"


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
        self.stopped = threading.Event()
        self.judged_by = _judge(known, t_max_diff)
        self.remarks: List[List[str]] = []  # of each run

    def finished(self, point: Dict[str, str], known: Dict[str, str]):
        """Earlier results of a point by the same command, from the same inputs, judged by the same truth; or None.
        @param known as for fingerprint.of_command."""
        path = os.path.join(self.out, "runs", folder_name(point), RESULT)
        if not os.path.isfile(path):
            return None
        try:
            with open(path, encoding="utf-8") as file:
                record = json.load(file)
        except (OSError, ValueError):
            return None  # was cut off while it was written; compute it again
        if not isinstance(record, dict):
            return None
        same = all(record.get(key) == value for key, value in self._origin(self._command(point), known).items())
        if not same:
            return None
        told = record.get("remarks")
        self.remarks.append([str(remark) for remark in told] if isinstance(told, list) else [])
        return record.get("figures")

    def _origin(self, words: List[str], known: Optional[Dict[str, str]] = None) -> dict:
        """What a result depends on. @param known as for fingerprint.of_command."""
        return {"command": words, "inputs": fingerprint.of_command(words, known), "judged_by": self.judged_by}

    def _command(self, point: Dict[str, str]) -> List[str]:
        return self.words_of(point, os.path.join(self.out, "runs", folder_name(point)))

    def compute(self, point: Dict[str, str]):
        """Runs one point and writes its results. @throws InputError if it fails or the sweep was stopped before"""
        if self.stopped.is_set():  # what an earlier sweep has left stays
            raise InputError("stopped")
        folder = os.path.join(self.out, "runs", folder_name(point))
        shutil.rmtree(folder, ignore_errors=True)
        os.makedirs(folder)
        words = self._command(point)
        origin = self._origin(words)  # of before: what changes during the run makes it count as changed
        remarks = self.runner.run(words)
        figures, more = evaluate(folder, self.known, self.t_max_diff)
        remarks += more
        self.remarks.append(remarks)
        if not self.keep:
            for name in os.listdir(folder):
                if name not in ("summary.json", RESULT):
                    os.unlink(os.path.join(folder, name))
        record = {**origin, "settings": point, "figures": figures, "remarks": remarks}
        evaluation.write_json(os.path.join(folder, RESULT), record)
        return figures

    def run(self, jobs: int):
        """All points, `jobs` at a time; (figures by index of the point, messages of the points that
        failed).
        """
        known: Dict[str, str] = {}  # so that a recording is looked through once, not for each point
        found = {
            index: figures
            for index, figures in ((i, self.finished(p, known)) for i, p in enumerate(self.points))
            if figures
        }
        failures: List[str] = []
        missing = [index for index in range(len(self.points)) if index not in found]
        progress = Progress(len(missing), f"sweep ({len(found)} done before)" if found else "sweep")
        with ThreadPoolExecutor(jobs) as pool:
            futures: Dict[Future, int] = {}
            try:
                for index in missing:
                    futures[pool.submit(self.compute, self.points[index])] = index
                for future in as_completed(futures):
                    try:
                        found[futures[future]] = future.result()
                    except InputError as error:
                        failures.append(f"{folder_name(self.points[futures[future]])}: {error}")
                    progress.advance()
            except KeyboardInterrupt:
                self.stopped.set()
                for future in futures:
                    future.cancel()
                self.runner.stop()
                raise
            finally:
                progress.close()
        self._tell_remarks()
        return found, failures

    def _tell_remarks(self) -> None:
        """Prints what runs have remarked, such as that a parameter has no effect; each remark once, the frequent ones
        first."""
        runs_of = Counter(remark for remarks in self.remarks for remark in sorted(set(remarks)))
        ordered = sorted(runs_of.items(), key=lambda item: (-item[1], item[0]))
        for remark, runs in ordered[:MOST_REMARKS]:
            print(f"note: {runs} of {len(self.points)} runs: {one_line(remark)}", file=sys.stderr)
        if len(ordered) > MOST_REMARKS:
            print(f"note: and {len(ordered) - MOST_REMARKS} other remarks", file=sys.stderr)


def write_csv(path: str, keys: List[str], points, found) -> None:
    """One row per point: the settings, then every result that some run has."""
    names = sorted({name for figures in found.values() for name in figures})
    with text_file.writing(path, newline="") as file:
        writer = csv.writer(file)
        writer.writerow(keys + names)
        for index in sorted(found):
            row = [points[index][key] for key in keys]
            writer.writerow(row + [found[index].get(name, "") for name in names])


class Goal:
    """The result by which runs are compared."""

    def __init__(self, name: str = "ape.final.mean", largest: bool = False):
        self.name, self.largest = name, largest

    def of(self, found) -> Dict[int, float]:
        """The result by which runs are compared, by index of the point, of the runs that have it. @throws InputError if none
        has."""
        values = {index: figures[self.name] for index, figures in sorted(found.items()) if self.name in figures}
        if not values:
            names = sorted({name for figures in found.values() for name in figures})
            raise InputError(f"--goal: no run has {self.name}; there are {', '.join(names)}")
        return values

    def best(self, found) -> Tuple[float, List[int]]:
        """The best value and the points that have it, all of them."""
        values = self.of(found)
        best = (max if self.largest else min)(values.values())
        return best, sorted(index for index, value in values.items() if value == best)

    @property
    def label(self) -> str:
        """The name of the result with its unit, for the axis of a figure."""
        words = self.name.split(".")
        if words[0] == "ape" and words[2] == "coverage":
            return f"coverage of the {words[1]} trajectory, as a share"
        if words[0] == "ape":
            return f"{words[2]} APE of the {words[1]} trajectory [{'m^2' if words[2] == 'sse' else 'm'}]"
        return f"{words[-1].replace('_', ' ')} [ms a frame]" if words[0] == "timing" else words[-1]


def plot_parameter(path: str, key: str, points, found, goal: Optional[Goal] = None, mark=None) -> None:
    """The goal over one parameter (the paper's Fig. 6 and 7): the best of the other parameters, and all runs
    as dots.

    @param mark value of the parameter to mark, or None.
    """
    goal = goal or Goal()
    goals = goal.of(found)
    pyplot = plotting.load()
    figure, axes = pyplot.subplots(figsize=(8, 5), constrained_layout=True)
    numeric = all(_is_number(points[index][key]) for index in goals)
    labels = sorted({points[index][key] for index in goals}, key=float if numeric else str)
    places = {label: float(label) if numeric else float(number) for number, label in enumerate(labels)}
    rows = [(places[points[index][key]], value) for index, value in goals.items()]
    values, errors = np.array(rows).T
    best = [(place, (errors[values == place].max if goal.largest else errors[values == place].min)()) for place in sorted(set(values))]
    several = len(rows) > len(best)
    if several:
        axes.plot(values, errors, ".", color="0.6", markersize=5, label="every run")
    axes.plot(
        *zip(*best),
        marker="o",
        color=plotting.FINAL,
        label="best of the other parameters" if several else goal.name,
    )
    top = (max if goal.largest else min)(value for _, value in best)
    if sum(value == top for _, value in best) == 1:  # several equal values are not marked
        axes.annotate(
            f"{top:.3g}",
            next(item for item in best if item[1] == top),
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
    axes.set_ylabel(goal.label)
    axes.set_ylim(0.0, 1.08 * max(errors) if max(errors) > 0.0 else None)
    axes.grid(alpha=0.3)
    axes.legend(loc="best", fontsize=9)
    plotting.finish(pyplot, figure, path)


def _is_number(text: str) -> bool:
    try:
        return bool(np.isfinite(float(text)))
    except ValueError:
        return False


def execute(words_of, varied, out: str, known, t_max_diff=0.01, jobs=None, keep=False, goal=None):
    """A whole sweep: runs, `sweep.csv`, and `<goal>_over_<key>.png` for each key. Returns points and results by
    index.

    @throws InputError if no run succeeds; the failures of some are returned as the third value.
    """
    points = grid(varied)
    os.makedirs(out, exist_ok=True)
    found, failures = Sweep(words_of, points, out, known, t_max_diff, keep).run(jobs or os.cpu_count() or 1)
    if not found:
        raise InputError(f"all {len(points)} runs failed; the first: {failures[0]}")
    leave(out, varied, points, found, goal or Goal())
    return points, found, failures


def leave(out: str, varied, points, found, goal: Goal) -> None:
    """Writes the table and the figures of a sweep."""
    os.makedirs(out, exist_ok=True)
    write_csv(os.path.join(out, "sweep.csv"), [key for key, _ in varied], points, found)
    figure = "ape" if goal.name == Goal().name else goal.name
    for key, values in varied:
        if len(values) > 1:
            plot_parameter(os.path.join(out, f"{figure}_over_{key}.png"), key, points, found, goal)
