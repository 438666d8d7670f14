"""Contours by the non-zero rule: crossings, nests and touches, with curves kept where they can be."""

from __future__ import annotations

import math
from itertools import combinations

import pytest
import shapely

from perfqr_cad.geometry import Bezier, Line, Loop, Region, winding
from perfqr_cad.geometry.winding import GAP_MM, united

KAPPA = 4 / 3 * math.tan(math.pi / 8)  # of a Bézier that is nearly a quarter of a circle


def box(x: float, y: float, size: float, *, ccw: bool = True) -> Loop:
    return Loop.from_points([(x, y), (x + size, y), (x + size, y + size), (x, y + size)]).oriented(ccw)


def disc(x: float, y: float, r: float, *, ccw: bool = True) -> Loop:
    k = KAPPA * r
    corners = [(r, 0), (0, r), (-r, 0), (0, -r)]
    quarters: list[Bezier] = []
    for (ax, ay), (bx, by) in zip(corners, corners[1:] + corners[:1], strict=True):
        c1 = (x + ax - k * ay / r, y + ay + k * ax / r)
        c2 = (x + bx + k * by / r, y + by - k * bx / r)
        quarters.append(Bezier((x + ax, y + ay), c1, c2, (x + bx, y + by)))
    return Loop(tuple(quarters)).oriented(ccw)


def require_sound(regions: tuple[Region, ...]) -> None:
    """Valid regions whose loops are apart."""
    assert all(region.polygon(0.001).is_valid and region.area > 0 for region in regions)
    rings = [shapely.LinearRing(loop.flatten()) for region in regions for loop in region.loops]
    assert all(a.distance(b) > 0 for a, b in combinations(rings, 2))


@pytest.mark.parametrize("ccw", [True, False])
def test_nested_contours_that_turn_about_are_open_and_filled_by_turns(ccw: bool) -> None:
    """To any depth, whichever way the font begins."""
    contours = [box(k, k, 20 - 2 * k, ccw=ccw == (k % 2 == 0)) for k in range(6)]
    regions = united(contours)
    assert [len(region.holes) for region in regions] == [1, 1, 1]
    assert sorted(region.area for region in regions) == pytest.approx([44, 60, 76])
    require_sound(regions)


def test_a_contour_within_another_of_the_same_sense_is_no_hole() -> None:
    (region,) = united([box(0, 0, 9), box(3, 3, 3)])
    assert (len(region.holes), region.area) == (0, 81)


def test_a_hole_in_two_contours_is_closed_and_one_in_one_is_open() -> None:
    """Turns are counted: 1 + 1 - 1 is inside, 1 - 1 is not."""
    (filled,) = united([box(0, 0, 9), box(1, 1, 7), box(3, 3, 3, ccw=False)])
    (open_,) = united([box(0, 0, 9), box(3, 3, 3, ccw=False)])
    assert (filled.area, open_.area) == (81, 72)


def test_contours_that_cross_are_united_and_leave_others_open() -> None:
    contours = [box(0, 0, 9), box(2, 2, 3, ccw=False), box(8, 3, 3)]
    (region,) = united(contours)
    assert region.area == pytest.approx(81 - 9 + 9 - 3)
    assert len(region.holes) == 1


def test_a_contour_that_crosses_itself_is_filled_by_its_turns() -> None:
    """A pentagram's core is gone round twice: filled, though the even-odd rule would leave it open."""
    star = Loop.from_points(
        [(10 * math.sin(4 * math.pi * k / 5), 10 * math.cos(4 * math.pi * k / 5)) for k in range(5)]
    )
    (region,) = united([star])
    core = 10 * math.cos(2 * math.pi / 5) / math.cos(math.pi / 5)
    assert region.area == pytest.approx(5 * 10 * core * math.sin(math.pi / 5), rel=1e-6)
    assert region.holes == ()


def test_curves_stay_curves_where_they_cross() -> None:
    (region,) = united([disc(0, 0, 2), disc(1, 0, 2)])
    half = math.acos(0.5 / 2)
    lens = 2 * (4 * half - 0.5 * math.sqrt(4 - 0.25))
    assert region.area == pytest.approx(8 * math.pi - lens, rel=1e-3)  # a Bézier is no circle
    assert sum(isinstance(segment, Bezier) for segment in region.segments()) == len(region.outer.segments)
    assert len(region.outer.segments) < 12


def test_what_lies_apart_is_not_touched() -> None:
    contours = [disc(0, 0, 2), disc(0, 0, 1, ccw=False), box(5, 5, 1)]
    assert {loop for region in united(contours) for loop in region.loops} == set(contours)


@pytest.mark.parametrize(
    "contours",
    [
        [box(0, 0, 2), box(2, 2, 2)],  # corner to corner
        [box(0, 0, 2), box(2, 0, 2)],  # side by side
        [box(0, 0, 2), box(2 + GAP_MM / 2, 0, 2)],  # a gap that nothing prints
        [box(0, 0, 6), box(0, 2, 2, ccw=False)],  # a hole that comes to the edge
        [box(0, 0, 6), box(1, 1, 2, ccw=False), box(3, 3, 2, ccw=False)],  # two holes, corner to corner
        [Loop.from_points([(0, 0), (2, 2), (4, 0), (4, 4), (2, 2), (0, 4)])],  # an hourglass
    ],
)
def test_what_touches_is_parted_or_joined(contours: list[Loop]) -> None:
    regions = united(contours)
    require_sound(regions)
    drawn = shapely.union_all([region.polygon() for region in regions])
    assert drawn.area == pytest.approx(abs(sum(contour.area for contour in contours)), abs=0.2)


def test_a_witness_stands_by_when_path_operations_fail(monkeypatch: pytest.MonkeyPatch) -> None:
    contours = [disc(0, 0, 2), disc(1, 0, 2), disc(0.5, 0, 0.5, ccw=False), disc(0.5, 0, 0.7, ccw=False)]
    (right,) = united(contours)
    for wrong in ((), (disc(0, 0, 2),), (box(0, 0, 1), box(1, 1, 1))):
        monkeypatch.setattr(winding, "_simplified", lambda _, loops=wrong: loops)
        (region,) = united(contours)
        assert region.area == pytest.approx(right.area, rel=2e-3)
        assert len(region.holes) == len(right.holes) == 1
        require_sound((region,))


def test_a_curve_that_comes_back_to_its_start_is_a_loop() -> None:
    import pathops

    path = pathops.Path()
    path.moveTo(0, 0)
    path.cubicTo(4, 4, -4, 4, 0, 0)
    path.close()
    (loop,) = winding.loops_of(path)
    assert all(isinstance(segment, Line) for segment in loop.segments)
    assert abs(loop.area) == pytest.approx(abs(Bezier((0, 0), (4, 4), (-4, 4), (0, 0)).moment()), rel=1e-2)


def test_specks_are_left_out() -> None:
    assert united([box(0, 0, 4), box(1, 1, GAP_MM / 2, ccw=False), box(9, 9, GAP_MM / 2)]) == (
        Region(box(0, 0, 4)),
    )
