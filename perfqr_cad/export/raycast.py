"""A small ray caster for pictures of parts: one key light, an open sky, a plain ground.

Deterministic: directions come from a fixed low-discrepancy set, spread over tiles of pixels and averaged
over each tile within one plane (interleaved sampling), so that few rays a pixel give smooth shades.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.floating[Any]]
Ints = NDArray[np.int32]

TILE = 4  # pixels, edge of the tile over which directions are spread
SKY_RAYS, KEY_RAYS = 3, 2  # a pixel
EDGE_SAMPLES = 3  # sub-samples along each edge of a pixel that an outline crosses


@dataclass(frozen=True)
class Look:
    """Light and tone. Directions point from the scene to the light; strengths are linear light."""

    up: tuple[float, float, float] = (0.0, 0.0, 1.0)
    key_direction: tuple[float, float, float] = (-0.42, 0.48, 0.77)
    key_strength: float = 0.74
    key_spread: float = 0.09  # tangent of the light's angular radius: softness of the shadows
    sky_strength: float = 0.48
    bounce: float = 0.10  # share of the sky's light that still reaches a fully hidden point


@dataclass(frozen=True)
class Camera:
    """A pinhole at `eye` looking at `target`; `spread` is the tangent of half the picture's width."""

    eye: Floats
    target: Floats
    up: Floats
    spread: float

    def axes(self) -> Floats:
        """Rows right, up, forward: unit vectors (3, 3)."""
        forward = _unit(self.target - self.eye)
        right = _unit(np.cross(forward, self.up))
        return np.stack([right, np.cross(right, forward), forward])

    def directions(self, xy: Floats, width: int, height: int) -> Floats:
        """Unit directions (k, 3) through picture positions (k, 2) in pixels, y down."""
        scale = 2.0 * self.spread / width
        plane = np.stack([(xy[:, 0] - width / 2) * scale, (height / 2 - xy[:, 1]) * scale], axis=1)
        right, up, forward = self.axes()
        return _unit(plane[:, :1] * right + plane[:, 1:] * up + forward).astype(np.float32)


class Scene:
    """Triangles (m, 3, 3) with a linear colour each (m, 3), ready for rays."""

    def __init__(self, corners: Floats, colours: Floats) -> None:
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        self._corners = np.ascontiguousarray(corners, np.float32)
        self.colours = colours
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        self.normals: Floats = _unit(normals).astype(np.float32)
        self.size = float(np.ptp(corners.reshape(-1, 3), axis=0).max())
        self.planes = _plane_ids(self.normals, corners[:, 0], self.size)
        self._scene: Any = EmbreeScene()
        self._mesh = TriangleMesh(self._scene, self._corners)

    def hit(self, eye: Floats, directions: Floats) -> tuple[Ints, Floats]:
        """First triangle along each ray from the eye, -1 for none, and its distance."""
        origins = np.broadcast_to(eye, directions.shape).astype(np.float32)
        found = self._scene.run(origins, directions, output=1)
        return found["primID"], found["tfar"]

    def hidden(self, origins: Floats, directions: Floats) -> NDArray[np.bool_]:
        """Whether anything lies along each ray."""
        return self._scene.run(origins, directions, query="OCCLUDED") >= 0


def picture(scene: Scene, camera: Camera, look: Look, width: int, height: int, lift: float) -> Floats:
    """Linear light (height, width, 3) of a scene that fills the view."""
    pixels = _grid(width, height)
    directions = camera.directions(pixels + 0.5, width, height)
    triangle, distance = scene.hit(camera.eye, directions)
    points = camera.eye.astype(np.float32) + directions * distance[:, None]
    normals = _facing(scene.normals[triangle], directions)
    plane = scene.planes[triangle].reshape(height, width)
    tile = _tile_index(width, height)
    under = _below_all(points, np.asarray(look.up, np.float32), lift)
    sky, key = np.ones(len(points), np.float32), np.ones(len(points), np.float32)
    sky[under] = _sky(scene, points[under], normals[under], tile[under], lift)
    key[under] = _key(scene, points[under], normals[under], tile[under], look, lift)
    sky, key = (_smooth(share.reshape(height, width), plane) for share in (sky, key))
    shade = _shade(scene, triangle, normals, sky.ravel(), key.ravel(), look).reshape(height, width, 3)
    _resample_edges(shade, plane, sky, key, scene, camera, look)
    return shade


def _below_all(points: Floats, up: Floats, lift: float) -> NDArray[np.bool_]:
    """Points that anything can stand above; the rest, the face of a plate, sees all of the light."""
    height = points @ up
    return height < height.max() - lift


def _shade(scene: Scene, triangle: Ints, normals: Floats, sky: Floats, key: Floats, look: Look) -> Floats:
    facing = np.clip(normals @ _unit(np.asarray(look.key_direction, np.float32)), 0.0, 1.0)
    dome = 0.7 + 0.3 * (normals @ np.asarray(look.up, np.float32))  # a sky brighter overhead
    ambient = look.sky_strength * dome * (look.bounce + (1 - look.bounce) * sky)
    return scene.colours[triangle] * (ambient + look.key_strength * facing * key)[:, None]


def _sky(scene: Scene, points: Floats, normals: Floats, tile: Ints, lift: float) -> Floats:
    """Share of the sky that each point sees, weighted by the cosine: one estimate a pixel."""
    tangent, bitangent = _tangents(normals)
    seen = np.zeros(len(points), np.float32)
    samples = _low_discrepancy(TILE * TILE * SKY_RAYS)
    radius, angle = np.sqrt(samples[:, 0]), 2 * np.pi * samples[:, 1]
    local = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.sqrt(1 - samples[:, 0])], axis=1)
    for ray in range(SKY_RAYS):
        x, y, z = local[tile * SKY_RAYS + ray].astype(np.float32).T[:, :, None]
        seen += ~scene.hidden(points + lift * normals, x * tangent + y * bitangent + z * normals)
    return seen / SKY_RAYS


