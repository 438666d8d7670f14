"""Fillets and smooth contours."""

import math

import numpy as np
import pytest

from perfqr_cad.geometry import Arc, Bezier, Loop, Region
from perfqr_cad.pattern.drawing.rounding import LEAST_EDGE_MM, filleted, smoothed

OUTER = Loop.from_points([(0, 0), (10, 0), (10, 10), (0, 10)])
HOLE = Loop.from_points([(4, 4), (4, 6), (6, 6), (6, 4)])
PLATE = Region(OUTER, (HOLE,))


def test_re_entrant_corners_become_arcs_of_the_radius():
    rounded = filleted(PLATE, 0.5)
    arcs = [s for s in rounded.segments() if isinstance(s, Arc)]
    assert len(arcs) == 4  # the corners of the hole; those of the plate stick out and stay
    assert all(arc.radius == pytest.approx(0.5) for arc in arcs)
    assert rounded.area == pytest.approx(PLATE.area + (4 - math.pi) * 0.5**2)
    assert rounded.outer == OUTER


def test_a_radius_too_large_is_made_to_fit():
    rounded = filleted(PLATE, 5.0)
    assert rounded.holes[0].area == pytest.approx(-math.pi)  # a circle of half the edge
    assert rounded.polygon().is_valid


def test_no_remnant_of_an_edge_is_left():
    hole = Loop.from_points([(4, 4), (4, 4.45), (6, 4.45), (6, 4)])
    rounded = filleted(Region(OUTER, (hole,)), 0.2)
    assert min(s.length for s in rounded.segments()) >= LEAST_EDGE_MM - 1e-9


def test_radius_zero_changes_nothing():
    assert filleted(PLATE, 0.0) is PLATE


def stairs(step):
    """A disc drawn in squares of the given step."""
    import shapely

    k = np.arange(-20, 20)
    boxes = [
        shapely.box(x * step, y * step, (x + 1) * step, (y + 1) * step)
        for x in k
        for y in k
        if math.hypot(x + 0.5, y + 0.5) < 18
    ]
    return Region.from_polygon(shapely.union_all(boxes))


def test_stairs_become_smooth_within_the_tolerance():
    rough = stairs(0.1)
    smooth = smoothed(rough, 0.1)
    assert any(isinstance(s, Bezier) for s in smooth.segments())
    assert smooth.polygon().hausdorff_distance(rough.polygon()) <= 0.1 + 0.005
    assert len(list(smooth.segments())) < len(list(rough.segments()))
    assert smooth.area == pytest.approx(rough.area, rel=0.01)
