"""Volumes from a solid's own faces, against closed forms and the modeller's adaptive integration."""

import math

import numpy as np
import pytest
from OCP.TopoDS import TopoDS

from perfqr_cad.pattern.outline import Bezier, Circle, Loop, Region
from perfqr_cad.solid import occ
from perfqr_cad.solid.assemble import build_region
from perfqr_cad.solid.flux import _fills_its_box, volume_mm3
from perfqr_cad.solid.punch import solid_of
from perfqr_cad.solid.walls import Walls
from perfqr_cad.surface import HeightField, Plane, Sphere

HOLES = (
    Loop.from_points([(-6, -2), (-6, 3), (-1, 3), (-1, -2)]),
    Loop((Circle((4.0, 1.0), 2.5, False),)),
)
REGION = Region(Loop.from_points([(-10, -8), (10, -8), (10, 8), (-10, 8)]), HOLES)
WAVE = HeightField.of(lambda x, y: 0.8 * np.sin(x / 4) * np.cos(y / 5), 12.0, 1.5)


def test_a_plate_is_area_times_thickness():
    shape = build_region(REGION, Plane(1.5)).shape
    assert volume_mm3(shape) == pytest.approx(1.5 * (320 - 25 - math.pi * 2.5**2), rel=1e-12)


@pytest.mark.parametrize("surface", [WAVE, Sphere(30.0, 1.5)], ids=["spline faces", "elementary faces"])
def test_a_curved_panel_has_the_volume_that_the_modeller_finds_adaptively(surface):
    shape = build_region(REGION, surface).shape
    assert volume_mm3(shape) == pytest.approx(occ.volume(shape, 1e-9), rel=2e-7)


def test_ruled_walls_are_integrated_over_their_whole_patch():
    drop = Loop((Bezier((0, 2), (2, 2), (2, -2), (0, -2)), Bezier((0, -2), (-2, -2), (-2, 2), (0, 2))))
    region = Region(REGION.outer, (drop.oriented(ccw=False),))
    shape = build_region(region, Plane(1.5), Walls(draft_deg=10)).shape
    patches = [face for face in map(TopoDS.Face_s, occ.explore(shape, occ.FACE)) if _fills_its_box(face)]
    assert len(patches) == 2
    assert volume_mm3(shape) == pytest.approx(occ.volume(shape, 1e-10), rel=1e-9)


def test_a_part_of_a_spline_is_no_whole_patch():
    shape = build_region(Region(REGION.outer, ()), WAVE).shape
    front, *_ = map(TopoDS.Face_s, occ.explore(shape, occ.FACE))
    assert not _fills_its_box(front)
    assert volume_mm3(shape) == pytest.approx(occ.volume(shape, 1e-9), rel=2e-7)


def test_an_inside_out_solid_is_negative():
    shape = build_region(REGION, WAVE).shape
    assert volume_mm3(shape.Reversed()) == pytest.approx(-volume_mm3(shape), rel=1e-12)


def test_a_wall_turned_over_is_noticed():
    shape = build_region(REGION, WAVE).shape
    faces = [TopoDS.Face_s(face) for face in occ.explore(shape, occ.FACE)]
    turned = solid_of([*faces[:-1], TopoDS.Face_s(faces[-1].Reversed())])
    assert abs(volume_mm3(turned) / volume_mm3(shape) - 1) > 1e-3
