"""Recessed bars: the front face lacks them, the material has them, and both fit without a seam."""

import numpy as np
import pytest
import shapely

from perfqr_cad.capture import Art
from perfqr_cad.errors import DesignError
from perfqr_cad.geometry.outline import Line
from perfqr_cad.pattern import Bridge, PatternSpec, build
from perfqr_cad.pattern.drawing.front import front_with_bars
from perfqr_cad.pattern.joining.rings import DARK_MM, LEAST_SLOT_MODULES, SLOT, WIDE, WIDE_MM
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


def traced(pattern):
    """The recessed bars of the ring at the bottom left."""
    inside = pattern.symbol.size / 2 * pattern.module_mm - 7 * pattern.module_mm
    return [bar for bar in pattern.recessed if bar.start[0] < -inside and bar.start[1] < -inside]


def feet_of(pattern, left, top):
    """Middles of the bars of a finder, from its own, and their widths, in modules; y up."""
    n, m = pattern.symbol.size, pattern.module_mm
    middle = [left + 3.5, n - top - 3.5]
    feet = [
        ((np.array(bar.start) + bar.end) / 2 / m + n / 2 - middle, bar.width_mm / m)
        for bar in pattern.recessed
    ]
    return [(foot, width) for foot, width in feet if np.abs(foot).max() < 3.5]


@pytest.mark.parametrize("version", RINGS)
def test_upper_finders_hang_on_two_sides_and_bars_keep_off_diagonals_and_middles(version):
    pattern = made(version)
    for left in (0, pattern.symbol.size - 7):
        held = feet_of(pattern, left, 0)
        assert len(held) == 3
        assert len({tuple(np.trunc(foot / 2.5).tolist()) for foot, _ in held}) == 2
        for foot, width in held:
            off_middle = np.abs(foot).min()
            assert off_middle > 0.5 + width / 2
            assert off_middle < 2.5 - width / 2
    assert_front_and_bars_are_the_region(pattern)


@pytest.mark.parametrize("module_mm", [1.3, 1.6, 2.4])
def test_the_traced_ring_has_two_dark_bars_on_one_side(module_mm):
    pattern = made(size_mm=33 * module_mm)
    held = feet_of(pattern, 0, pattern.symbol.size - 7)
    assert [np.sign(foot).tolist() for foot, _ in held] in ([[-1, 1], [-1, -1]], [[-1, -1], [-1, 1]])
    for foot, width in held:
        assert width == pytest.approx(min(1.2, WIDE_MM / module_mm), abs=0.1)
        assert 0.5 + width / 2 < abs(foot[1]) < 2.5 - width / 2
    assert all(bar.pinched for bar in traced(pattern))


@pytest.mark.parametrize(("version", "recessed"), [(2, 0), (7, 5)])
def test_one_alignment_pattern_is_held_flush_and_many_as_dark_as_can_be(version, recessed):
    pattern = made(version)
    last = pattern.symbol.size - 7
    finders = sum(len(feet_of(pattern, *at)) for at in ((0, 0), (last, 0), (0, last)))
    assert len(pattern.recessed) - finders >= recessed
    if not recessed:
        assert len(pattern.recessed) == finders


def test_two_sides_need_banks_on_both():
    """A ring whose banks on one side the art takes away hangs on what is left."""
    symbol = encode("RECESS", version=2)
    scale = 8
    dark = np.kron(symbol.matrix.dark, np.ones((scale, scale), bool))
    dark[scale : 2 * scale, 7 * scale : 8 * scale] = True  # the separator beside the upper left finder
    pattern = build(symbol, PatternSpec(), Art("freeform", scale, dark))
    upper_left = [bar for bar in pattern.recessed if bar.start[0] < 0 < bar.start[1]]
    assert len(upper_left) < 3
    assert_front_and_bars_are_the_region(pattern)


@pytest.mark.parametrize("version", RINGS)
def test_rings_have_recessed_bars_wherever_banks_allow(version):
    pattern = made(version, bars=2, bar_height_mm=0.5)
    bars = sum(bridge.stage == "function" for bridge in pattern.bridges)
    assert bars == RINGS[version] + 2  # two on each of the upper finders
    assert len(pattern.recessed) >= 5
    assert {bridge.height_mm for bridge in pattern.recessed} == {0.5}
    assert len(traced(pattern)) == 1
    assert len(pattern.front) == 1 + len(pattern.recessed) - 2
    assert_front_and_bars_are_the_region(pattern)


@pytest.mark.parametrize("version", RINGS)
def test_dark_material_has_one_recessed_bar(version):
    pattern = made(version, tone="inverted")
    assert sum(bridge.stage == "function" for bridge in pattern.bridges) == RINGS[version]
    assert pattern.recessed == tuple(traced(pattern))
    assert len(pattern.recessed) == 1
    assert_front_and_bars_are_the_region(pattern)


@pytest.mark.parametrize("nozzle_mm", [0.2, 0.4])
def test_only_bars_in_pinched_slots_may_be_a_nozzle_line_wide(nozzle_mm):
    pattern = made(nozzle_mm=nozzle_mm, size_mm=60.0, bars=1, bar_width_mm=nozzle_mm)
    cell = pattern.canvas.lattice.cell_mm
    lines = [bar.width_mm for bar in pattern.recessed if bar.pinched]
    assert nozzle_mm <= min(lines) <= max(lines) < nozzle_mm + 2 * cell
    webs = [bar.width_mm for bar in pattern.recessed if not bar.pinched]
    assert min(webs) >= pattern.spec.web_mm
    eroded = pattern.web_polygon.buffer(-0.98 * pattern.spec.web_mm / 2)
    assert eroded.geom_type == "Polygon"
    assert pattern.polygon.buffer(-0.98 * pattern.spec.web_mm / 2).geom_type == "MultiPolygon"
    wide = made(nozzle_mm=nozzle_mm, size_mm=60.0, bars=2)
    assert traced(wide)[0].width_mm >= wide.spec.web_mm
    assert wide.polygon.buffer(-0.98 * wide.spec.web_mm / 2).geom_type == "Polygon"


