"""Common functions for figures: a backend without a display, colours, coloured lines, saving."""

import argparse
import os

import numpy as np

from ratslam_tools import output_file, text_file
from ratslam_tools.errors import InputError, one_line

TRUTH, ONLINE, FINAL, LINK = "0.35", "#d98c00", "#0060a8", "#c0392b"
TRAIL = "#7be650"  # over dark ground
ERROR_MAP = "viridis"


def load(show: bool = False):
    """matplotlib.pyplot, drawing into files unless a window is asked for. @throws InputError without a
    display.
    """
    import matplotlib

    if show and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise InputError("--plot: there is no display; --save_plot FILE writes the figure instead")
    if not show:
        matplotlib.use("Agg")
    from matplotlib import pyplot

    return pyplot


def literal(name: str) -> str:
    """A name as plain text of a figure: escapes `$`, which begins a formula, and a leading `_`, which hides a
    label."""
    text = "".join(letter if letter.isprintable() or letter == "\n" else "?" for letter in name)
    return (" " + text if text.startswith("_") else text).replace("$", r"\$")


def coloured_line(axes, x, y, ends, values, largest: float, breaks=()):
    """A path (x, y) whose part up to each pose of `ends` has the colour of its value; a part across one of the `breaks` (rows
    of the poses behind them) is left out. Returns the artist.
    """
    from matplotlib.collections import LineCollection

    points = np.column_stack([x, y])
    starts = np.concatenate([[0], ends[:-1]]).astype(int)
    unbroken = np.searchsorted(breaks, starts, "right") == np.searchsorted(breaks, ends, "right")
    shown = np.flatnonzero((ends > starts) & unbroken)
    lines = LineCollection([points[starts[row] : ends[row] + 1] for row in shown], cmap=ERROR_MAP, linewidths=2.2)
    lines.set_array(np.asarray(values)[shown])
    lines.set_clim(0.0, largest)
    axes.add_collection(lines)
    axes.autoscale_view()
    return lines


PICTURES = (".png", ".pdf", ".svg", ".jpg", ".jpeg")


def picture_file(path: str) -> str:
    """An option's value that names a picture to write. @throws argparse.ArgumentTypeError for a folder or another ending."""
    if os.path.isdir(path):
        raise argparse.ArgumentTypeError(f"{path} is a folder; a file such as {os.path.join(path, 'run.png')} is written")
    if os.path.splitext(path)[1].lower() not in PICTURES:
        raise argparse.ArgumentTypeError(f"{path}: a picture ends in {', '.join(PICTURES)}")
    return path


def finish(pyplot, figure, path=None, show: bool = False, dpi: int = 130) -> None:
    """Saves and/or shows a figure and closes it. @throws InputError if the file cannot be written."""
    if path:
        text_file.require_replaceable(path)
        try:
            with output_file.writing(path, "wb", "the figure ") as file:
                figure.savefig(file, dpi=dpi, format=os.path.splitext(path)[1][1:].lower())
        except ValueError as error:
            raise InputError(f"{path}: the figure cannot be written: {one_line(error)}") from None
    if show:
        pyplot.show()
    pyplot.close(figure)


def scale_bar(axes) -> None:
    """A bar of a round length (1, 2 or 5 times a power of ten), about a fifth of the width, in the lower left
    corner.
    """
    from mpl_toolkits.axes_grid1.anchored_artists import AnchoredSizeBar

    low, high = axes.get_xlim()
    room = (high - low) / 5
    power = 10.0 ** np.floor(np.log10(room))  # by rounding it may be a little larger than the room
    length = power * max(factor for factor in (0.5, 1, 2, 5) if factor * power <= room)
    axes.add_artist(
        AnchoredSizeBar(
            axes.transData,
            length,
            f"{length:g} m",
            "lower left",
            pad=0.6,
            frameon=True,
            size_vertical=(high - low) / 300,
        )
    )
