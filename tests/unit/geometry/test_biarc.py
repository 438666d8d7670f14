"""Béziers as arcs: within the tolerance, with the tangents kept, by an independent distance."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from perfqr_cad.geometry import Arc, Bezier, Line, Loop
from perfqr_cad.geometry.biarc import arcs_of, with_arcs

TOL_MM = 0.002
COORDINATE = st.floats(-5, 5).map(lambda x: round(x, 6))
POINT = st.tuples(COORDINATE, COORDINATE)


def distance_mm(curve, pieces):
    """Hausdorff distance of dense polylines: shapely's, not ours."""
    drawn = [p for piece in pieces for p in piece.flatten(1e-5)] + [pieces[-1].end]
    exact = [*curve.flatten(1e-5), curve.end]
    return shapely.LineString(drawn).hausdorff_distance(shapely.LineString(exact))


def turns_rad(pieces):
    """Angles between pieces that follow one another."""

    def direction(piece, at_end):
        if isinstance(piece, Line):
            return math.atan2(piece.end[1] - piece.start[1], piece.end[0] - piece.start[0])
        return (
            piece.start_rad + (piece.sweep_rad if at_end else 0) + math.copysign(math.pi / 2, piece.sweep_rad)
        )

    pairs = pairwise(pieces)
    return [abs(math.remainder(direction(a, True) - direction(b, False), math.tau)) for a, b in pairs]


@given(POINT, POINT, POINT, POINT)
@settings(max_examples=60, deadline=None)
def test_any_curve_is_followed_within_the_tolerance(start, c1, c2, end):
    curve = Bezier(start, c1, c2, end)
    pieces = arcs_of(curve, TOL_MM)
    assert (pieces[0].start, pieces[-1].end) == (start, end)
    for a, b in pairwise(pieces):
        assert math.dist(a.end, b.start) < 1e-9
    assert distance_mm(curve, pieces) < 1.2 * TOL_MM  # between the probes, and flattening


def test_a_worse_fit_is_seen():
    """The distance above tells a chord from the curve."""
    curve = Bezier((0, 0), (0, 1), (1, 2), (3, 2))
    assert distance_mm(curve, [Line(curve.start, curve.end)]) > 0.3


@pytest.mark.parametrize(
    "curve",
    [
        Bezier((0, 0), (0, 1), (1, 2), (3, 2)),
        Bezier((0, 0), (2, 0), (1, 3), (3, 3)),  # an S
        Bezier((0, 0), (3, 2), (-2, 2), (1, 0)),  # a loop
    ],
)
def test_arcs_meet_without_a_corner(curve):
    pieces = arcs_of(curve, TOL_MM)
    assert all(isinstance(piece, Arc) for piece in pieces)
    assert max(turns_rad(pieces)) < 1e-6


def test_a_straight_curve_is_one_line():
    assert arcs_of(Bezier((0, 0), (1, 1), (2, 2), (3, 3)), TOL_MM) == [Line((0, 0), (3, 3))]


def test_a_control_point_on_its_end_gives_the_next_direction():
    pieces = arcs_of(Bezier((0, 0), (0, 0), (1, 2), (3, 2)), TOL_MM)
    assert distance_mm(Bezier((0, 0), (0, 0), (1, 2), (3, 2)), pieces) < 1.1 * TOL_MM


def test_a_closed_curve_is_no_point():
    teardrop = Bezier((0, 0), (3, 3), (-3, 3), (0, 0))
    assert distance_mm(teardrop, arcs_of(teardrop, TOL_MM)) < 1.1 * TOL_MM


def test_a_loop_keeps_its_lines_and_its_area():
    loop = Loop((Line((0, 0), (4, 0)), Bezier((4, 0), (6, 2), (2, 5), (0, 4)), Line((0, 4), (0, 0))))
    drawn = with_arcs(loop, TOL_MM)
    assert (drawn.segments[0], drawn.segments[-1]) == (loop.segments[0], loop.segments[-1])
    assert drawn.area == pytest.approx(loop.area, abs=TOL_MM * loop.length)
    assert not any(isinstance(segment, Bezier) for segment in drawn.segments)
