"""Figures of errors: trajectories coloured by their error (the paper's Fig. 5), side by side, above the error
over time.
"""

import numpy as np

from ratslam_tools import plotting
from ratslam_tools.trajectory import frames

USUAL = 0.98  # share of the poses that are not far off
SPIKE = 3.0  # errors this many times larger than all usual ones are spikes
MARGIN = 1.2


def ground_axes(compared):
    """Indices of the two coordinates that make the ground plane (or the plane of largest extent)."""
    if compared.convention is not None:
        plane = frames.GROUND[compared.convention]
    else:
        thinnest = int(np.argmin(np.ptp(compared.reference.positions, axis=0)))
        plane = next(name for name, normal in frames.PLANES.items() if normal == thinnest)
    return "xyz".index(plane[0]), "xyz".index(plane[1])


def draw_coloured(axes, result, largest: float, label: str):
    """One trajectory coloured by its error over the grey reference; returns the coloured artist."""
    first, second = ground_axes(result.compared)
    matched = result.compared.reference
    reference, estimate = matched.with_gaps(matched.positions), result.compared.estimate.positions
    axes.plot(
        reference[:, first],
        reference[:, second],
        color="0.6",
        linewidth=1.0,
        linestyle="--",
        label="reference",
    )
    ends = np.asarray(result.ends)
    artist = plotting.coloured_line(
        axes, estimate[:, first], estimate[:, second], ends, result.errors, largest, matched.breaks
    )
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel(f"{'xyz'[first]} [m]")
    axes.set_ylabel(f"{'xyz'[second]} [m]")
    axes.set_title(plotting.literal(label))
    axes.legend(loc="best", fontsize=8)
    return artist


def plot_errors(results, title: str, quantity: str, path=None, show: bool = False) -> None:
    """Writes and/or shows the figure of all results.

    @throws InputError if a window is asked for without a display, or the file cannot be written.
    """
    pyplot = plotting.load(show)
    plotting.finish(pyplot, errors_figure(pyplot, results, title, quantity), path, show)


def top_of_scale(results) -> float:
    """End of the scales: the largest error, or, if a few poses are far off (an odometry that has just started), a
    little above all others, which would otherwise look equal."""
    largest = max(float(result.errors.max()) for result in results)
    usual = max(float(np.quantile(result.errors, USUAL)) for result in results)
    return largest if largest <= SPIKE * usual or usual == 0.0 else MARGIN * usual


def errors_figure(pyplot, results, title: str, quantity: str):
    """Coloured trajectories, which share one colour scale, above the errors over time."""
    count = len(results)
    figure = pyplot.figure(figsize=(max(8.0, 5.6 * count), 9.0), constrained_layout=True)
    grid = figure.add_gridspec(2, count, height_ratios=[2.2, 1.0])
    top = top_of_scale(results)
    beyond = any((result.errors > top).any() for result in results)
    maps = []
    for column, result in enumerate(results):
        maps.append(figure.add_subplot(grid[0, column]))
        mean = float(result.errors.mean())
        artist = draw_coloured(
            maps[-1], result, top, f"{result.name}\nmean {mean:.3g}, max {result.errors.max():.3g}"
        )
    figure.colorbar(artist, ax=maps, label=quantity, shrink=0.85, extend="max" if beyond else "neither")
    axes = figure.add_subplot(grid[1, :])
    for result in results:
        matched, ends = result.compared.reference, np.asarray(result.ends)
        times = ends if matched.stamps is None else matched.stamps[ends] - matched.stamps[0]
        above = int((result.errors > top).sum())
        label = result.name + (f" ({above} of {len(result.errors)} above the scale)" if above else "")
        over_time = matched.with_gaps(np.column_stack([times, result.errors]), ends)
        axes.plot(over_time[:, 0], over_time[:, 1], linewidth=0.9, label=plotting.literal(label))
    axes.set_xlabel("pose" if results[0].compared.reference.stamps is None else "time [s]")
    axes.set_ylabel(quantity)
    axes.set_ylim(bottom=0.0, top=top if beyond else None)
    axes.grid(alpha=0.3)
    axes.legend(loc="best", fontsize=8)
    figure.suptitle(plotting.literal(title))
    return figure
