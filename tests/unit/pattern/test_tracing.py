"""Tracing, the reading of stairs, and rings that lie in one array."""

import numpy as np
import pytest

from perfqr_cad.errors import DesignError
from perfqr_cad.pattern.cells.lattice import checkerboards
from perfqr_cad.pattern.cells.tracing import Boundaries, sharpened, trace


def blob(seed, size=30):
    """Random cells without checkerboards."""
    solid = np.random.default_rng(seed).random((size, size)) < 0.7
    while len(corners := checkerboards(solid)):
        for x, y in corners.tolist():
            solid[y - 1 : y + 1, x - 1 : x + 1] = True
    return solid


@pytest.mark.parametrize("seed", range(8))
def test_rings_enclose_the_cells(seed):
    solid = blob(seed)
    rings = trace(solid)
    assert -rings.areas.sum() == solid.sum()  # y runs down
    edge = rings.after(rings.points) - rings.points
    assert ((edge == 0).sum(axis=1) == 1).all()  # upright edges
    assert ((edge != 0) != (rings.before(edge) != 0)).all()  # every vertex is a true corner


def test_a_checkerboard_is_refused():
    with pytest.raises(DesignError):
        trace(np.array([[True, False], [False, True]]))


def test_a_stair_of_single_cells_is_a_straight_edge():
    step = np.arange(8)
    solid = np.pad(step[:, None] + step[None, :] < 8, 4)
    rings = sharpened(trace(solid))
    assert rings.sizes.tolist() == [3]
    assert -rings.areas[0] == pytest.approx(9 * 9 / 2)


def test_stairs_of_one_ring_leave_the_others_alone():
    step = np.arange(8)
    stair = np.pad(step[:, None] + step[None, :] < 8, 4)
    block = np.pad(np.ones((4, 5), bool), ((6, 6), (2, 2)))
    rings = sharpened(trace(np.hstack([block, stair, block])))
    assert sorted(rings.sizes.tolist()) == [3, 4, 4]
    assert sorted((-rings.areas).tolist()) == [20, 20, 40.5]


def test_rings_keep_apart_what_is_in_one_array():
    square, triangle = np.array([[0.0, 0], [2, 0], [2, 2], [0, 2]]), np.array([[5.0, 5], [6, 5], [5, 7]])
    rings = Boundaries.of([square, triangle])
    assert rings.areas.tolist() == [4, 1]
    assert rings.after(rings.points)[3].tolist() == [0, 0]
    assert rings.before(rings.points)[4].tolist() == [5, 7]
    fewer = rings.only(np.array([True] * 4 + [False] * 3))
    assert fewer.sizes.tolist() == [4, 0]
    chosen = rings.where(np.array([False, True]), Boundaries.of([square * 3, triangle * 3]))
    assert chosen.areas.tolist() == [36, 1]
    assert [loop.area for loop in rings.loops()] == [4, 1]
