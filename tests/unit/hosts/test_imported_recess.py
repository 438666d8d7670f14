"""Recessed finder bars in walls that are not ours: solids and meshes, straight and flared."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from build123d import Box, Cylinder, Sphere

from perfqr_cad.errors import DesignError
from perfqr_cad.hosts.mesh import MeshTarget
from perfqr_cad.hosts.step import ImportedFace, mesh_shape
from perfqr_cad.pattern import Pattern, PatternSpec, build
from perfqr_cad.profile import Walls
from perfqr_cad.solid.kernel import booleans as kernel
from perfqr_cad.symbol import encode

SIZE_MM = 36.0
HOSTS = {
    "plate": (lambda: Box(50, 2, 50), (0, -1, 0), False),
    "ring": (lambda: Cylinder(40, 50) - Cylinder(38, 50), (0, -40, 0), True),
    "ball": (lambda: Sphere(45) - Sphere(43), (0, -45, 0), False),
}


@lru_cache(maxsize=2)
def pattern(finder: str) -> Pattern:
    spec = PatternSpec(size_mm=SIZE_MM, quiet_modules=2, nozzle_mm=0.3, finder=finder)
    return build(encode("BAR", version=1), spec)


def slots_mm3(thickness_mm: float) -> float:
    """Volume before the bars of a plate."""
    bars = pattern("recessed").recessed
    lengths = [np.hypot(*np.subtract(bar.end, bar.start)) for bar in bars]
    return sum(
        bar.width_mm * length * (thickness_mm - bar.height_mm)
        for bar, length in zip(bars, lengths, strict=True)
    )


@pytest.mark.parametrize("walls", [Walls(), Walls(draft_deg=8, lip_mm=0.4)], ids=["straight", "flared"])
@pytest.mark.parametrize("host", HOSTS)
def test_rings_are_held_behind_the_face(host, walls):
    shape, point, wrap = HOSTS[host]
    target = ImportedFace.of(shape(), point=point, wrap=wrap)
    solid = target.solid(pattern("recessed"), target.placement(SIZE_MM), walls)
    assert solid.notes == ()
    assert kernel.is_valid(solid.shape)
    assert solid.triangles.closed
    assert solid.volume_mm3 == pytest.approx(solid.triangles.volume_mm3, rel=2e-3)


def test_the_slots_before_the_bars_are_missing():
    target = ImportedFace.of(Box(50, 2, 50), point=(0, -1, 0))
    solid = target.solid(pattern("recessed"), target.placement(SIZE_MM), Walls())
    flush = 50 * 50 * 2 - sum(-hole.area for hole in pattern("recessed").region.holes) * 2
    assert solid.volume_mm3 == pytest.approx(flush - slots_mm3(2.0), rel=1e-9)


def test_a_mesh_has_the_same_bars():
    plate = mesh_shape(Box(50, 2, 50))
    target = MeshTarget.of(plate, point=(0, -1, 0))
    placed = target.placement(SIZE_MM)
    solid = target.solid(pattern("recessed"), placed, Walls())
    barred = pattern("recessed")
    flush = target.solid(replace(barred, front=(barred.region,), bridges=()), placed, Walls())
    assert solid.notes == ()
    assert flush.volume_mm3 - solid.volume_mm3 == pytest.approx(slots_mm3(2.0), rel=1e-3)


def test_bars_are_flush_where_there_is_no_room():
    thin = 0.7
    target = ImportedFace.of(Box(50, thin, 50), point=(0, -thin / 2, 0))
    solid = target.solid(pattern("recessed"), target.placement(SIZE_MM), Walls())
    assert "no slot" in solid.notes[0]
    assert solid.valid


def test_rings_in_pockets_stand_on_the_floor():
    walls = Walls(depth_mm=0.8)
    target = ImportedFace.of(Box(50, 2, 50), point=(0, -1, 0))
    solid = target.solid(pattern("recessed"), target.placement(SIZE_MM, walls.depth_mm), walls)
    assert solid.notes == ()
    assert solid.valid
    assert solid.solids == 1
    cut = SIZE_MM**2 - sum(region.area for region in pattern("recessed").front)
    assert solid.volume_mm3 == pytest.approx(50 * 2 * 50 - 0.8 * cut, rel=1e-6)


def test_dark_material_leaves_no_light_margin_in_a_wall():
    target = ImportedFace.of(Box(50, 2, 50), point=(0, -1, 0))
    spec = PatternSpec(size_mm=SIZE_MM, quiet_modules=2, nozzle_mm=0.3, tone="inverted")
    inverted = build(encode("BAR", version=1), spec)
    with pytest.raises(DesignError, match="tone inverted"):
        target.solid(inverted, target.placement(SIZE_MM), Walls())
