"""The pose cells' activity at the snapshots of a run, in three projections like the live picture (Malichev & Yakhno
2024, Fig. 4).
"""

from typing import List, Tuple

import numpy as np

from ratslam_tools import plotting
from ratslam_tools.errors import InputError

GAP = 2  # cells between projections
MOST_ALONG_AXIS = 4096  # of cells, the parameters' bound
MOST_CELLS = 10**8
TRAIL = 200  # decisions whose estimates are drawn behind the packet


def network_size(run) -> Tuple[int, int]:
    """Cells along x and y, and heading layers, from the run's summary; 0 if it lacks them."""
    parameters = run.summary.get("parameters", {})
    sizes = []
    for key in ("pc_dim_xy", "pc_dim_th"):
        size = parameters.get(key, 0) if isinstance(parameters, dict) else 0
        if not isinstance(size, (int, float)) or not 0 <= size <= MOST_ALONG_AXIS:
            raise InputError(f"{run.folder}/summary.json: {key}: {str(size)[:60]} is no number of pose cells")
        sizes.append(int(size))
    if sizes[0] ** 2 * sizes[1] > MOST_CELLS:
        raise InputError(f"{run.folder}/summary.json: {sizes[0]}x{sizes[0]}x{sizes[1]} pose cells are too many to draw")
    return sizes[0], sizes[1]


def has_activity(run) -> bool:
    """Whether there is anything to draw."""
    return run.activity is not None and len(run.activity["stamp"]) > 0 and min(network_size(run)) > 0


def activities(run) -> List[Tuple[float, np.ndarray]]:
    """(stamp [s], activity of shape layers x rows x columns) of each moment, in order."""
    n_xy, n_th = network_size(run)
    cells = run.activity
    places = np.stack([cells[key].astype(int) for key in ("layer", "row", "column")])
    if (places < 0).any() or (places >= np.array([[n_th], [n_xy], [n_xy]])).any():
        raise InputError(f"{run.folder}/pose_cells.csv: a cell outside the network of {n_xy}x{n_xy}x{n_th}")
    found = []
    for stamp in np.unique(cells["stamp"]):
        at = cells["stamp"] == stamp
        activity = np.zeros((n_th, n_xy, n_xy))
        activity[tuple(places[:, at])] = cells["activity"][at]
        found.append((float(stamp), activity))
    return found


def mosaic(activity: np.ndarray) -> np.ndarray:
    """y over x at the upper left, y over heading beside it, heading over x below; row 0 at the bottom, NaN
    between. Each projection is scaled to its largest value. Square roots are shown, because on a linear scale only
    the peak would show.
    """
    n_th, n_xy, _ = activity.shape
    picture = np.full((n_xy + GAP + n_th, n_xy + GAP + n_th), np.nan)
    for projection, row, column in (
        (activity.sum(axis=0), n_th + GAP, 0),
        (activity.sum(axis=2).T, n_th + GAP, n_xy + GAP),
        (activity.sum(axis=1), 0, 0),
    ):
        height, width = projection.shape
        picture[row : row + height, column : column + width] = np.sqrt(
            projection / max(projection.max(), 1e-300)
        )
    return picture


def draw_activity(axes, run) -> None:
    """The pose cells' activity at moments of the run: y over x, y over heading, heading over x; with the trail."""
    n_xy, n_th = network_size(run)
    moments = activities(run)
    side = n_xy + GAP + n_th
    start = run.activity["stamp"].min()
    if run.actions is not None and len(run.actions["stamp"]):
        start = run.actions["stamp"][0]
    for number, (stamp, activity) in enumerate(moments):
        left = number * (side + 3 * GAP)
        axes.imshow(
            mosaic(activity),
            origin="lower",
            cmap="inferno",
            vmin=0,
            vmax=1,
            extent=(left, left + side, 0, side),
            interpolation="nearest",
        )
        axes.text(left + n_xy + 2 * GAP, n_th / 2, f"{stamp - start:.1f} s", va="center", fontsize=9)
        if run.actions is not None:
            _draw_trail(axes, run.actions, stamp, left, n_xy, n_th)
    axes.set_xlim(-GAP, len(moments) * (side + 3 * GAP) - 2 * GAP)
    axes.set_ylim(-GAP, side + GAP)
    axes.set_aspect("equal")
    axes.set_axis_off()


def _draw_trail(axes, actions, stamp: float, left: float, n_xy: int, n_th: int) -> None:
    """The trail of the estimate in the three projections. Steps across the edge of the torus are not joined."""
    end = int(np.searchsorted(actions["stamp"], stamp, side="right"))
    rows = slice(max(end - TRAIL, 0), end)
    sizes = {"x": n_xy, "y": n_xy, "th": n_th}
    # The middle of cell 0 is coordinate 0.
    place = {key: np.mod(actions[key][rows] + 0.5, size) for key, size in sizes.items()}
    above, beside = n_th + GAP, left + n_xy + GAP
    for across, up, x0, y0 in (("x", "y", left, above), ("th", "y", beside, above), ("x", "th", left, 0)):
        x, y = place[across] + x0, place[up] + y0
        wraps = (np.abs(np.diff(x)) > sizes[across] / 2) | (np.abs(np.diff(y)) > sizes[up] / 2)
        breaks = np.flatnonzero(wraps) + 1
        axes.plot(
            np.insert(x, breaks, np.nan), np.insert(y, breaks, np.nan), color=plotting.TRAIL, linewidth=1
        )
