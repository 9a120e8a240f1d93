"""Rate maps, their autocorrelation and grid scores, on fields that are known."""

import numpy as np
import pytest

from ratslam_tools.errors import InputError
from ratslam_tools.evaluation import place_fields


def everywhere(side=40):
    rows, columns = np.mgrid[0:side, 0:side]
    return np.column_stack([columns.ravel(), rows.ravel()]).astype(float)


def lattice(positions, spacing, fold):
    """Sum of plane waves: hexagonal with three directions, square with two."""
    angles = np.pi * np.arange(fold // 2) / (fold // 2)
    number = 2 * np.pi / spacing / (np.sin(np.pi / 3) if fold == 6 else 1)
    return sum(1 + np.cos(number * positions @ [np.cos(a), np.sin(a)]) for a in angles)


def test_rates_are_means_over_the_time_spent_there():
    positions = np.array([[0.1, 0.1], [0.2, 0.3], [1.5, 0.1], [0.4, 1.9]])
    counts, _ = place_fields.occupancy(positions, 1.0)
    np.testing.assert_array_equal(counts, [[2, 1], [1, 0]])
    maps = place_fields.rate_maps(positions, np.array([[1.0], [3.0], [5.0], [7.0]]), 1.0)
    np.testing.assert_array_equal(maps, [[[2, 5], [7, np.nan]]])
    assert np.isnan(place_fields.rate_maps(positions, np.ones((4, 1)), 1.0, least_frames=2)[0, 0, 1])


def test_one_place_of_four_is_two_bits():
    counts = np.full((2, 2), 10.0)
    assert place_fields.spatial_information(np.array([[1.0, 0.0], [0.0, 0.0]]), counts) == pytest.approx(2.0)
    assert place_fields.spatial_information(np.ones((2, 2)), counts) == pytest.approx(0.0)


def test_autocorrelation_is_that_of_its_definition():
    random = np.random.RandomState(1)
    field = random.rand(12, 15)
    field[3, 4] = np.nan
    found = place_fields.autocorrelation(field, least_overlap=5)
    assert found[11, 14] == pytest.approx(1.0)
    for dy, dx in ((2, 3), (-4, 1), (0, -7)):
        a = field[max(0, dy) : 12 + min(0, dy), max(0, dx) : 15 + min(0, dx)]
        b = field[max(0, -dy) : 12 + min(0, -dy), max(0, -dx) : 15 + min(0, -dx)]
        both = np.isfinite(a) & np.isfinite(b)
        assert found[11 + dy, 14 + dx] == pytest.approx(np.corrcoef(a[both], b[both])[0, 1], abs=1e-9)


@pytest.mark.parametrize("fold, other", [(6, 4), (4, 6)])
def test_lattices_have_their_own_symmetry(fold, other):
    positions = everywhere()
    maps = place_fields.rate_maps(positions, lattice(positions, 10.0, fold)[:, None], 1.0)
    correlogram = place_fields.autocorrelation(maps[0])
    own = place_fields.symmetry_score(correlogram, fold, 5.0, 14.0)
    foreign = place_fields.symmetry_score(correlogram, other, 5.0, 14.0)
    assert own > 0.5 > 0.1 > foreign


@pytest.mark.parametrize("positions", [np.zeros((3, 3)), np.zeros((0, 2)), np.full((3, 2), np.nan)])
def test_positions_that_are_none(positions):
    with pytest.raises(InputError, match="positions"):
        place_fields.occupancy(positions, 1.0)
