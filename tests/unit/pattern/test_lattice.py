"""Tracing and the reading of stairs."""

import numpy as np
import pytest

from perfqr_cad.errors import DesignError
from perfqr_cad.pattern.lattice import checkerboards, discs, opened, sharpened, trace


def area(loop):
    x, y = loop[:, 0], -loop[:, 1]
    return (x * np.roll(y, -1) - np.roll(x, -1) * y).sum() / 2


def test_loops_enclose_the_cells():
    rng = np.random.default_rng(3)
    for _ in range(20):
        solid = rng.random((30, 30)) < 0.7
        for x, y in checkerboards(solid).tolist():
            solid[y - 1 : y + 1, x - 1 : x + 1] = True
        if len(checkerboards(solid)):
            continue
        assert sum(area(loop) for loop in trace(solid)) == solid.sum()


def test_a_checkerboard_is_refused():
    with pytest.raises(DesignError):
        trace(np.array([[True, False], [False, True]]))


def test_a_stair_of_single_cells_is_a_straight_edge():
    step = np.arange(8)
    solid = np.pad(step[:, None] + step[None, :] < 8, 4)
    (loop,) = (sharpened(loop) for loop in trace(solid))
    assert len(loop) == 3
    assert area(loop) == pytest.approx(9 * 9 / 2)


def test_openings_keep_what_the_tool_can_reach():
    solid = np.zeros((20, 20), np.bool_)
    solid[2:10, 2:10] = True
    solid[5, 10:15] = True
    assert opened(solid, 4).sum() == 64
    assert discs(solid, 8).sum() == 1
