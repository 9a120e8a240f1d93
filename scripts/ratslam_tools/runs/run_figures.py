"""Figures of one run: the map with truth and loop links, view cells and experiences over time, pose cells,
timing.
"""

from dataclasses import replace

import numpy as np

from ratslam_tools import evaluation, plotting
from ratslam_tools.evaluation import comparison, metrics
from ratslam_tools.runs.activity_figure import draw_activity, has_activity
from ratslam_tools.trajectory.association import MAX_STAMP_DIFFERENCE_S
from ratslam_tools.errors import InputError
from ratslam_tools.runs.run_folder import Run
from ratslam_tools.trajectory import Trajectory, breaks_of

ERROR_STATISTICS = ("mean", "median", "rmse", "max", "min")
MAX_LINKS_OPAQUE = 200


class Aligned:
    """A run aligned with its truth by similarity, or, where no scale fits (association.Alignment.collapsed), by rotation and
    translation. Without truth everything is in the map's frame.

    `paths`: positions (n, 3) [m] of `final` and `online`, all stretches; `nodes`: of the map, by the final trajectory's
    alignment; `results`: APE of the stretches of this run's recording, to which the truth belongs, in the order of
    run.trajectories, empty without truth; `notes`: by name, on those that no scale fits.
    """

    def __init__(self, run: Run, truth=None, t_max_diff: float = MAX_STAMP_DIFFERENCE_S):
        self.run, self.truth = run, truth
        self.results, self.notes = [], {}
        self.paths = {trajectory.name: trajectory.positions for trajectory in run.trajectories}
        nodes = None
        if run.map is not None:
            nodes = np.column_stack([run.map.nodes[key] for key in ("x", "y", "z")])
        if truth is not None:
            settings = comparison.Settings(
                align=True, correct_scale=True, t_max_diff=t_max_diff, ref_frame="base", est_frame="base"
            )
            own = [of_this_run(run, trajectory) for trajectory in run.trajectories]
            self.results = [self._judged(truth, trajectory, settings) for trajectory in own]
            for trajectory, result in zip(run.trajectories, self.results):
                self.paths[trajectory.name] = result.compared.alignment.apply(trajectory).positions
            if nodes is not None:
                alignment = self.results[-1].compared.alignment
                nodes = alignment.scale * nodes @ alignment.rotation.T + alignment.translation
        self.nodes = nodes

    def _judged(self, truth, trajectory: Trajectory, settings: comparison.Settings) -> evaluation.Result:
        (result,) = evaluation.evaluate_ape(truth, [trajectory], settings)
        if not result.compared.alignment.collapsed:
            return result
        words = evaluation.collapse_words(trajectory.name, result.compared.alignment)
        self.notes[trajectory.name] = f"{words}: drawn and evaluated without scale"
        return evaluation.evaluate_ape(truth, [trajectory], replace(settings, correct_scale=False))[0]


def of_this_run(run: Run, trajectory: Trajectory) -> Trajectory:
    """The stretches of a trajectory that are of the recording this run read."""
    stretches = trajectory.stretches
    own = run.own_stretches(trajectory)
    begin = sum(len(stretch) for stretch in stretches[: own.start])
    return trajectory.select(slice(begin, None))


def stretch_words(run: Run) -> str:
    """One sentence on which stretches of the final trajectory the errors are about; empty if it is one."""
    stretches, own = run.final.stretches, run.own_stretches(run.final)
    if len(stretches) == 1:
        return ""
    if own.start == 0:
        return f"evaluated: all {len(stretches)} stretches of this run, whose time went back"
    which = "the last stretch" if len(own) == 1 else f"the last {len(own)} stretches"
    before = sum(len(stretch) for stretch in stretches[: own.start])
    whose = ", this run's own" if run.summary.get("counts") else ""  # only ratslam_run's files show which stretches are new
    return f"evaluated: {which} of {len(stretches)}{whose}; the {before} poses before are drawn and not evaluated"


