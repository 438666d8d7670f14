"""Volumes from a solid's own faces, against closed forms and the modeller's adaptive integration."""

import math
from dataclasses import replace

import numpy as np
import pytest

from perfqr_cad.geometry.outline import Bezier, Circle, Loop, Region
from perfqr_cad.profile import Profile
from perfqr_cad.profile.walls import Walls
from perfqr_cad.solid.assemble import build_profile
from perfqr_cad.solid.kernel import occ
from perfqr_cad.solid.kernel.from_shape import brep_of
from perfqr_cad.solid.proof.flux import filled, volume_mm3
from perfqr_cad.solid.tables.batches import Lines, SplineSurfaces
from perfqr_cad.solid.tables.brep import Batch
from perfqr_cad.surface import HeightField, Plane, Sphere

HOLES = (
    Loop.from_points([(-6, -2), (-6, 3), (-1, 3), (-1, -2)]),
    Loop((Circle((4.0, 1.0), 2.5, False),)),
)
REGION = Region(Loop.from_points([(-10, -8), (10, -8), (10, 8), (-10, 8)]), HOLES)
WAVE = HeightField.of(lambda x, y: 0.8 * np.sin(x / 4) * np.cos(y / 5), 12.0, 1.5)


def test_a_plate_is_area_times_thickness():
    brep = build_profile(Profile((REGION,)), Plane(1.5)).brep
    assert volume_mm3(brep) == pytest.approx(1.5 * (320 - 25 - math.pi * 2.5**2), rel=1e-12)


@pytest.mark.parametrize("surface", [WAVE, Sphere(30.0, 1.5)], ids=["spline faces", "elementary faces"])
def test_a_curved_panel_has_the_volume_that_the_modeller_finds_adaptively(surface):
    solid = build_profile(Profile((REGION,)), surface)
    assert volume_mm3(solid.brep) == pytest.approx(occ.volume(solid.shape, 1e-9), rel=2e-7)


def drafted(lip_mm: float = 0.0):
    drop = Loop((Bezier((0, 2), (2, 2), (2, -2), (0, -2)), Bezier((0, -2), (-2, -2), (-2, 2), (0, 2))))
    region = Region(REGION.outer, (drop.oriented(ccw=False),))
    return build_profile(Profile((region,)), Plane(1.5), Walls(draft_deg=10, lip_mm=lip_mm))


def test_ruled_walls_are_integrated_over_their_whole_patch():
    solid = drafted()
    (patches,) = (b for b in solid.brep.surfaces if isinstance(b.of, SplineSurfaces))
    assert filled(solid.brep, patches.rows, patches.of).tolist() == [True, True]
    assert volume_mm3(solid.brep) == pytest.approx(occ.volume(solid.shape, 1e-10), rel=1e-9)


def test_a_part_of_a_spline_is_no_whole_patch():
    """An edge drawn across the middle of its wall: the volume is not known."""
    brep = drafted().brep
    (patches,) = (b for b in brep.surfaces if isinstance(b.of, SplineSurfaces))
    first, *others = brep.images
    half = np.full((len(first.rows), 2), 0.5)
    cut = replace(brep, images=(Batch(first.rows, Lines(first.of.start, half)), *others))
    assert not filled(cut, patches.rows, patches.of).any()
    assert math.isnan(volume_mm3(cut))


@pytest.mark.parametrize("surface", [WAVE, Plane(1.5)])
def test_an_inside_out_solid_is_negative(surface):
    solid = build_profile(Profile((REGION,)), surface)
    inverted = volume_mm3(brep_of(solid.shape.Reversed()))
    assert inverted == pytest.approx(-solid.volume_mm3, rel=1e-7)


def test_a_shape_that_is_read_has_the_same_volume():
    """Its curves and surfaces are the modeller's own."""
    for surface in (WAVE, Sphere(30.0, 1.5), Plane(1.5)):
        solid = build_profile(Profile((REGION,)), surface)
        assert solid.volume_mm3 == pytest.approx(occ.volume(solid.shape, 1e-9), rel=2e-7)
