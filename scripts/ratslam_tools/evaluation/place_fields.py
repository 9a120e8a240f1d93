"""Place fields of cells: occupancy-normalised rate maps, their autocorrelation, and grid scores.

Definitions as in the field: Hafting et al. 2005 (grid cells), Sargolini et al. 2006 (grid score), Skaggs et al. 1993
(spatial information).
"""

from typing import Tuple

import numpy as np

from ratslam_tools.errors import InputError


def occupancy(positions: np.ndarray, bin_size: float) -> Tuple[np.ndarray, np.ndarray]:
    """Frames spent in each bin, (rows, columns), and the bin of each frame, (frames, 2): row (y), column (x).

    @param positions (frames, 2) in metres   @throws InputError for other shapes, NaN, or a bin that is not positive
    """
    positions = np.asarray(positions, dtype=float)
    if positions.ndim != 2 or positions.shape[1] != 2 or not len(positions) or not np.isfinite(positions).all():
        raise InputError(f"positions: an array of shape {positions.shape} is not allowed: (frames, 2), all finite")
    if not bin_size > 0:
        raise InputError(f"bin_size: {bin_size} is not allowed: above 0")
    bins = np.floor((positions - positions.min(axis=0)) / bin_size).astype(int)[:, ::-1]
    counts = np.zeros(bins.max(axis=0) + 1)
    np.add.at(counts, (bins[:, 0], bins[:, 1]), 1)
    return counts, bins


def rate_maps(positions: np.ndarray, activity: np.ndarray, bin_size: float, least_frames: int = 1) -> np.ndarray:
    """Mean activity of each cell in each bin, (cells, rows, columns); NaN in bins with fewer than
    `least_frames` frames.

    @param activity (frames, cells), at the positions' frames
    """
    counts, bins = occupancy(positions, bin_size)
    activity = np.asarray(activity, dtype=float)
    if activity.ndim != 2 or len(activity) != len(bins):
        raise InputError(f"activity: an array of shape {activity.shape} is not allowed: ({len(bins)} frames, cells)")
    sums = np.zeros((activity.shape[1], *counts.shape))
    flat = bins[:, 0] * counts.shape[1] + bins[:, 1]
    for cell in range(activity.shape[1]):
        sums[cell] = np.bincount(flat, activity[:, cell], counts.size).reshape(counts.shape)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(counts >= max(1, least_frames), sums / counts, np.nan)


def spatial_information(rate_map: np.ndarray, counts: np.ndarray) -> float:
    """Information about the place per unit of activity [bits] (Skaggs)."""
    known = np.isfinite(rate_map) & (counts > 0)
    share, rate = counts[known] / counts[known].sum(), rate_map[known]
    mean = float((share * rate).sum())
    if mean <= 0.0:
        return 0.0
    ratio = rate[rate > 0] / mean
    return float((share[rate > 0] * ratio * np.log2(ratio)).sum())


def autocorrelation(rate_map: np.ndarray, least_overlap: int = 20) -> np.ndarray:
    """Pearson's correlation of a map with itself moved by every lag, (2 rows - 1, 2 columns - 1); NaN for lags with
    fewer than `least_overlap` common bins.
    """
    known = np.isfinite(rate_map)
    values, weights = np.where(known, rate_map, 0.0), known.astype(float)
    shape = tuple(2 * length - 1 for length in rate_map.shape)

    def correlate(a, b):
        spectrum = np.fft.rfft2(a, shape) * np.conj(np.fft.rfft2(b, shape))
        return np.fft.fftshift(np.fft.irfft2(spectrum, shape))

    count = np.round(correlate(weights, weights))
    sum_a, sum_b = correlate(values, weights), correlate(weights, values)
    square_a, square_b = correlate(values**2, weights), correlate(weights, values**2)
    with np.errstate(invalid="ignore", divide="ignore"):
        covariance = correlate(values, values) - sum_a * sum_b / count
        deviation = np.sqrt((square_a - sum_a**2 / count) * (square_b - sum_b**2 / count))
        result = covariance / deviation
        return np.where((count >= least_overlap) & (deviation > 1e-12), result, np.nan)


def symmetry_score(correlogram: np.ndarray, fold: int, inner: float, outer: float) -> float:
    """Correlation of a correlogram's ring with itself rotated by multiples of a turn / `fold`, minus that half-way
    between:
    fold 6 is the grid score (60 and 120 degrees against 30, 90 and 150), fold 4 that of a square lattice.

    @param inner, outer radii of the ring [bins]
    """
    rows, columns = np.indices(correlogram.shape)
    centre = (np.array(correlogram.shape) - 1) / 2
    y, x = rows - centre[0], columns - centre[1]
    radius, angle = np.hypot(x, y), np.arctan2(y, x)
    ring = np.isfinite(correlogram) & (radius >= inner) & (radius <= outer)

    def likeness(turn):
        turned_y = np.round(centre[0] + radius[ring] * np.sin(angle[ring] + turn)).astype(int)
        turned_x = np.round(centre[1] + radius[ring] * np.cos(angle[ring] + turn)).astype(int)
        inside = (turned_y >= 0) & (turned_y < correlogram.shape[0])
        inside &= (turned_x >= 0) & (turned_x < correlogram.shape[1])
        a, b = correlogram[ring][inside], correlogram[turned_y[inside], turned_x[inside]]
        both = np.isfinite(b)
        return float(np.corrcoef(a[both], b[both])[0, 1]) if both.sum() > 2 else np.nan

    step = 2 * np.pi / fold
    like = [likeness(step * number) for number in range(1, fold // 2)]
    unlike = [likeness(step * (number + 0.5)) for number in range(fold // 2)]
    return min(like) - max(unlike)
