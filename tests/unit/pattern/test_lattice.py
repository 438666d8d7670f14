"""Corners, openings and discs of cells."""

import numpy as np

from perfqr_cad.pattern.cells.lattice import checkerboards, discs, opened


def test_openings_keep_what_the_tool_can_reach():
    solid = np.zeros((20, 20), np.bool_)
    solid[2:10, 2:10] = True
    solid[5, 10:15] = True
    assert opened(solid, 4).sum() == 64
    assert discs(solid, 8).sum() == 1


def test_checkerboards_are_the_corners_between_cells_that_share_no_edge():
    rng = np.random.default_rng(5)
    solid = rng.random((12, 15)) < 0.5
    expected = [
        [x, y]
        for y in range(1, 12)
        for x in range(1, 15)
        if solid[y - 1, x - 1] == solid[y, x] != solid[y - 1, x] == solid[y, x - 1]
    ]
    assert checkerboards(solid).tolist() == expected