def draw_map(axes, aligned: Aligned) -> None:
    """Truth, online and final trajectory, experiences and loop links; equal axes and a scale bar."""
    if aligned.truth is not None:
        truth = aligned.truth.positions
        axes.plot(
            truth[:, 0], truth[:, 1], color=plotting.TRUTH, linewidth=1.2, linestyle="--", label="truth"
        )
    for name, colour, width in (("online", plotting.ONLINE, 1.0), ("final", plotting.FINAL, 1.6)):
        if name in aligned.paths:
            path = _with_gaps(aligned.run, getattr(aligned.run, name).stamps, aligned.paths[name])
            axes.plot(path[:, 0], path[:, 1], color=colour, linewidth=width, label=name)
    start = aligned.paths["final"][0]
    axes.plot(
        start[0],
        start[1],
        marker="o",
        color=plotting.FINAL,
        markersize=7,
        markeredgecolor="white",
        linestyle="none",
        label="start",
    )
    if aligned.nodes is not None:
        draw_loop_links(axes, aligned)
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.06)
    plotting.scale_bar(axes)
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.grid(alpha=0.25)
    axes.legend(loc="best", fontsize=8)


def _with_gaps(run: Run, stamps, values) -> np.ndarray:
    """Values (n, ...) for a line, with NaN where time went back or the run says nothing of the way (Run.silence)."""
    rows = [] if stamps is None else breaks_of(stamps, run.silence(stamps))
    return np.insert(np.asarray(values, dtype=float), rows, np.nan, axis=0)


def draw_loop_links(axes, aligned: Aligned) -> None:
    """Links by recall, as lines between their experiences, with a dot at their ends."""
    from matplotlib.collections import LineCollection

    ends = aligned.run.map.loop_ends
    if not len(ends):
        return
    points = aligned.nodes[:, :2]
    alpha = 0.9 if len(ends) <= MAX_LINKS_OPAQUE else 0.4
    lines = LineCollection(
        points[ends],
        colors=plotting.LINK,
        linewidths=1.0,
        alpha=alpha,
        zorder=4,
        label=f"loop links ({len(ends)})",
    )
    axes.add_collection(lines)
    dots = points[np.unique(ends)]
    axes.plot(
        dots[:, 0],
        dots[:, 1],
        color=plotting.LINK,
        marker=".",
        markersize=7,
        linestyle="none",
        alpha=alpha,
        zorder=4,
    )


def draw_templates(axes, run: Run) -> None:
    """Active view cell over time: new ones are on the rising edge, recalls below it."""
    seen = run.templates["template_id"] >= 0  # -1: the image showed nothing
    time = (run.templates["stamp"] - run.templates["stamp"][0])[seen]
    ids = run.templates["template_id"][seen]
    new = ids > np.concatenate([[-1], np.maximum.accumulate(ids)[:-1]])
    axes.plot(time[new], ids[new], ".", color=plotting.FINAL, markersize=2, label="learned")
    axes.plot(time[~new], ids[~new], ".", color=plotting.LINK, markersize=2, label="recalled or kept")
    _over_time(axes, "view cell")
    axes.legend(loc="best", fontsize=8, markerscale=4)


def draw_template_errors(axes, run: Run) -> None:
    """Distance to the best template over time, where there was a candidate."""
    compared = run.templates["error"] >= 0
    stamps = run.templates["stamp"][compared]
    time = _with_gaps(run, stamps, stamps - run.templates["stamp"][0])
    axes.plot(time, _with_gaps(run, stamps, run.templates["error"][compared]), color="0.3", linewidth=0.6)
    _over_time(axes, "match error")


def draw_experiences(axes, run: Run) -> None:
    """Active experience over time; links to known experiences are marked."""
    actions = run.actions
    time = actions["stamp"] - actions["stamp"][0]
    acted = actions["action"] > 0
    axes.plot(time[acted], actions["dest_id"][acted], ".", color=plotting.FINAL, markersize=2, label="active")
    linked = actions["action"] == 2
    axes.plot(
        time[linked],
        actions["dest_id"][linked],
        ".",
        color=plotting.LINK,
        markersize=4,
        label=f"linked ({int(linked.sum())})",
    )
    _over_time(axes, "experience")
    axes.legend(loc="best", fontsize=8, markerscale=3)


def draw_pose_cells(axes, run: Run) -> None:
    """The activity packet's place (x, y) and heading over time, in cells."""
    time = run.actions["stamp"] - run.actions["stamp"][0]
    for key, colour in (("x", plotting.FINAL), ("y", plotting.ONLINE), ("th", "0.5")):
        axes.plot(time, run.actions[key], ".", color=colour, markersize=1.5, label=key)
    _over_time(axes, "pose cell")
    axes.legend(loc="upper right", fontsize=8, markerscale=5)


