"""Random outlines, walls and placements: sound solids of the right volume, or a refusal that says why."""

from __future__ import annotations

import math

import hypothesis.strategies as st
import pytest
from hypothesis import given, settings
from OCP.BRepCheck import BRepCheck_Analyzer

from perfqr_cad.errors import DesignError, KernelError
from perfqr_cad.geometry.outline import Arc, Bezier, Circle, Line, Loop, Region, Segment
from perfqr_cad.pattern import Bridge
from perfqr_cad.profile import Profile, Walls
from perfqr_cad.solid import build_profile
from perfqr_cad.surface import Cone, Cylinder, Placement, Plane, Sphere

CELL_MM = 2.0
CELLS = 4  # on a side
HALF_MM = CELLS * CELL_MM / 2 + 1.0
FRAME = Loop.from_points([(-HALF_MM, -HALF_MM), (HALF_MM, -HALF_MM), (HALF_MM, HALF_MM), (-HALF_MM, HALF_MM)])

quick = settings(max_examples=12, deadline=None)


def square(x: float, y: float, half: float) -> Loop:
    return Loop.from_points(
        [(x - half, y - half), (x - half, y + half), (x + half, y + half), (x + half, y - half)]
    )


def rounded(x: float, y: float, half: float) -> Loop:
    """A square with two rounded corners, one of them re-entrant."""
    r, h = half / 2, half
    return Loop(
        (
            Line((x - h, y - h), (x - h, y + h - r)),
            Arc((x - h, y + h - r), (x - h + r, y + h), (x - h + r, y + h - r), ccw=False),
            Line((x - h + r, y + h), (x + h, y + h)),
            Line((x + h, y + h), (x + h, y - h + r)),
            Arc((x + h, y - h + r), (x + h - r, y - h), (x + h, y - h), ccw=True),
            Line((x + h - r, y - h), (x - h, y - h)),
        )
    )


def dot(x: float, y: float, half: float) -> Loop:
    return Loop((Circle((x, y), half, ccw=False),))


def leaf(x: float, y: float, half: float) -> Loop:
    low, high = (x, y - half), (x, y + half)
    return Loop(
        (
            Bezier(low, (x - half, y - half), (x - half, y + half), high),
            Bezier(high, (x + half, y + half), (x + half, y - half), low),
        )
    )


@st.composite
def regions(draw: st.DrawFn) -> Region:
    """A frame with holes of several kinds in the cells of a grid."""
    cells = [(c, r) for c in range(CELLS) for r in range(CELLS)]
    chosen = draw(st.lists(st.sampled_from(cells), unique=True, max_size=7))
    holes: list[Loop] = []
    for column, row in chosen:
        kind = draw(st.sampled_from([square, rounded, dot, leaf]))
        x, y = ((k + 0.5 - CELLS / 2) * CELL_MM for k in (column, row))
        holes.append(kind(x, y, draw(st.floats(0.3, 0.75))))
    return Region(FRAME, tuple(holes))


placements = st.one_of(
    st.builds(Plane, st.just(2.0)),
    st.builds(Cylinder, st.floats(12.0, 80.0), st.just(2.0)),
    st.builds(Sphere, st.floats(15.0, 80.0), st.just(2.0)),
    st.builds(Cone, st.floats(20.0, 60.0), st.floats(-20.0, 20.0).filter(lambda a: abs(a) > 1), st.just(2.0)),
)
walls = st.one_of(
    st.just(Walls()),
    st.builds(Walls, draft_deg=st.floats(0.5, 12.0), lip_mm=st.floats(0.0, 1.9)),
    st.builds(Walls, depth_mm=st.floats(0.2, 1.8)),
    st.builds(Walls, draft_deg=st.floats(0.5, 8.0), depth_mm=st.floats(0.5, 1.8)),
)


@quick
@given(regions(), placements, walls)
def test_any_panel_is_sound(region: Region, placement: Placement, wall: Walls) -> None:
    """The proof holds every solid against the closed form of its volume and the number of its holes."""
    try:
        solid = build_profile(Profile((region,), min_web_mm=0.3), placement, wall)
    except DesignError:  # too little room to flare, said in one line: nothing is built
        assert wall.draft_deg > 0
        return
    assert solid.problems == ()
    assert solid.triangles.closed
    assert BRepCheck_Analyzer(solid.shape, True).IsValid()
    assert solid.triangles.volume_mm3 == pytest.approx(solid.volume_mm3, rel=2e-3)
    if placement.is_flat and not wall.draft_deg:
        depth = wall.depth_mm or 2.0
        exact = region.area * depth + FRAME.area * (2.0 - depth)
        assert solid.volume_mm3 == pytest.approx(exact, rel=1e-9)


@quick
@given(
    placements,
    st.builds(Walls, draft_deg=st.floats(0.0, 8.0), lip_mm=st.floats(0.0, 1.8)),
    st.lists(
        st.tuples(st.sampled_from("NESW"), st.floats(-1.2, 1.2)),
        min_size=1,
        max_size=4,
        unique_by=lambda b: b[0],
    ),
    st.floats(0.4, 0.9),
    st.floats(0.3, 1.6),
)
def test_any_recessed_ring_is_sound(
    placement: Placement, wall: Walls, sides: list[tuple[str, float]], width: float, height: float
) -> None:
    """A ring held by one to four bars, on any of its sides."""
    slot = Region(FRAME, (square(0, 0, 3.2),))
    ring = Region(square(0, 0, 2.2).reversed(), (square(0, 0, 1.0),))
    turn = {"N": (0, 1), "E": (1, 0), "S": (0, -1), "W": (-1, 0)}
    bars: list[Bridge] = []
    for side, along in sides:
        dx, dy = turn[side]
        start, end = ((dx * r + dy * along, dy * r + dx * along) for r in (2.2, 3.2))
        bars.append(Bridge(start, end, width, "function", 0.0, height))
    solid = build_profile(Profile((slot, ring), tuple(bars), slot, 0.3), placement, wall)
    assert solid.problems == ()
    assert solid.notes == ()
    assert solid.triangles.closed
    if placement.is_flat and not wall.draft_deg:
        exact = (slot.area + ring.area) * 2.0 + len(bars) * width * height
        assert solid.volume_mm3 == pytest.approx(exact, rel=1e-9)


@quick
@given(regions(), placements, st.integers(0, 100), st.sampled_from(["zero", "gap", "nan"]))
def test_a_broken_outline_is_refused_in_our_words(
    region: Region, placement: Placement, where: int, flaw: str
) -> None:
    """No exception of the modeller, no solid: segments without length, gaps, numbers that are none."""
    segments: list[Segment] = list(region.outer.segments)
    k = where % len(segments)
    corner = segments[k].start
    match flaw:
        case "zero":
            segments.insert(k, Line(corner, corner))
        case "gap":
            segments[k] = Line((corner[0], corner[1] + 1e-3), segments[k].end)
        case _:
            segments[k] = Line(corner, (math.nan, 0.0))
    with pytest.raises(KernelError, match="outline"):
        build_profile(Profile((Region(Loop(tuple(segments)), region.holes),)), placement)
