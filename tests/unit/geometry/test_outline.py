"""Areas, lengths and chords of the segments."""

import math

import numpy as np
import pytest

from perfqr_cad.geometry import Arc, Bezier, Circle, Line, Loop, Region

HALF_DISC = Loop((Arc((2, 0), (-2, 0), (0, 0), True), Line((-2, 0), (2, 0))))
BULGE = Loop((Bezier((0, 0), (0, 3), (4, 3), (4, 0)), Line((4, 0), (0, 0))))


def test_areas_are_exact():
    assert HALF_DISC.area == pytest.approx(2 * math.pi, rel=1e-14)
    assert Loop((Circle((5, -7), 3, ccw=False),)).area == pytest.approx(-9 * math.pi, rel=1e-14)
    assert BULGE.area == pytest.approx(-0.3 * 24, rel=1e-14)  # a cubic cap: 3/10·(2h·w + ...) of its controls


@pytest.mark.parametrize("loop", [HALF_DISC, BULGE, Loop((Circle((1, 1), 2, True),))])
def test_chords_stay_within_the_tolerance_and_turn_round_when_reversed(loop):
    fine, coarse = loop.flatten(1e-5), loop.flatten(1e-2)
    assert len(fine) > len(coarse)
    x, y = fine.T
    assert (x * np.roll(y, -1) - np.roll(x, -1) * y).sum() / 2 == pytest.approx(loop.area, abs=1e-3)
    assert loop.reversed().area == pytest.approx(-loop.area)
    ends = [s.end for s in loop.reversed().segments]
    starts = [s.start for s in loop.reversed().segments]
    assert np.allclose(ends, starts[1:] + starts[:1])


def test_a_chord_of_an_arc_is_no_farther_than_the_tolerance():
    points = HALF_DISC.segments[0].flatten(0.01)
    middles = (np.array(points[1:]) + np.array(points[:-1])) / 2
    sagitta = 2 - np.hypot(*middles.T)
    assert 0.002 < sagitta.max() <= 0.01


def test_a_region_subtracts_its_holes():
    square = Loop.from_points([(0, 0), (10, 0), (10, 10), (0, 10)])
    region = Region(square, (Loop((Circle((5, 5), 1, ccw=False),)),))
    assert region.area == pytest.approx(100 - math.pi)
    assert region.polygon(1e-4).area == pytest.approx(100 - math.pi, abs=1e-3)
    assert Region.from_polygon(region.polygon()).area == pytest.approx(region.area, abs=0.05)