def bars_of_finders(pattern):
    """Their recessed bars: versions up to 6 have no other rings outside of the lower right quarter."""
    return [bar for bar in pattern.recessed if bar.start[0] < 0 or bar.start[1] > 0]


@pytest.mark.parametrize("module_mm", [1.2, 1.6, 3.0])
def test_bars_of_finders_are_wide_but_no_wider_than_helps(module_mm):
    pattern = made(size_mm=33 * module_mm, bars=1)
    cell = pattern.canvas.lattice.cell_mm
    for bar in bars_of_finders(pattern):
        assert bar.width_mm == pytest.approx(min(WIDE * module_mm, WIDE_MM), abs=2 * cell)
    narrow = made(size_mm=33 * module_mm, bars=1, bar_width_mm=0.8)
    assert max(bar.width_mm for bar in bars_of_finders(narrow)) < 0.8 + 2 * cell


@pytest.mark.parametrize("version", [1, 2, 6])
def test_two_bars_lie_by_both_ends_of_a_side_and_are_one_where_the_slot_is_pinched(version):
    pattern = made(version, bars=2)
    (both,) = traced(pattern)
    assert both.pinched
    assert both.width_mm == pytest.approx(
        2 * WIDE * pattern.module_mm, abs=2 * pattern.canvas.lattice.cell_mm
    )
    upper = [bar for bar in bars_of_finders(pattern) if bar is not both]
    assert len(upper) == 4
    assert not any(bar.pinched for bar in upper)
    for one, other in (upper[:2], upper[2:]):
        assert one.start[1] == pytest.approx(other.start[1])  # across the same side
        middle = (one.start[0] + other.start[0]) / 2
        ring = pattern.symbol.size / 2 - 3.5
        assert abs(middle) == pytest.approx(ring * pattern.module_mm, abs=1e-6)
    assert len(pattern.front) == 1 + RINGS[version]
    assert_front_and_bars_are_the_region(pattern)


def test_more_bars_than_three_are_refused():
    with pytest.raises(DesignError, match="outside 1 to 3"):
        PatternSpec(bars=4)


def test_slots_are_pinched_at_the_traced_ring_and_at_alignment_patterns_but_not_at_the_upper_finders():
    pattern = made(7, bars=2)
    inside = pattern.symbol.size / 2 * pattern.module_mm - 7 * pattern.module_mm
    upper = [bar for bar in pattern.recessed if bar.start[1] > inside and abs(bar.start[0]) > inside]
    assert [bar.pinched for bar in upper] == [False] * 4
    (bar,) = traced(pattern)
    assert bar.pinched
    assert sum(bar.pinched for bar in pattern.recessed) > 1


@pytest.mark.parametrize("style", ["rounded", "dots", "diamond", "bars"])
def test_styles_have_the_same_front(style):
    pattern = made(style=style)
    assert len(traced(pattern)) == 2
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
    (bar,) = traced(made(bars=1, **settings))
    return np.hypot(*np.subtract(bar.end, bar.start))


def test_the_slot_is_narrow_but_no_narrower_than_a_gap():
    assert slot_mm() == pytest.approx(SLOT * 1.2, abs=0.06)
    assert slot_mm(size_mm=33 * 2.4) == pytest.approx(DARK_MM, abs=0.2)  # a cell
    assert slot_mm(size_mm=33 * 4.0) == pytest.approx(LEAST_SLOT_MODULES * 4.0, abs=0.06)
    assert slot_mm(min_gap_mm=1.0) >= 1.0


def test_a_flush_pattern_has_one_front():
    pattern = build(encode("RECESS", version=2), PatternSpec(finder="panel"))
    assert pattern.recessed == ()
    assert pattern.front == (pattern.region,)


def test_a_bar_that_another_bridge_covers_becomes_flush():
    pattern = made(bars=1)
    (bar,) = traced(pattern)
    over = Bridge(bar.start, bar.end, bar.width_mm, "structural", 0.0)
    more = pattern.with_bridge(over)
    assert traced(more) == []
    assert len(more.front) == len(pattern.front) - 1
    assert more.polygon.buffer(-0.98 * more.spec.web_mm / 2).geom_type == "Polygon"
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
    assert len(traced(pattern)) == 1
    assert_front_and_bars_are_the_region(pattern)


def test_a_round_ring_gets_a_flush_bar():
    symbol = encode("RECESS", version=1)
    scale = 12
    dark = np.kron(symbol.matrix.dark, np.ones((scale, scale), bool))
    y, x = np.mgrid[: 7 * scale, : 7 * scale] - 3.5 * scale + 0.5
    away = np.hypot(x, y) / scale
    dark[-7 * scale :, : 7 * scale] = (away < 1.5) | ((away > 2.5) & (away < 3.5))
    pattern = made(1, Art("freeform", scale, dark))
    assert traced(pattern) == []
    assert_front_and_bars_are_the_region(pattern)


def test_a_bar_that_hangs_in_the_air_is_refused():
    pattern = made()
    astray = Bridge((0.01, 0.02), (1.01, 0.02), 0.8, "function", 0.0, 0.6)
    with pytest.raises(DesignError, match="no straight edge"):
        front_with_bars(pattern.front, [astray])
    with pytest.raises(DesignError, match="pieces are left"):
        front_with_bars(pattern.front, [])
