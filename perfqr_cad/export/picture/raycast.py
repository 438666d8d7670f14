"""A small ray caster for pictures of parts: one key light, an open sky, a plain ground.

Deterministic: directions come from a fixed low-discrepancy set, spread over tiles of pixels and averaged
over each tile within one surface (interleaved sampling), so that few rays a pixel give smooth shades.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.geometry import Triangles
from perfqr_cad.geometry.graph import components
from perfqr_cad.geometry.triangles import directed_edges

Floats = NDArray[np.floating[Any]]
Ints = NDArray[np.int32]

TILE = 4  # pixels, edge of the tile over which directions are spread
SKY_RAYS, KEY_RAYS = 3, 2  # a pixel
CREASE_DEG = 40.0  # below the 45° of corner links, above the steps of a small fillet's facets
EDGE_SAMPLES = 3  # sub-samples along each edge of a pixel that an outline crosses


@dataclass(frozen=True)
class Lighting:
    """Light and tone. Directions point from the scene to the light; strengths are linear light."""

    up: tuple[float, float, float]
    key_direction: tuple[float, float, float]
    key_strength: float = 0.74
    key_spread: float = 0.09  # tangent of the light's angular radius: softness of the shadows
    sky_strength: float = 0.48
    bounce: float = 0.10  # share of the sky's light that still reaches a fully hidden point


@dataclass(frozen=True)
class Viewpoint:
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


@dataclass(frozen=True)
class Hits:
    """What rays meet first: triangle, point, and the normal facing the ray, flat and interpolated."""

    triangle: Ints
    points: Floats
    flat: Floats
    smooth: Floats


class LitMesh:
    """A triangle mesh with a linear colour for each face (m, 3), ready for rays."""

    def __init__(self, mesh: Triangles, colours: Floats) -> None:
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        corners = mesh.vertices[mesh.faces]
        self.colours = colours
        self._normals = _unit(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
        self.surface = _surfaces(mesh.faces, self._normals)
        self._corner_normals = _corner_normals(mesh.faces, corners, self.surface).astype(np.float32)
        self._scene: Any = EmbreeScene()
        self._mesh = TriangleMesh(self._scene, np.ascontiguousarray(corners, np.float32))

    def hits(self, eye: Floats, directions: Floats) -> Hits:
        """What each ray from the eye meets; the rays must all meet something."""
        origins = np.broadcast_to(eye, directions.shape).astype(np.float32)
        found = self._scene.run(origins, directions, output=1)
        triangle, u, v = found["primID"], found["u"][:, None], found["v"][:, None]
        a, b, c = np.moveaxis(self._corner_normals[triangle], 1, 0)
        return Hits(
            triangle=triangle,
            points=origins + directions * found["tfar"][:, None],
            flat=_facing(self._normals[triangle], directions).astype(np.float32),
            smooth=_facing(_unit((1 - u - v) * a + u * b + v * c), directions),
        )

    def hidden(self, origins: Floats, directions: Floats) -> NDArray[np.bool_]:
        """Whether anything lies along each ray."""
        return self._scene.run(origins, directions, query="OCCLUDED") >= 0


def render(
    scene: LitMesh, camera: Viewpoint, lighting: Lighting, width: int, height: int, lift: float
) -> Floats:
    """Linear light (height, width, 3) of a scene that fills the view; `lift` is above any rounding error."""
    hits = scene.hits(camera.eye, camera.directions(_grid(width, height) + 0.5, width, height))
    surface = scene.surface[hits.triangle].reshape(height, width)
    tile = _tile_index(width, height)
    under = _below_all(hits.points, np.asarray(lighting.up, np.float32), lift)
    start, normals = (hits.points + lift * hits.flat)[under], hits.flat[under]
    sky, key = np.ones(under.shape, np.float32), np.ones(under.shape, np.float32)
    sky[under] = _sky(scene, start, normals, tile[under])
    key[under] = _key(scene, start, tile[under], lighting)
    sky, key = (_smooth(share.reshape(height, width), surface) for share in (sky, key))
    shade = _shade(scene, hits, sky.ravel(), key.ravel(), lighting).reshape(height, width, 3)
    _resample_edges(shade, surface, sky, key, scene, camera, lighting)
    return shade


def _below_all(points: Floats, up: Floats, lift: float) -> NDArray[np.bool_]:
    """Points that anything can stand above; the rest, the face of a plate, sees all of the light."""
    height = points @ up
    return height < height.max() - lift


def _shade(scene: LitMesh, hits: Hits, sky: Floats, key: Floats, lighting: Lighting) -> Floats:
    facing = np.clip(hits.smooth @ _unit(np.asarray(lighting.key_direction, np.float32)), 0.0, 1.0)
    dome = 0.7 + 0.3 * (hits.smooth @ np.asarray(lighting.up, np.float32))  # a sky brighter overhead
    ambient = lighting.sky_strength * dome * (lighting.bounce + (1 - lighting.bounce) * sky)
    return scene.colours[hits.triangle] * (ambient + lighting.key_strength * facing * key)[:, None]


def _sky(scene: LitMesh, points: Floats, normals: Floats, tile: Ints) -> Floats:
    """Share of the sky that each point sees, weighted by the cosine: one estimate a pixel."""
    tangent, bitangent = _tangents(normals)
    seen = np.zeros(len(points), np.float32)
    samples = _low_discrepancy(TILE * TILE * SKY_RAYS)
    radius, angle = np.sqrt(samples[:, 0]), 2 * np.pi * samples[:, 1]
    local = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.sqrt(1 - samples[:, 0])], axis=1)
    for ray in range(SKY_RAYS):
        x, y, z = local[tile * SKY_RAYS + ray].astype(np.float32).T[:, :, None]
        seen += ~scene.hidden(points, x * tangent + y * bitangent + z * normals)
    return seen / SKY_RAYS


def _key(scene: LitMesh, points: Floats, tile: Ints, lighting: Lighting) -> Floats:
    """Share of the key light that reaches each point: one estimate a pixel."""
    towards = _unit(np.asarray([lighting.key_direction], np.float32))
    tangent, bitangent = _tangents(towards)
    samples = _low_discrepancy(TILE * TILE * KEY_RAYS)
    radius, angle = lighting.key_spread * np.sqrt(samples[:, :1]), 2 * np.pi * samples[:, 1:]
    rays = towards + radius * (np.cos(angle) * tangent + np.sin(angle) * bitangent)
    lit = np.zeros(len(points), np.float32)
    for ray in range(KEY_RAYS):
        lit += ~scene.hidden(points, rays[tile * KEY_RAYS + ray].astype(np.float32))
    return lit / KEY_RAYS


def _resample_edges(
    shade: Floats,
    surface: Ints,
    sky: Floats,
    key: Floats,
    scene: LitMesh,
    camera: Viewpoint,
    lighting: Lighting,
) -> None:
    """Replace pixels beside a change of surface by the mean of finer samples, in place."""
    height, width = surface.shape
    rows, columns = np.nonzero(_beside_change(surface))
    steps = (np.arange(EDGE_SAMPLES, dtype=np.float32) + 0.5) / EDGE_SAMPLES
    total = np.zeros((len(rows), 3), np.float32)
    for dy in steps:
        for dx in steps:
            xy = np.stack([columns + dx, rows + dy], axis=1).astype(np.float32)
            hits = scene.hits(camera.eye, camera.directions(xy, width, height))
            at = _nearest_alike(surface, scene.surface[hits.triangle], rows, columns)
            total += _shade(scene, hits, sky[at], key[at], lighting)
    shade[rows, columns] = total / EDGE_SAMPLES**2


def _nearest_alike(surface: Ints, wanted: Ints, rows: Any, columns: Any) -> tuple[Any, Any]:
    """For each pixel the one of its 3 × 3 neighbourhood that shows the wanted surface, else itself."""
    best_row, best_column = rows.copy(), columns.copy()
    open_ = surface[rows, columns] != wanted
    for dr, dc in ((-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (-1, 1), (1, -1), (1, 1)):
        r = np.clip(rows + dr, 0, surface.shape[0] - 1)
        c = np.clip(columns + dc, 0, surface.shape[1] - 1)
        take = open_ & (surface[r, c] == wanted)
        best_row[take], best_column[take] = r[take], c[take]
        open_ &= ~take
    return best_row, best_column


def _beside_change(surface: Ints) -> NDArray[np.bool_]:
    change = np.zeros(surface.shape, bool)
    across, down = surface[:, 1:] != surface[:, :-1], surface[1:] != surface[:-1]
    change[:, 1:] |= across
    change[:, :-1] |= across
    change[1:] |= down
    change[:-1] |= down
    return change


def _smooth(values: Floats, surface: Ints) -> Floats:
    """Mean over a tile around each pixel, along rows then columns, of pixels that show the same surface."""
    for axis in (1, 0):
        total, count = np.zeros_like(values), np.zeros_like(values)
        for shift in range(-(TILE // 2), TILE - TILE // 2):
            alike = np.roll(surface, shift, axis) == surface
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


def _surfaces(faces: NDArray[np.int64], normals: Floats) -> Ints:
    """Number of the smooth surface of each face: neighbours across an edge that is no crease share one."""
    edges = np.sort(directed_edges(faces), axis=1)
    face = np.repeat(np.arange(len(faces)), 3)
    order = np.lexsort(edges.T)
    edges, face = edges[order], face[order]
    same = np.all(edges[1:] == edges[:-1], axis=1)
    a, b = face[:-1][same], face[1:][same]
    flat = np.einsum("ij,ij->i", normals[a], normals[b]) > np.cos(np.radians(CREASE_DEG))
    return components(np.column_stack([a, b])[flat], len(faces)).astype(np.int32)


def _corner_normals(faces: NDArray[np.int64], corners: Floats, surface: Ints) -> Floats:
    """Normals (m, 3, 3) at the corners of each face: the mean over its surface's faces there, by area."""
    twice_area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    key = surface[:, None].astype(np.int64) * (faces.max() + 1) + faces
    at = np.unique(key, return_inverse=True)[1].reshape(-1)
    each = np.repeat(twice_area, 3, axis=0)
    total = np.stack([np.bincount(at, each[:, axis]) for axis in range(3)], axis=1)
    return _unit(total)[at].reshape(-1, 3, 3)


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
