"""Placements: right-handed, of even thickness, isometric where they claim to be, honest about distortion."""

from __future__ import annotations

import math

import numpy as np
import pytest

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry import Triangles
from perfqr_cad.surface import (
    Cone,
    Cylinder,
    DistortionLimit,
    HeightField,
    Placement,
    Plane,
    Revolution,
    Sphere,
)
from perfqr_cad.surface.placement import square

VASE = ((20.0, 0.0), (26.0, 20.0), (30.0, 40.0), (27.0, 60.0), (20.0, 80.0))
PLACEMENTS: dict[str, Placement] = {
    "plane": Plane(2.0),
    "cylinder": Cylinder(30.0, 2.0),
    "sphere": Sphere(40.0, 2.0),
    "cone up": Cone(30.0, 10.0, 2.0),
    "cone down": Cone(30.0, -20.0, 2.0),
    "vase": Revolution(VASE, 40.0, 2.0),
    "saddle": HeightField.of(lambda x, y: (x * x - y * y) / 100, 30.0, 2.0),
}
UV = np.random.default_rng(5).uniform(-10, 10, (40, 2))


@pytest.mark.parametrize("name", PLACEMENTS)
def test_frames_are_right_handed_and_never_mirror(name: str) -> None:
    placement = PLACEMENTS[name]
    frames = placement.frame(UV)
    np.testing.assert_allclose(
        frames @ frames.transpose(0, 2, 1), np.broadcast_to(np.eye(3), (40, 3, 3)), atol=1e-9
    )
    assert (np.linalg.det(frames) > 0).all()
    along_u, along_v = placement.tangents(UV)
    area = np.cross(along_u, along_v)
    area /= np.linalg.norm(area, axis=1)[:, None]
    np.testing.assert_allclose(area, placement.normal(UV), atol=1e-7)


@pytest.mark.parametrize("name", [n for n in PLACEMENTS if n != "saddle"])
def test_depth_is_measured_along_the_normal(name: str) -> None:
    placement = PLACEMENTS[name]
    back = placement.at_depth(UV, 2.0)
    np.testing.assert_allclose(back, placement.point(UV) - 2.0 * placement.normal(UV), atol=1e-9)


@pytest.mark.parametrize("name", ["plane", "cylinder", "cone up", "cone down"])
def test_wraps_keep_arc_lengths(name: str) -> None:
    found = PLACEMENTS[name].distortion(20.0)
    assert found.area_worst < 1e-8
    assert found.shear_worst_deg < 1e-5


def test_the_sphere_distorts_as_the_cosine_of_latitude() -> None:
    found = Sphere(40.0, 2.0).distortion(40.0)
    assert found.area_worst == pytest.approx(1 - math.cos(0.5), rel=1e-6)
    assert found.tilt_worst_deg == pytest.approx(math.degrees(math.acos(math.cos(0.5) ** 2)), rel=1e-6)


def test_the_largest_size_is_named_and_works() -> None:
    cylinder = Cylinder(30.0, 2.0)
    limit = DistortionLimit(tilt_deg=45.0)
    largest = cylinder.largest_size_mm(limit)
    assert largest == pytest.approx(2 * 30 * math.pi / 4, rel=2e-3)
    cylinder.check(largest, limit)
    with pytest.raises(DesignError, match=r"at most 47\.\d+ mm stays within"):
        cylinder.check(60.0, limit)


def test_a_code_that_does_not_fit_is_refused() -> None:
    with pytest.raises(DesignError, match="does not fit"):
        Cylinder(10.0, 1.0).check(70.0)


@pytest.mark.parametrize(
    "make",
    [
        lambda: Plane(0.0),
        lambda: Cylinder(10.0, 12.0),
        lambda: Sphere(-3.0, 1.0),
        lambda: Cone(10.0, 0.0, 1.0),
        lambda: Revolution(VASE[:3], 20.0, 1.0),
        lambda: Revolution(VASE, 90.0, 1.0),
        lambda: HeightField.of(lambda x, y: np.log(x), 10.0, 1.0),
    ],
)
@pytest.mark.filterwarnings("ignore:invalid value encountered in log")
@pytest.mark.filterwarnings("ignore:divide by zero encountered in log")
def test_absurd_walls_are_refused(make: object) -> None:
    with pytest.raises(DesignError):
        make()  # type: ignore[operator]


def test_triangles_know_whether_they_close() -> None:
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    whole = Triangles(corners, faces)
    assert whole.closed
    assert whole.volume_mm3 == pytest.approx(1 / 6)
    assert not Triangles(corners, faces[:3]).closed
    assert not Triangles(corners, np.vstack([faces[:3], faces[3:, ::-1]])).closed
    with pytest.raises(ValueError, match="read-only"):
        whole.vertices[0, 0] = 1.0


@pytest.mark.parametrize(
    ("wall", "radius"),
    [(Cylinder(20.0, 2.0), 20.0), (Sphere(30.0, 2.0), 30.0), (Plane(2.0), math.inf)],
)
def test_the_bend_radius_of_known_walls(wall: Placement, radius: float) -> None:
    assert wall.bend_radius_mm(square(8.0)) == pytest.approx(radius, rel=1e-6)


def test_a_wall_thicker_than_its_bend_is_refused() -> None:
    ridge = ((30.0, 0.0), (31.0, 5.0), (32.0, 8.0), (30.0, 10.0), (30.0, 12.0), (31.0, 20.0))
    assert Revolution(ridge, 8.0, 0.2).check(2.0)
    with pytest.raises(DesignError, match="folds over itself where the surface is bent to a radius of"):
        Revolution(ridge, 8.0, 3.0)
