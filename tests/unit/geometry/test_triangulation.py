"""Faces with corners in a line: cut without gaps, and the right way round."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from numpy.typing import NDArray

from perfqr_cad.geometry.triangulation import delaunay

Polygons = list[NDArray[np.float64]]


def sheared(slope: float, *polygons: list[tuple[int, int]]) -> Polygons:
    """Polygons with y + slope · x in the place of y, so that corners in a line are rounded off it."""
    return [np.array([(x, y + slope * x) for x, y in polygon]) for polygon in polygons]


SIDE = [(0, 0), (1, 0), (2, 0), (2, 2), (0, 2)]
# Its outline has three corners in a line; sheared, they are off it by less than areas can tell.
HOLED = (
    [(4, 0), (4, 4), (1, 4), (0, 4), (0, 1)],
    [(1, 1), (2, 2), (3, 1)],
    [(3, 2), (1, 3), (2, 3)],
)
CASES = {
    "square": sheared(0.0, SIDE),
    "parallelogram": sheared(1 / 3, SIDE),
    "holes": sheared(0.0, *HOLED),
    "sheared holes": sheared(1 / 3, *HOLED),
}


def doubled_areas(polygons: Polygons) -> NDArray[np.float64]:
    points = np.vstack(polygons)
    a, b, c = (points[corner] for corner in delaunay(polygons).T)
    return (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]


@pytest.mark.parametrize("name", CASES)
def test_no_gap_is_left_between_corners_in_a_line(name: str) -> None:
    """Every side within is that of two triangles, every side of the outline that of one."""
    polygons = CASES[name]
    faces = delaunay(polygons)
    assert len(faces) == sum(map(len, polygons)) + 2 * len(polygons) - 4  # Euler's formula
    sides = Counter(frozenset(side) for a, b, c in faces.tolist() for side in ((a, b), (b, c), (c, a)))
    starts = np.cumsum([0, *map(len, polygons)]).tolist()
    outline = {
        frozenset((first + i, first + (i + 1) % len(polygon)))
        for first, polygon in zip(starts, polygons, strict=False)
        for i in range(len(polygon))
    }
    assert {side for side, uses in sides.items() if uses == 1} == outline
    assert max(sides.values()) == 2


def test_some_triangles_between_corners_in_a_line_are_flat() -> None:
    """What the case with rounded corners is there for."""
    assert (doubled_areas(CASES["sheared holes"]) == 0).any()


@pytest.mark.parametrize("name", CASES)
def test_triangles_run_counter_clockwise(name: str) -> None:
    areas = doubled_areas(CASES[name])
    assert areas.min() >= 0
    assert areas.max() > 0
