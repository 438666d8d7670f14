"""Colours that are expected to need less joining."""

from __future__ import annotations

import numpy as np
import pytest

from perfqr_cad.pattern.arrangement import LINK_AREA, _joined_by, _link_cost, arranged, joining
from perfqr_cad.pattern.cells.lattice import checkerboards
from perfqr_cad.symbol import encode, freedom


def test_the_cost_of_a_module_is_the_change_of_the_corners_to_be_linked() -> None:
    random = np.random.default_rng(0)
    solid = random.integers(0, 2, (9, 9)).astype(float)
    cost = _link_cost(solid, np.ones((10, 10)))
    for row, column in np.argwhere(np.ones((7, 7))) + 1:
        counts = []
        for value in (1.0, 0.0):
            changed = solid.copy()
            changed[row, column] = value
            counts.append(len(checkerboards(changed > 0)))
        assert cost[row, column] == pytest.approx(counts[0] - counts[1])


def test_open_modules_count_as_half() -> None:
    share = np.full((4, 4), 0.5)
    share[1, 1], share[0, 1], share[1, 0] = 1.0, 0.0, 0.0
    # Solid at (0, 0) would surely make a corner with (1, 1); all else is even.
    assert _link_cost(share, np.ones((5, 5)))[0, 0] == pytest.approx(1 + 0.125 - 0.125)


def test_a_hole_between_pieces_would_join_them() -> None:
    pieces = np.zeros((5, 5), np.int32)
    pieces[0], pieces[4], pieces[2, 0] = 1, 2, 3
    joins = _joined_by(pieces)
    assert joins[3, 4] == 0
    assert joins[1, 0] == 1  # the upper row and the module at the left
    assert joins[2, 4] == 0
    assert (joins[pieces > 0] == 0).all()


@pytest.mark.parametrize("tone", [False, True])
def test_more_rounds_never_need_more_joining(tone: bool) -> None:
    space = freedom(encode("more rounds", version=3))
    areas = [arranged(space, tone, 4, rounds, 5)[1].area for rounds in (1, 3, 12)]
    assert areas == sorted(areas, reverse=True)
    assert areas[-1] < joining(space.symbol, tone, 4).area


def test_what_is_left_is_counted() -> None:
    left = joining(encode("count", version=1), False, 4)
    assert left.area >= LINK_AREA * len(left.corners)
    assert left.count == left.pieces.max() == 4  # the frame and one light ring in each finder
