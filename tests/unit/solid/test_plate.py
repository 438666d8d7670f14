"""A plate with square, rounded, round and free-form holes: exact, valid, closed."""

from __future__ import annotations

import math

import numpy as np
import pytest
from OCP.BRepCheck import BRepCheck_Analyzer

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry import triangulation
from perfqr_cad.geometry.outline import Arc, Bezier, Circle, Line, Loop, Region
from perfqr_cad.profile import Profile, Walls
from perfqr_cad.solid import build_profile
from perfqr_cad.surface import Plane


def square(x: float, y: float, half: float) -> Loop:
    corners = [(x - half, y - half), (x - half, y + half), (x + half, y + half), (x + half, y - half)]
    return Loop.from_points(corners)


def slot(x: float, y: float, half: float, radius: float) -> Loop:
    """A stadium about (x, y), clockwise: two lines and two half-circles."""
    left, right, low, high = x - half, x + half, y - radius, y + radius
    return Loop(
        (
            Line((left, high), (right, high)),
            Arc((right, high), (right, low), (right, y), ccw=False),
            Line((right, low), (left, low)),
            Arc((left, low), (left, high), (left, y), ccw=False),
        )
    )


def dot(x: float, y: float, radius: float) -> Loop:
    return Loop((Circle((x, y), radius, ccw=False),))


def leaf(x: float, y: float) -> Loop:
    return Loop(
        (
            Bezier((x, y - 1), (x - 2, y - 1), (x - 2, y + 1), (x, y + 1)),
            Bezier((x, y + 1), (x + 2, y + 1), (x + 2, y - 1), (x, y - 1)),
        )
    )


def region(*holes: Loop) -> Region:
    return Region(Loop.from_points([(-10, -10), (10, -10), (10, 10), (-10, 10)]), holes)


HOLES = {
    "none": (),
    "square": (square(1, 2, 1.5),),
    "slot": (slot(-3, 4, 1.0, 0.7),),
    "dot": (dot(4, -4, 2.0),),
    "leaf": (leaf(0, 0),),
    "all": (square(5, 5, 1), slot(-5, 5, 1, 0.5), dot(-5, -5, 1.5), leaf(5, -5)),
}


@pytest.mark.parametrize("name", HOLES)
def test_a_plate_is_exact(name: str) -> None:
    plate = region(*HOLES[name])
    solid = build_profile(Profile((plate,)), Plane(2.0))
    assert solid.problems == ()
    assert solid.valid
    assert solid.solids == 1
    assert solid.volume_mm3 == pytest.approx(plate.area * 2.0, rel=1e-9)
    assert BRepCheck_Analyzer(solid.shape, True).IsValid()


@pytest.mark.parametrize("name", HOLES)
def test_triangles_close_and_keep_the_chord(name: str) -> None:
    plate = region(*HOLES[name])
    solid = build_profile(Profile((plate,)), Plane(2.0), chord_mm=0.002)
    assert solid.triangles.closed
    perimeter = sum(loop.length for loop in plate.loops)
    assert solid.triangles.volume_mm3 == pytest.approx(solid.volume_mm3, abs=2.0 * 0.002 * perimeter)


def test_walls_of_lines_are_planes_and_of_circles_one_cylinder() -> None:
    assert build_profile(Profile((region(square(0, 0, 1)),)), Plane(2.0)).faces == 6 + 4
    assert build_profile(Profile((region(dot(0, 0, 1)),)), Plane(2.0)).faces == 6 + 1


@pytest.mark.parametrize("name", HOLES)
def test_blind_pockets_keep_a_floor(name: str) -> None:
    plate = region(*HOLES[name])
    solid = build_profile(Profile((plate,)), Plane(2.0), Walls(depth_mm=0.75))
    assert solid.valid
    holes = plate.outer.area - plate.area
    assert solid.volume_mm3 == pytest.approx(plate.outer.area * 2.0 - holes * 0.75, rel=1e-9)
    assert BRepCheck_Analyzer(solid.shape, True).IsValid()
    assert solid.triangles.closed


def test_a_pocket_as_deep_as_the_plate_is_refused() -> None:
    with pytest.raises(DesignError, match="no floor"):
        build_profile(Profile((region(square(0, 0, 1)),)), Plane(2.0), Walls(depth_mm=2.0))


def test_the_reader_sees_the_pattern_unmirrored() -> None:
    """A hole up and to the right stays there, seen from +z."""
    solid = build_profile(Profile((region(square(6, 7, 1)),)), Plane(2.0))
    low, high = solid.bbox_mm
    assert (low[2], high[2]) == pytest.approx((0.0, 2.0), abs=1e-6)
    inner = solid.triangles.vertices[(abs(solid.triangles.vertices) < 9.5)[:, :2].all(axis=1)]
    assert inner[:, 0].min() == pytest.approx(5.0)
    assert inner[:, 1].max() == pytest.approx(8.0)
    assert math.isclose(inner[:, 2].max(), 2.0)


@pytest.mark.parametrize("seed", range(3))
def test_large_faces_are_cut_by_patches_as_small_ones_are_whole(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Dots, squares and slots in a grid: the same area in as many triangles, none flat, all corners used."""
    kinds = [lambda x, y: square(x, y, 0.6), lambda x, y: dot(x, y, 0.7), lambda x, y: slot(x, y, 0.3, 0.4)]
    kinds.append(lambda x, y: Loop.from_points([(x - 0.7, y), (x, y + 0.01), (x + 0.7, y), (x, y - 0.01)]))
    chosen = np.random.default_rng(seed).integers(len(kinds), size=81)
    holes = [kinds[k](2.0 * (i % 9) - 8, 2.0 * (i // 9) - 8) for i, k in enumerate(chosen.tolist())]
    polygons = [loop.flatten() for loop in region(*holes).loops]
    points = np.vstack(polygons)
    cut: list[np.ndarray] = []
    for many in (0, len(points)):
        monkeypatch.setattr(triangulation, "MANY", many)
        faces = triangulation.delaunay(polygons)
        a, b, c = (points[faces[:, k]] for k in range(3))
        areas = ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2
        assert areas.min() > 0
        assert len(np.unique(faces)) == len(points)
        cut.append(areas)
    assert len(cut[0]) == len(cut[1])
    assert cut[0].sum() == pytest.approx(cut[1].sum(), rel=1e-12)
