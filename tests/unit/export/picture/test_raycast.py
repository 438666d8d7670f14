"""The ray caster against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
import trimesh

from perfqr_cad.export.picture import raycast
from perfqr_cad.export.picture.raycast import Lighting, LitMesh, Viewpoint
from perfqr_cad.geometry import Triangles

GREY = 0.5


def mesh_of(*bodies):
    first, *rest = (Triangles(body.vertices, body.faces) for body in bodies)
    return first.joined(*rest)


def scene_of(*bodies):
    mesh = mesh_of(*bodies)
    return LitMesh(mesh, np.full((len(mesh.faces), 3), GREY))


def block(low, high):
    low, high = np.array(low, float), np.array(high, float)
    return trimesh.creation.box(high - low).apply_translation((low + high) / 2)


@pytest.mark.parametrize(
    ("body", "count"),
    [
        (trimesh.creation.box((1, 2, 3)), 6),
        (trimesh.creation.cylinder(1.0, 2.0, sections=32), 3),
        (trimesh.creation.icosphere(3), 1),
        (trimesh.creation.cylinder(1.0, 2.0, sections=6), 8),  # 60° is a crease
    ],
)
def test_surfaces_end_at_creases(body, count):
    assert len(np.unique(scene_of(body).surface)) == count


def test_normals_of_a_coarse_ball_are_radial():
    scene = scene_of(trimesh.creation.icosphere(3))
    eye = np.array([0.0, 0.0, 5.0])
    towards = np.array([[0.1, 0.05, -1.0], [-0.13, 0.02, -1.0]])
    hits = scene.hits(eye, (towards / np.linalg.norm(towards, axis=1, keepdims=True)).astype(np.float32))
    radial = hits.points / np.linalg.norm(hits.points, axis=1, keepdims=True)
    smooth, flat = (np.degrees(np.arccos((n * radial).sum(axis=1))).max() for n in (hits.smooth, hits.flat))
    assert smooth < 0.7 < 1.5 < flat


@pytest.mark.parametrize("width", [1.0, 2.0, 6.0])
def test_sky_over_a_trench(width):
    """On the centre line of a long trench of depth 1 the cosine-weighted sky is sin(atan(width / 2))."""
    walls = [
        block((-200, side * width / 2 - 0.5 + side * 0.5, 0), (200, side * width / 2 + 0.5 + side * 0.5, 1))
        for side in (-1, 1)
    ]
    scene = scene_of(*walls, block((-200, -20, -1), (200, 20, -0.001)))
    tile = np.arange(raycast.TILE**2, dtype=np.int32)
    points, normals = np.zeros((len(tile), 3), np.float32), np.tile(np.float32([0, 0, 1]), (len(tile), 1))
    seen = raycast._sky(scene, points, normals, tile).mean()
    assert seen == pytest.approx(math.sin(math.atan(width / 2)), abs=0.06)


def test_key_light_and_its_shadow():
    """A post of height 1 throws a shadow of length 1 under a light at 45°; beside it all is lit."""
    scene = scene_of(block((-0.5, -0.5, 0), (0.5, 0.5, 1)))
    lighting = Lighting((0.0, 0.0, 1.0), (-1.0, 0.0, 1.0), key_spread=0.01)
    points = np.float32([[1.2, 0, 1e-3], [1.8, 0, 1e-3], [0, 1.0, 1e-3]])
    tile = np.zeros(3, np.int32)
    assert raycast._key(scene, points, tile, lighting).tolist() == [0.0, 1.0, 1.0]


def test_open_floor_takes_the_whole_light():
    """Straight above a floor: its colour times sky and key, the same at every pixel."""
    scene = scene_of(block((-50, -50, -1), (50, 50, 0)))
    camera = Viewpoint(np.array([0.0, 0.0, 10.0]), np.zeros(3), np.array([0.0, 1.0, 0.0]), 0.2)
    lighting = Lighting((0.0, 0.0, 1.0), (0.0, 0.0, 1.0))
    light = raycast.render(scene, camera, lighting, 16, 12, lift=1e-3)
    assert light == pytest.approx(
        np.full((12, 16, 3), GREY * (lighting.sky_strength + lighting.key_strength)), rel=1e-5
    )


def test_edges_are_smooth():
    """A dark block before a light floor: pixels on its outline lie between the two."""
    mesh = mesh_of(block((-50, -50, -1), (50, 50, 0)), block((-1, -1, 0.1), (1.07, 1, 0.2)))
    scene = LitMesh(mesh, np.repeat([[0.9] * 3, [0.0] * 3], 12, axis=0))
    camera = Viewpoint(np.array([0.0, 0.0, 20.0]), np.zeros(3), np.array([0.0, 1.0, 0.0]), 0.2)
    light = raycast.render(scene, camera, Lighting((0.0, 0.0, 1.0), (0.0, 0.0, 1.0)), 64, 48, lift=1e-3)
    row = light[24, :, 0]
    dark, between = row < 0.01, (row > 0.05) & (row < 0.6 * row.max())
    assert dark.sum() > 10
    assert 1 <= between.sum() <= 4


def test_camera_sees_its_target_in_the_middle():
    camera = Viewpoint(np.array([3.0, -4.0, 5.0]), np.array([1.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0]), 0.3)
    middle = camera.directions(np.float32([[50, 40]]), 100, 80)[0]
    towards = (camera.target - camera.eye) / np.linalg.norm(camera.target - camera.eye)
    assert middle == pytest.approx(towards, abs=1e-6)
    edge = camera.directions(np.float32([[100, 40]]), 100, 80)[0]
    assert math.tan(math.acos(edge @ towards)) == pytest.approx(0.3, rel=1e-4)
