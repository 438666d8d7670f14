"""Recessed bars: the front face lacks them, the material has them, and both fit without a seam."""

import numpy as np
import pytest
import shapely

from perfqr_cad.capture import Art
from perfqr_cad.errors import DesignError
from perfqr_cad.pattern import Bridge, PatternSpec, build
from perfqr_cad.pattern.front import joined
from perfqr_cad.pattern.outline import Line
from perfqr_cad.symbol import encode

RINGS = {1: 3, 2: 4, 6: 4, 7: 9}  # finders and alignment patterns


def made(version=2, art=None, **settings):
    return build(encode("RECESS", version=version), PatternSpec(finder="recessed", **settings), art)


def assert_front_and_bars_are_the_region(pattern):
    front = [region.polygon() for region in pattern.front]
    bars = [shapely.Polygon(bridge.corners()) for bridge in pattern.recessed]
    assert all(part.is_valid for part in front)
    assert len(shapely.get_parts(shapely.union_all(front))) == len(front)
    pieces = [*pattern.front, *bars]
    assert sum(piece.area for piece in pieces) == pytest.approx(pattern.region.area)
    whole = shapely.union_all([*front, *bars])
    assert shapely.symmetric_difference(whole, pattern.polygon).area < 1e-6
    assert pattern.front[0].area == max(region.area for region in pattern.front)


def edges_under(pattern, point):
    """Straight edges of the front that hold a point."""
    spot = shapely.Point(point)
    lines = [s for region in pattern.front for s in region.segments() if isinstance(s, Line)]
    return [line for line in lines if shapely.LineString([line.start, line.end]).distance(spot) < 1e-9]


@pytest.mark.parametrize("version", RINGS)
@pytest.mark.parametrize("tone", ["normal", "inverted"])
def test_only_the_ring_that_readers_trace_has_a_recessed_bar(version, tone):
    pattern = made(version, tone=tone, bar_height_mm=0.5)
    assert sum(bridge.stage == "function" for bridge in pattern.bridges) == RINGS[version]
    assert [bridge.height_mm for bridge in pattern.recessed] == [0.5] * (version <= 6)
    assert len(pattern.front) == 1 + len(pattern.recessed)
    assert all(x < 0 and y < 0 for bridge in pattern.recessed for x, y in (bridge.start, bridge.end))
    assert_front_and_bars_are_the_region(pattern)


@pytest.mark.parametrize("style", ["rounded", "dots", "diamond", "bars"])
def test_styles_have_the_same_front(style):
    pattern = made(style=style)
    assert len(pattern.recessed) == 1
    assert_front_and_bars_are_the_region(pattern)


def test_any_ring_can_have_a_recessed_bar(monkeypatch):
    monkeypatch.setattr("perfqr_cad.pattern.rings.is_traced", lambda ring, version: True)
    pattern = made(7)
    assert len(pattern.recessed) >= 3
    assert_front_and_bars_are_the_region(pattern)


@pytest.mark.parametrize("style", ["square", "rounded"])
def test_bars_end_within_one_straight_edge_square_to_them(style):
    pattern = made(6, style=style)
    for bar in pattern.recessed:
        right_start, right_end, left_end, left_start = bar.corners()
        for middle, corners in ((bar.start, (right_start, left_start)), (bar.end, (right_end, left_end))):
            (edge,) = edges_under(pattern, middle)
            assert all(edge in edges_under(pattern, corner) for corner in corners)
            beyond = min(
                np.hypot(*np.subtract(tip, corner)) for tip in (edge.start, edge.end) for corner in corners
            )
            assert beyond > 0.4  # walls that flare take some of it
            along = np.subtract(edge.end, edge.start) @ np.subtract(bar.end, bar.start)
            assert along == pytest.approx(0, abs=1e-9)


def slot_mm(**settings):
    (bar,) = made(**settings).recessed
    return np.hypot(*np.subtract(bar.end, bar.start))


def test_the_slot_is_narrow_but_no_narrower_than_a_gap():
    assert slot_mm() == pytest.approx(0.38 * 1.2, abs=0.06)
    assert slot_mm(size_mm=33 * 2.4) == pytest.approx(0.38 * 2.4, abs=0.06)
    assert slot_mm(min_gap_mm=1.0) >= 1.0


def test_a_flush_pattern_has_one_front():
    pattern = build(encode("RECESS", version=2), PatternSpec(finder="panel"))
    assert pattern.recessed == ()
    assert pattern.front == (pattern.region,)


def test_a_bar_that_another_bridge_covers_becomes_flush():
    pattern = made()
    bar = pattern.recessed[0]
    over = Bridge(bar.start, bar.end, bar.width_mm, "structural", 0.0)
    more = pattern.with_bridge(over)
    assert len(more.recessed) == len(pattern.recessed) - 1
    assert len(more.front) == 1
    assert_front_and_bars_are_the_region(more)


def test_bridges_elsewhere_leave_the_bars_recessed():
    pattern = made(fillet_mm=0)
    half, m = pattern.symbol.size / 2 * pattern.module_mm, pattern.module_mm
    core = Bridge((-half + 2 * m, half - 3 * m), (-half + 5 * m, half - 4 * m), 0.9, "structural", 0.0)
    more = pattern.with_bridge(core)
    assert more.recessed == pattern.recessed
    assert_front_and_bars_are_the_region(more)


def test_smooth_contours_keep_the_edges_on_which_bars_end():
    symbol = encode("RECESS", version=2)
    scale = 8
    dark = np.kron(symbol.matrix.dark, np.ones((scale, scale), bool))
    dark[:, 3 * scale : 3 * scale + 2] ^= True  # stairs through the finders on the left
    pattern = made(art=Art("freeform", scale, dark))
    assert len(pattern.recessed) == 1
    assert_front_and_bars_are_the_region(pattern)


def test_round_rings_get_flush_bars():
    symbol = encode("RECESS", version=1)
    scale = 12
    dark = np.kron(symbol.matrix.dark, np.ones((scale, scale), bool))
    y, x = np.mgrid[: 7 * scale, : 7 * scale] - 3.5 * scale + 0.5
    away = np.hypot(x, y) / scale
    dark[-7 * scale :, : 7 * scale] = (away < 1.5) | ((away > 2.5) & (away < 3.5))
    pattern = made(1, Art("freeform", scale, dark))
    assert len(pattern.recessed) == 0
    assert_front_and_bars_are_the_region(pattern)


def test_a_bar_that_hangs_in_the_air_is_refused():
    pattern = made()
    astray = Bridge((0.01, 0.02), (1.01, 0.02), 0.8, "function", 0.0, 0.6)
    with pytest.raises(DesignError, match="no straight edge"):
        joined(pattern.front, [astray])
    with pytest.raises(DesignError, match="2 pieces"):
        joined(pattern.front, [])
