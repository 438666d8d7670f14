"""Bars that fill only the back of the wall: exact, one piece, seen as a slot from the front."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox
from OCP.gp import gp_Pnt

from perfqr_cad.geometry.outline import Arc, Line, Loop, Region
from perfqr_cad.pattern import Bridge
from perfqr_cad.profile import Profile, Walls
from perfqr_cad.solid import Solid, build_profile, read_step, write_step
from perfqr_cad.solid.kernel import occ
from perfqr_cad.surface import Cone, Cylinder, Placement, Plane, Revolution, Sphere

THICKNESS, HEIGHT = 2.0, 0.6


def square(half: float, radius: float = 0.0, *, ccw: bool = True) -> Loop:
    """A square about the origin, corners rounded."""
    h, r = half, radius
    if not r:
        return Loop.from_points([(-h, -h), (h, -h), (h, h), (-h, h)]).oriented(ccw)
    corners = [(h, -h), (h, h), (-h, h), (-h, -h)]
    loop: list[Line | Arc] = []
    for (x, y), (dx, dy) in zip(corners, [(1, 0), (0, 1), (-1, 0), (0, -1)], strict=True):
        centre = (x - np.sign(x) * r, y - np.sign(y) * r)
        start = (centre[0] + r * dy, centre[1] - r * dx)
        end = (centre[0] + r * dx, centre[1] + r * dy)
        before = loop[-1].end if loop else (-h + r, -h)
        loop += [Line(before, start), Arc(start, end, centre, ccw=True)]
    return Loop(tuple(loop)).oriented(ccw)


def front(radius: float = 0.5) -> tuple[Region, Region]:
    """A plate with a square ring that floats in a slot of 2 mm."""
    return (
        Region(square(12), (square(7, radius, ccw=False),)),
        Region(square(5, radius), (square(3, radius, ccw=False),)),
    )


def bar(*ends: tuple[float, float], width: float = 1.0, height: float | None = HEIGHT) -> Bridge:
    return Bridge(ends[0], ends[1], width, "function", 0.0, height)


BARS = (
    bar((2.0, 5.0), (2.0, 7.0)),
    bar((-5.0, 1.0), (-7.0, 1.0), width=1.2),
    bar((-3.0, 5.0), (-3.0, 7.0)),
)
FLUSH = Region(square(12))
PLACEMENTS: dict[str, Placement] = {
    "plane": Plane(THICKNESS),
    "cylinder": Cylinder(20.0, THICKNESS),
    "cone": Cone(30.0, 10.0, THICKNESS),
    "sphere": Sphere(30.0, THICKNESS),
    "vase": Revolution(((25.0, -15.0), (27.0, -5.0), (26.0, 5.0), (24.0, 15.0)), 0.0, THICKNESS),
}
WALLS = {
    "straight": Walls(),
    "drafted": Walls(draft_deg=5.0),
    "lipped": Walls(draft_deg=5.0, lip_mm=0.5),
    "lip below the bars": Walls(draft_deg=3.0, lip_mm=1.6),
}


def build_front(
    front: tuple[Region, ...],
    bars: tuple[Bridge, ...],
    placement: Placement,
    walls: Walls | None = None,
    name: str = "part",
) -> Solid:
    return build_profile(Profile(front, bars, FLUSH), placement, walls, name=name)


@pytest.mark.parametrize("walls", WALLS)
@pytest.mark.parametrize("name", PLACEMENTS)
def test_bars_behind_the_face_are_exact(name: str, walls: str) -> None:
    solid = build_front(front(), BARS, PLACEMENTS[name], WALLS[walls])
    assert solid.problems == ()
    assert solid.notes == ()
    assert solid.triangles.closed
    assert BRepCheck_Analyzer(solid.shape, True).IsValid()
    assert solid.triangles.volume_mm3 == pytest.approx(solid.volume_mm3, rel=5e-4)


def test_the_volume_is_front_through_and_bars_behind() -> None:
    solid = build_front(front(0.0), BARS, Plane(THICKNESS))
    area = sum(region.area for region in front(0.0))
    lengths = sum(2.0 * b.width_mm for b in BARS)
    assert solid.volume_mm3 == pytest.approx(area * THICKNESS + lengths * HEIGHT, rel=1e-12)
    low, high = solid.bbox_mm
    assert (low, high) == (pytest.approx((-12, -12, 0), abs=1e-9), pytest.approx((12, 12, 2), abs=1e-9))


def test_it_equals_boxes_cut_and_fused() -> None:
    """What is left of the plate when all air is cut away one box at a time."""
    solid = build_front(front(0.0), BARS[:1], Plane(THICKNESS))

    def box(x: tuple[float, float], y: tuple[float, float], z: tuple[float, float]) -> object:
        return BRepPrimAPI_MakeBox(gp_Pnt(x[0], y[0], z[0]), gp_Pnt(x[1], y[1], z[1])).Shape()

    through = (-1.0, 3.0)
    air = [box((-3, 3), (-3, 3), through)]
    air += [box(x, (-7, 7), through) for x in ((-7, -5), (5, 7))]
    air += [box((-5, 5), (-7, -5), through), box((-5, 1.5), (5, 7), through), box((2.5, 5), (5, 7), through)]
    air += [box((1.5, 2.5), (5, 7), (THICKNESS - (THICKNESS - HEIGHT), 3.0))]
    brute = box((-12, 12), (-12, 12), (0, THICKNESS))
    for piece in air:
        brute = BRepAlgoAPI_Cut(brute, piece).Shape()
    for one, other in ((solid.shape, brute), (brute, solid.shape)):
        assert abs(occ.volume(BRepAlgoAPI_Cut(one, other).Shape())) < 1e-6 * solid.volume_mm3


def test_a_slanted_bar_between_drafted_walls() -> None:
    """Its sides stay planes: each level is cut where the bar's own sides meet it."""
    slanted = (bar((1.0, 5.0), (2.0, 7.0)),)
    solid = build_front(front(), slanted, Plane(THICKNESS), Walls(draft_deg=6.0))
    assert solid.valid
    assert solid.volume_mm3 == pytest.approx(solid.expected_volume_mm3, rel=1e-9)