def draw_timing(axes, run: Run) -> None:
    """Time of each module."""
    names = list(run.timing)
    axes.barh(range(len(names)), [run.timing[name] for name in names], color=plotting.FINAL)
    for row, name in enumerate(names):
        axes.text(run.timing[name], row, f" {run.timing[name]:.2f}", va="center", fontsize=8)
    axes.margins(x=0.15)
    axes.set_yticks(range(len(names)))
    axes.set_yticklabels([name.replace("_", " ") for name in names])
    axes.invert_yaxis()
    axes.set_xlabel("time per frame [ms]")
    axes.grid(alpha=0.3, axis="x")


def _over_time(axes, label: str) -> None:
    axes.set_xlabel("time [s]")
    axes.set_ylabel(label)
    axes.grid(alpha=0.3)


def panels(run: Run) -> list:
    """(title, drawing function) of the panels this run has data for, apart from the map."""
    found = []
    if run.templates is not None and len(run.templates["stamp"]):
        found += [("View cells", draw_templates), ("Template matching", draw_template_errors)]
    if run.actions is not None and len(run.actions["stamp"]):
        found += [("Experiences", draw_experiences), ("Pose cells", draw_pose_cells)]
    if has_activity(run):
        found.append(("Pose-cell activity", draw_activity))
    if run.timing:
        found.append(("Timing", draw_timing))
    return found


def error_words(aligned: Aligned) -> str:
    """Mean APE of each trajectory, for a title."""
    means = [f"{result.name} APE {result.errors.mean():.3g} m mean" for result in aligned.results]
    without_scale = f"\nwithout scale, as none fits: {', '.join(aligned.notes)}" if aligned.notes else ""
    return ", ".join(means) + without_scale


def map_figure(aligned: Aligned):
    """A figure with the map alone."""
    pyplot = plotting.load()
    figure, axes = pyplot.subplots(figsize=(9, 9), constrained_layout=True)
    draw_map(axes, aligned)
    axes.set_title(error_words(aligned) or aligned.run.name)
    return figure


def timing_figure(run: Run):
    """A figure with the time of each module alone. @raise InputError if the summary lacks it."""
    if not run.timing:
        raise InputError(f"{run.name}: its summary.json has no timing")
    figure, axes = plotting.load().subplots(figsize=(7, 2.4), constrained_layout=True)
    draw_timing(axes, run)
    axes.set_title(f"{run.name}: one frame", fontsize=10)
    return figure


def map_picture(folder: str, path: str, truth=None) -> Aligned:
    """Draws the map of a run folder, with the truth (base convention) if given. Returns the aligned run with its
    errors.
    """
    aligned = Aligned(Run(folder), truth)
    plotting.finish(plotting.load(), map_figure(aligned), path)
    return aligned


def overview_figure(aligned: Aligned):
    """One page: the map on the left, everything over time on the right."""
    pyplot = plotting.load()
    others = panels(aligned.run)
    figure = pyplot.figure(figsize=(16, 10) if others else (10, 10), constrained_layout=True)
    grid = figure.add_gridspec(
        max(len(others), 1),
        2 if others else 1,
        width_ratios=[1.25, 1] if others else [1],
        height_ratios=[1.8 if draw is draw_activity else 1.0 for _, draw in others] or None,
    )
    axes = figure.add_subplot(grid[:, 0])
    draw_map(axes, aligned)
    axes.set_title(error_words(aligned) or aligned.run.name)
    for row, (title, draw) in enumerate(others):
        axes = figure.add_subplot(grid[row, 1])
        draw(axes, aligned.run)
        axes.set_title(title, fontsize=10)
    return figure


def error_rows(aligned: Aligned) -> list:
    """Rows of a table of APE in space and on the ground, with coverage."""
    rows = [["trajectory", "", *(f"{key} [m]" for key in ERROR_STATISTICS), "coverage"]]
    for result in aligned.results:
        for label, errors in (("3D", result.errors), ("ground", result.ground_errors)):
            if errors is not None:
                figures = metrics.statistics(errors)
                rows.append(
                    [
                        result.name,
                        label,
                        *(f"{figures[key]:.3f}" for key in ERROR_STATISTICS),
                        f"{100 * result.compared.coverage:.1f} %",
                    ]
                )
    return rows
