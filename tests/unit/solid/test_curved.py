"""Panels on curved walls: valid, of the volume that the outline gives, closed when meshed."""

from __future__ import annotations

import numpy as np
import pytest
from OCP.BRepCheck import BRepCheck_Analyzer

from perfqr_cad.geometry.outline import Arc, Bezier, Circle, Line, Loop, Region
from perfqr_cad.profile import Profile, Walls
from perfqr_cad.solid import build_profile
from perfqr_cad.surface import Cone, Cylinder, HeightField, Placement, Revolution, Sphere

VASE = ((20.0, 0.0), (26.0, 20.0), (30.0, 40.0), (27.0, 60.0), (20.0, 80.0))
WALLS: dict[str, Placement] = {
    "cylinder": Cylinder(30.0, 2.0),
    "sphere": Sphere(40.0, 2.0),
    "cone": Cone(30.0, -20.0, 2.0),
    "vase": Revolution(VASE, 40.0, 2.0),
    "free form": HeightField.of(
        lambda x, y: -(x * x + y * y) / 100 + 0.3 * np.sin(x / 5), 12.0, 2.0, samples=17
    ),
}
HOLES = (
    Loop.from_points([(-1, -1), (-1, 1), (1, 1), (1, -1)]),
    Loop((Circle((-5.0, 5.0), 1.5, ccw=False),)),
    Loop(
        (
            Line((4, 6), (6, 6)),
            Arc((6, 6), (6, 4), (6, 5), ccw=False),
            Line((6, 4), (4, 4)),
            Arc((4, 4), (4, 6), (4, 5), ccw=False),
        )
    ),
    Loop((Bezier((5, -6), (3, -6), (3, -4), (5, -4)), Bezier((5, -4), (7, -4), (7, -6), (5, -6)))),
)
REGION = Region(Loop.from_points([(-10, -10), (10, -10), (10, 10), (-10, 10)]), HOLES)
CASES = {"straight": Walls(), "pockets": Walls(depth_mm=0.75), "flared": Walls(draft_deg=8.0, lip_mm=0.4)}


@pytest.mark.parametrize("walls", CASES)
@pytest.mark.parametrize("name", WALLS)
def test_a_curved_panel_is_valid(name: str, walls: str) -> None:
    solid = build_profile(Profile((REGION,)), WALLS[name], CASES[walls], chord_mm=0.02)
    assert solid.problems == ()
    assert BRepCheck_Analyzer(solid.shape, True).IsValid()
    assert solid.expected_volume_mm3 is not None
    assert solid.volume_mm3 == pytest.approx(solid.expected_volume_mm3, rel=1e-6)
    assert solid.triangles.closed
    assert solid.triangles.volume_mm3 == pytest.approx(solid.volume_mm3, rel=2e-3)


def test_a_wrapped_panel_has_the_closed_form_volume() -> None:
    """A · t · (R − t/2) / R, and two spherical radii likewise."""
    solid = build_profile(Profile((REGION,)), Cylinder(30.0, 2.0))
    assert solid.volume_mm3 == pytest.approx(REGION.area * 2.0 * 29.0 / 30.0, rel=1e-7)


def test_grid_lines_stand_in_planes_and_cones() -> None:
    """A square hole on a sphere: two planes through the axis, two cones, no splines."""
    from OCP.BRepAdaptor import BRepAdaptor_Surface
    from OCP.TopoDS import TopoDS

    from perfqr_cad.solid.kernel.occ import FACE, explore

    region = Region(REGION.outer, HOLES[:1])
    kinds = sorted(
        BRepAdaptor_Surface(TopoDS.Face_s(f)).GetType().name.removeprefix("GeomAbs_")
        for f in explore(build_profile(Profile((region,)), Sphere(40.0, 2.0)).shape, FACE)
    )
    assert kinds == ["Cone"] * 4 + ["Plane"] * 4 + ["Sphere"] * 2


@pytest.mark.parametrize("name", ["cylinder", "sphere", "cone"])
def test_meshes_keep_the_chord(name: str) -> None:
    """The middles of all triangles of the front lie within the tolerance of it, inwards."""
    wall = WALLS[name]
    mesh = build_profile(Profile((Region(REGION.outer, HOLES[:1]),)), wall, chord_mm=0.02).triangles
    front = _inside(wall, mesh.vertices) < 1e-9
    faces = mesh.faces[front[mesh.faces].all(axis=1)]
    depth = _inside(wall, mesh.vertices[faces].mean(axis=1))
    assert len(faces) > 20
    assert depth.min() > -1e-9
    assert depth.max() < 0.02


def _inside(wall: Placement, points: np.ndarray) -> np.ndarray:
    """Distance of points behind the front surface, mm."""
    match wall:
        case Cylinder(radius, _):
            return radius - np.hypot(points[:, 0], points[:, 2])
        case Sphere(radius, _):
            return radius - np.linalg.norm(points, axis=1)
        case Cone():
            angle = wall.half_angle_rad
            at = wall.radius_mm - wall.upward * points[:, 1] * np.tan(angle)
            return (at - np.hypot(points[:, 0], points[:, 2])) * np.cos(angle)
        case _:
            raise ValueError(wall)