@pytest.mark.parametrize("radius", [0.0, 0.3])
def test_a_bar_by_the_corner_of_a_drafted_edge_stands(radius: float) -> None:
    """The side next to it gives way less, so that its edge stays long enough for the bar."""
    near = (bar((5.0 - radius - 0.6, 5.0), (5.0 - radius - 0.6, 7.0)),)
    solid = build_front(front(radius), near, Plane(THICKNESS), Walls(draft_deg=10.0))
    assert solid.notes == ()
    assert solid.problems == ()


def test_two_pieces_side_by_side() -> None:
    """Outlines that are joined: neither lies in a hole of the other."""
    left = Region(Loop.from_points([(-5, -5), (0, -5), (0, 5), (-5, 5)]))
    right = Region(Loop.from_points([(2, -5), (7, -5), (7, 5), (2, 5)]))
    for walls in WALLS.values():
        solid = build_front((left, right), (bar((0.0, 0.0), (2.0, 0.0)),), Plane(THICKNESS), walls)
        assert solid.valid, solid.problems
        assert solid.triangles.closed


@pytest.mark.parametrize(
    ("bars", "thickness", "reason"),
    [
        ((bar((2.0, 5.0), (2.0, 7.0), height=1.7),), 2.0, "leave no slot"),
        ((bar((4.5, 4.9), (4.5, 7.0)),), 2.0, "on a straight edge"),
        ((bar((4.2, 5.0), (4.2, 7.0)),), 2.0, "meets a corner"),
        ((bar((2.0, 5.0), (6.4, 7.0)),), 2.0, "lies along its edge"),
    ],
)
def test_bars_that_cannot_be_recessed_are_flush(
    bars: tuple[Bridge, ...], thickness: float, reason: str
) -> None:
    solid = build_front(front(), bars, Plane(thickness))
    assert reason in solid.notes[0]
    assert solid.valid
    assert solid.volume_mm3 == pytest.approx(FLUSH.area * thickness)


@pytest.mark.parametrize("name", PLACEMENTS)
def test_rings_stand_on_the_floor_of_pockets(name: str) -> None:
    solid = build_front(front(), BARS, PLACEMENTS[name], Walls(depth_mm=1.0))
    assert solid.problems == ()
    assert solid.triangles.closed
    assert BRepCheck_Analyzer(solid.shape, True).IsValid()
    if name == "plane":
        area = sum(region.area for region in front())
        assert solid.volume_mm3 == pytest.approx(24 * 24 * 1.0 + area * 1.0, rel=1e-12)


def test_step_is_read_back(tmp_path: Path) -> None:
    for name, placement in PLACEMENTS.items():
        solid = build_front(front(), BARS, placement, WALLS["lipped"], name=name)
        write_step(solid, tmp_path / "part.step")
        (part,) = read_step(tmp_path / "part.step")
        assert part.name == name
        assert occ.count(part.shape, occ.FACE) == solid.faces
        assert occ.volume(part.shape, 1e-7) == pytest.approx(solid.volume_mm3, rel=1e-6)
        assert BRepCheck_Analyzer(part.shape, True).IsValid()
