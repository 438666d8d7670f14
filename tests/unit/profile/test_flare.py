"""Drafted walls: exact volumes, webs kept, short edges that give way."""

from __future__ import annotations

import math

import pytest
from OCP.BRepCheck import BRepCheck_Analyzer

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry.outline import Arc, Circle, Line, Loop, Region
from perfqr_cad.profile import Profile, Walls
from perfqr_cad.profile.flare import Outlines, flared_loops
from perfqr_cad.solid import build_profile
from perfqr_cad.surface import Plane

OUTER = Loop.from_points([(-10, -10), (10, -10), (10, 10), (-10, 10)])
TAN = math.tan(math.radians(10))


def square(x: float, y: float, half: float) -> Loop:
    return Loop.from_points(
        [(x - half, y - half), (x - half, y + half), (x + half, y + half), (x + half, y - half)]
    )


def ell() -> Loop:
    """An L-shaped hole: one re-entrant corner of the hole, rounded."""
    return Loop(
        (
            Line((0, 0), (0, 4)),
            Line((0, 4), (2, 4)),
            Line((2, 4), (2, 2.5)),
            Arc((2, 2.5), (2.5, 2), (2.5, 2.5), ccw=True),
            Line((2.5, 2), (4, 2)),
            Line((4, 2), (4, 0)),
            Line((4, 0), (0, 0)),
        )
    )


def test_a_flared_square_is_a_frustum() -> None:
    region = Region(OUTER, (square(0, 0, 2),))
    solid = build_profile(Profile((region,)), Plane(2.0), Walls(draft_deg=10.0))
    small, large = 16.0, (4 + 4 * TAN) ** 2
    frustum = 2 / 3 * (small + large + math.sqrt(small * large))
    assert solid.valid
    assert solid.volume_mm3 == pytest.approx(800 - frustum, rel=1e-9)


def test_a_lip_stays_straight_before_the_flare() -> None:
    region = Region(OUTER, (Loop((Circle((0, 0), 2.0, ccw=False),)),))
    solid = build_profile(Profile((region,)), Plane(2.0), Walls(draft_deg=10.0, lip_mm=0.5))
    wide = 2 + 1.5 * TAN
    hole = math.pi * (4 * 0.5 + 1.5 / 3 * (4 + 2 * wide + wide**2))
    assert solid.volume_mm3 == pytest.approx(800 - hole, rel=1e-9)
    assert solid.faces == 6 + 2


@pytest.mark.parametrize("draft", [5.0, 12.0, 25.0])
def test_rounded_corners_stay_exact_shrinking_or_oblique(draft: float) -> None:
    """Below half the radius the corner keeps it: an oblique cone; the modeller agrees with the outline."""
    solid = build_profile(Profile((Region(OUTER, (ell(),)),)), Plane(2.0), Walls(draft_deg=draft))
    assert solid.problems == ()
    assert BRepCheck_Analyzer(solid.shape, True).IsValid()
    assert solid.volume_mm3 == pytest.approx(solid.expected_volume_mm3, rel=1e-9)


def test_webs_keep_their_least_width() -> None:
    """A web of 1 mm between two squares: half of what it has over 0.8 mm on either side, the rest
    untouched."""
    region = Region(OUTER, (square(-2.5, 0, 2), square(2.5, 0, 2)))
    left, right = flared_loops([region], 0.35, 0.8)
    assert sorted(left.set_back_mm.tolist()) == pytest.approx([0.1, 0.35, 0.35, 0.35])
    back = Region(OUTER, (left.loop, right.loop))
    assert Outlines.of([back]).webs(1.0).min() == pytest.approx(0.8)
    solid = build_profile(Profile((region,), min_web_mm=0.8), Plane(2.0), Walls(draft_deg=10.0))
    assert solid.valid


def test_holes_that_meet_at_corners_give_way_along_the_mitre() -> None:
    region = Region(OUTER, (square(-1.3, -1.3, 1), square(1.3, 1.3, 1)))
    solid = build_profile(Profile((region,), min_web_mm=0.8), Plane(2.0), Walls(draft_deg=12.0))
    assert solid.valid


def test_a_short_edge_gives_way_instead_of_turning_over() -> None:
    """A step of 0.02 mm in the side of a hole cannot be flared by 0.3 mm between its neighbours."""
    hole = Loop.from_points([(-3, -3), (-3, 3), (0, 3), (0, 2.98), (3, 2.98), (3, -3)])
    solid = build_profile(Profile((Region(OUTER, (hole,)),)), Plane(2.0), Walls(draft_deg=10.0))
    assert solid.valid
    assert solid.volume_mm3 < 800 - 2 * abs(hole.area)


def test_a_draft_with_no_room_at_all_is_refused() -> None:
    thin = tuple(square(x, 0, 2) for x in (-4.2, 0, 4.2))
    frame = Loop.from_points([(-6.4, -2.2), (6.4, -2.2), (6.4, 2.2), (-6.4, 2.2)])
    region = Region(frame, thin)
    with pytest.raises(DesignError, match="no hole can be flared"):
        build_profile(Profile((region,), min_web_mm=0.8), Plane(2.0), Walls(draft_deg=10.0))
    straight = build_profile(
        Profile((region,), min_web_mm=0.8), Plane(2.0), Walls(draft_deg=10.0, or_straight=True)
    )
    assert straight.volume_mm3 == pytest.approx(2 * region.area)
    assert "the walls are straight: no hole can be flared" in straight.notes[0]


@pytest.mark.parametrize(
    "walls", [{"draft_deg": -1.0}, {"draft_deg": 80.0}, {"lip_mm": -0.1}, {"depth_mm": 0.0}]
)
def test_absurd_walls_are_refused(walls: dict[str, float]) -> None:
    with pytest.raises(DesignError):
        Walls(**walls)


def test_a_lip_as_deep_as_the_plate_leaves_nothing_to_flare() -> None:
    with pytest.raises(DesignError, match="nothing to flare"):
        build_profile(
            Profile((Region(OUTER, (square(0, 0, 1),)),)), Plane(2.0), Walls(draft_deg=5.0, lip_mm=2.0)
        )