def _key(scene: Scene, points: Floats, normals: Floats, tile: Ints, look: Look, lift: float) -> Floats:
    """Share of the key light that reaches each point: one estimate a pixel."""
    towards = _unit(np.asarray([look.key_direction], np.float32))
    tangent, bitangent = _tangents(towards)
    samples = _low_discrepancy(TILE * TILE * KEY_RAYS)
    radius, angle = look.key_spread * np.sqrt(samples[:, :1]), 2 * np.pi * samples[:, 1:]
    rays = towards + radius * (np.cos(angle) * tangent + np.sin(angle) * bitangent)
    lit = np.zeros(len(points), np.float32)
    for ray in range(KEY_RAYS):
        lit += ~scene.hidden(points + lift * normals, rays[tile * KEY_RAYS + ray].astype(np.float32))
    return lit / KEY_RAYS


def _resample_edges(
    shade: Floats, plane: Ints, sky: Floats, key: Floats, scene: Scene, camera: Camera, look: Look
) -> None:
    """Replace pixels beside a change of plane by the mean of finer samples, in place."""
    height, width = plane.shape
    rows, columns = np.nonzero(_beside_change(plane))
    steps = (np.arange(EDGE_SAMPLES, dtype=np.float32) + 0.5) / EDGE_SAMPLES
    total = np.zeros((len(rows), 3), np.float32)
    for dy in steps:
        for dx in steps:
            xy = np.stack([columns + dx, rows + dy], axis=1).astype(np.float32)
            directions = camera.directions(xy, width, height)
            triangle, _ = scene.hit(camera.eye, directions)
            at = _nearest_alike(plane, scene.planes[triangle], rows, columns)
            normals = _facing(scene.normals[triangle], directions)
            total += _shade(scene, triangle, normals, sky[at], key[at], look)
    shade[rows, columns] = total / EDGE_SAMPLES**2


def _nearest_alike(plane: Ints, wanted: Ints, rows: Any, columns: Any) -> tuple[Any, Any]:
    """For each pixel the one of its 3 × 3 neighbourhood that shows the wanted plane, else itself."""
    best_row, best_column = rows.copy(), columns.copy()
    open_ = plane[rows, columns] != wanted
    for dr, dc in ((-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (-1, 1), (1, -1), (1, 1)):
        r = np.clip(rows + dr, 0, plane.shape[0] - 1)
        c = np.clip(columns + dc, 0, plane.shape[1] - 1)
        take = open_ & (plane[r, c] == wanted)
        best_row[take], best_column[take] = r[take], c[take]
        open_ &= ~take
    return best_row, best_column


def _beside_change(plane: Ints) -> NDArray[np.bool_]:
    change = np.zeros(plane.shape, bool)
    across, down = plane[:, 1:] != plane[:, :-1], plane[1:] != plane[:-1]
    change[:, 1:] |= across
    change[:, :-1] |= across
    change[1:] |= down
    change[:-1] |= down
    return change


def _smooth(values: Floats, plane: Ints) -> Floats:
    """Mean over a tile around each pixel, along rows then columns, of pixels that show the same plane."""
    for axis in (1, 0):
        total, count = np.zeros_like(values), np.zeros_like(values)
        for shift in range(-(TILE // 2), TILE - TILE // 2):
            alike = np.roll(plane, shift, axis) == plane
            total += np.where(alike, np.roll(values, shift, axis), 0)
            count += alike
        values = total / count
    return values


def _tile_index(width: int, height: int) -> Ints:
    y, x = np.divmod(np.arange(width * height, dtype=np.int32), width)
    return ((y % TILE) * TILE + x % TILE).astype(np.int32)


def _grid(width: int, height: int) -> Floats:
    y, x = np.divmod(np.arange(width * height), width)
    return np.stack([x, y], axis=1).astype(np.float32)


def _low_discrepancy(count: int) -> Floats:
    """`count` points of the unit square (Roberts' R2 sequence)."""
    plastic = 1.32471795724474602596  # root of x³ = x + 1
    k = np.arange(1, count + 1)[:, None]
    return (0.5 + k * np.array([1 / plastic, 1 / plastic**2])) % 1.0


def _plane_ids(normals: Floats, points: Floats, size: float) -> Ints:
    """One number for all triangles of a plane, to a thousandth of the scene's size."""
    offset = np.einsum("ij,ij->i", normals, points) / size
    keys = np.round(np.column_stack([normals * 50, offset * 1000])).astype(np.int32)
    return np.unique(keys, axis=0, return_inverse=True)[1].astype(np.int32).ravel()


def _facing(normals: Floats, directions: Floats) -> Floats:
    """Normals turned against the ray."""
    return np.where(np.einsum("ij,ij->i", normals, directions)[:, None] > 0, -normals, normals)


def _tangents(normals: Floats) -> tuple[Floats, Floats]:
    """Two unit vectors perpendicular to each normal (Duff et al. 2017, JCGT 6(1))."""
    x, y, z = normals.T
    sign = np.where(z >= 0, 1.0, -1.0).astype(np.float32)
    a = -1.0 / (sign + z)
    b = x * y * a
    first = np.stack([1.0 + sign * x * x * a, sign * b, -sign * x], axis=1)
    return first, np.stack([b, sign + y * y * a, -y], axis=1)


def _unit(vectors: NDArray[Any]) -> Floats:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length > 0, length, 1.0)
