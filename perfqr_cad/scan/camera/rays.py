"""Views of any closed mesh by ray casting (Embree): exact visibility, light by sampled rays.

Light is worked out at a ninth of the pixels, with one lamp ray, one sky ray and one reflection each,
and averaged over neighbours that face the same way; edges between faces stay sharp. A body behind the
part is lit and hidden like the part, but has the ground's colour.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.scan.camera.camera import Camera
from perfqr_cad.scan.camera.layers import Shot
from perfqr_cad.scan.camera.look import Light
from perfqr_cad.scan.camera.marching import Picture
from perfqr_cad.scan.camera.phone import PhoneBody
from perfqr_cad.scan.camera.placing import FilmedPart
from perfqr_cad.scan.camera.raster import smooth, warp
from perfqr_cad.scan.camera.skylight import BOUNCES

Floats = NDArray[np.float64]
LIFT_MM = 1e-3  # rays leave a surface from this far above it, or they would meet it again
GROUND = np.int8(0)
AXIS_CLASSES = 6  # the ways a triangle can face
SAMPLE_STEP = 3  # light is sampled at every third pixel of every third row
STEEPEST_DEG = 65.0  # of a surface towards the camera that is still averaged as one
DEEP = 32  # added to the class of what is seen through holes
SMOOTH_PX = 6.0  # and averaged over about 2 pi 6² / 9 = 25 samples
_TINY = 1e-6


@dataclass(frozen=True)
class Tracer:
    """A mesh in the frame of its code (z towards the reader), ready for rays.

    normals   (m, 3) unit; classes (m + 1,) of the triangles and, last, of the ground; corners (8, 3) of the
    box around them. The first `of_part` triangles are the part, the others a body of the ground's colour.
    """

    scene: Any
    normals: Floats
    classes: NDArray[np.int8]
    corners: Floats
    of_part: int

    def on_part(self, triangle: NDArray[np.int32]) -> NDArray[np.bool_]:
        """Whether the rays with these hits met the part."""
        return (triangle >= 0) & (triangle < self.of_part)

    def hit(
        self, origins: NDArray[np.floating], directions: NDArray[np.floating]
    ) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
        """Triangle (-1 for none) and distance for each ray, in lengths of its direction."""
        found = self.scene.run(
            np.ascontiguousarray(origins, np.float32), np.ascontiguousarray(directions, np.float32), output=1
        )
        return found["primID"], found["tfar"]

    def blocked(self, origins: Floats, directions: Floats) -> NDArray[np.bool_]:
        """Whether anything lies in the way."""
        found = self.scene.run(origins.astype(np.float32), directions.astype(np.float32), query="OCCLUDED")
        return found >= 0


def tracer(part: FilmedPart) -> Tracer:
    """Build the ray caster of a part and of what is behind it."""
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene

    points, triangles = part.behind_in_frame()
    vertices = np.vstack([part.in_frame(), points])
    faces = np.vstack([part.faces, triangles + len(part.vertices)])
    scene = EmbreeScene()
    TriangleMesh(scene, vertices.astype(np.float32), faces.astype(np.int32))
    corner = vertices[faces]
    normals = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True) + 1e-300
    classes = _classes(normals)
    classes[len(part.faces) :] += AXIS_CLASSES  # its light is not averaged with the part's
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    corners = np.array(list(product(*zip(low, high, strict=True))))
    return Tracer(scene, normals, np.append(classes, GROUND), corners, len(part.faces))


def shoot(
    tracer: Tracer,
    camera: Camera,
    light: Light,
    *,
    gap_mm: float,
    reflectance: tuple[float, float],
    phone: bool,
    seed: int,
) -> Shot:
    """Film a mesh before a level ground, `gap_mm` below its lowest point.

    reflectance   of the part and of the ground, for light that goes on from them
    """
    size, axes = camera.view.size_px, camera.code.axes
    eye = (camera.eye_mm - camera.code.centre_mm) @ axes.T
    rows, columns = camera.window(camera.code.centre_mm + tracer.corners @ axes)
    triangle = np.full((size, size), -1, np.int32)
    distance = np.zeros((size, size), np.float32)
    ways = camera.rays(axes, rows, columns)
    found, far = tracer.hit(np.broadcast_to(eye.astype(np.float32), ways.shape), ways)
    triangle[rows, columns] = found.reshape(rows.stop - rows.start, -1)
    distance[rows, columns] = far.reshape(rows.stop - rows.start, -1)

    every = np.s_[::SAMPLE_STEP, ::SAMPLE_STEP]
    floor = float(tracer.corners[:, 2].min()) - gap_mm
    whole = slice(0, size, SAMPLE_STEP)
    points, normals = _places(
        tracer, eye, camera.rays(axes, whole, whole), triangle[every].ravel(), distance[every].ravel(), floor
    )
    rng = np.random.default_rng(seed)
    body = PhoneBody.of(camera) if phone else None
    surroundings = _Surroundings(light, camera.code.edge_mm, floor, reflectance, body)
    light_there = _irradiance(tracer, points, normals, surroundings, rng)
    cover = tracer.on_part(triangle)
    facing = tracer.classes[triangle]  # the last class is that of the ground
    facing[_deep(distance, cover, camera.code.edge_mm / (camera.view.fill * size))] += DEEP
    lit = _spread(light_there.reshape(facing[every].shape).astype(np.float32), facing)
    return Shot(lit * cover, lit * ~cover, cover.astype(np.float32), np.linalg.inv(camera.homography(-floor)))


def _deep(distance: Picture, cover: NDArray[np.bool_], pixel_mm: float) -> NDArray[np.bool_]:
    """Pixels of the part that lie too deep behind their neighbours to be averaged with them.

    Deeper, that is, than any slope explains: the far inner wall of a hollow body, seen through its holes,
    faces the reader as its front does.
    """
    from scipy.ndimage import minimum_filter

    reach = round(3 * SMOOTH_PX)
    near = minimum_filter(np.where(cover, distance, np.inf), 2 * reach + 1)
    return cover & (distance > near + reach * pixel_mm * np.tan(np.radians(STEEPEST_DEG)))


def _places(
    tracer: Tracer,
    eye: Floats,
    ways: NDArray[np.float32],
    triangle: NDArray[np.int32],
    distance: NDArray[np.float32],
    floor: float,
) -> tuple[Floats, Floats]:
    """Where rays end, and the normal there towards the camera: on the part or on the ground."""
    along = ways.astype(np.float64)
    # Rays that pass the horizon meet the ground nowhere: they see it as if far away.
    to_floor = (floor - eye[2]) / np.minimum(along[:, 2], -_TINY)
    reach = np.where(triangle >= 0, distance, to_floor)
    normals = np.where(triangle[:, None] >= 0, tracer.normals[triangle], [0.0, 0.0, 1.0])
    normals[np.einsum("ij,ij->i", normals, along) > 0] *= -1
    return eye + along * reach[:, None], normals


@dataclass(frozen=True)
class _Surroundings:
    """Light on a code of some edge, the height of the ground, what part and ground send back, and the
    phone."""

    light: Light
    edge_mm: float
    floor: float
    reflectance: tuple[float, float]
    phone: PhoneBody | None

    def hidden(self, points: Floats, ways: Floats) -> NDArray[np.bool_]:
        """Whether the phone stands in the way of the light."""
        return np.zeros(len(points), np.bool_) if self.phone is None else self.phone.hides(points, ways)


def _irradiance(
    tracer: Tracer, points: Floats, normals: Floats, around: _Surroundings, rng: np.random.Generator
) -> Floats:
    """One sample of lamp, sky and a few reflections at each point (k,)."""
    total, met = _direct(tracer, points, normals, around, rng)
    onto, share = met.index, met.reflectance
    for _ in range(BOUNCES):
        reflected, met = _direct(tracer, met.points, met.normals, around, rng)
        total += np.bincount(onto, share * reflected, len(total))
        onto, share = onto[met.index], share[met.index] * met.reflectance
    return total


@dataclass(frozen=True)
class _Met:
    """Where rays met something that sends light on: their index, place, normal and its reflectance."""

    index: NDArray[np.intp]
    points: Floats
    normals: Floats
    reflectance: Floats


def _direct(
    tracer: Tracer, points: Floats, normals: Floats, around: _Surroundings, rng: np.random.Generator
) -> tuple[Floats, _Met]:
    """Lamp and sky at each point, and what the sky's rays met instead."""
    light = around.light
    start = points + LIFT_MM * normals
    lamp = light.lamp_directions
    lamp = lamp[rng.integers(len(lamp), size=len(start)) if len(lamp) > 1 else np.zeros(len(start), int)]
    cosine = np.maximum(np.einsum("ij,ij->i", normals, lamp), 0)
    near = light.fall_off(light.lamp_directions[0], points[:, :2] / around.edge_mm)
    total = light.lamp * near * cosine * ~(tracer.blocked(start, lamp) | around.hidden(start, lamp))
    sky = _cosine_rays(normals, rng)
    triangle, distance = tracer.hit(start, sky)
    total = total + light.ambient * ((triangle < 0) & (sky[:, 2] > 0) & ~around.hidden(start, sky))
    on_part = tracer.on_part(triangle)
    of_part, of_ground = around.reflectance
    sends = on_part | ((triangle >= 0) | (sky[:, 2] < -_TINY) if of_ground > 0 else on_part)
    onto = np.nonzero(sends)[0]
    hit = triangle[onto] >= 0
    reach = np.where(hit, distance[onto], (around.floor - start[onto, 2]) / np.minimum(sky[onto, 2], -_TINY))
    facing = np.where(hit[:, None], tracer.normals[triangle[onto]], [0.0, 0.0, 1.0])
    facing[np.einsum("ij,ij->i", facing, sky[onto]) > 0] *= -1
    return total, _Met(
        onto, start[onto] + sky[onto] * reach[:, None], facing, np.where(on_part[onto], of_part, of_ground)
    )


def _cosine_rays(normals: Floats, rng: np.random.Generator) -> Floats:
    """One direction per normal, as likely as its cosine (Malley's method)."""
    k = len(normals)
    radius, angle = np.sqrt(rng.random(k)), 2 * np.pi * rng.random(k)
    other = np.where(np.abs(normals[:, :1]) > 0.9, [[0.0, 1.0, 0.0]], [[1.0, 0.0, 0.0]])
    first = np.cross(normals, other)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(normals, first)
    height = np.sqrt(1 - radius**2)
    return (
        first * (radius * np.cos(angle))[:, None]
        + second * (radius * np.sin(angle))[:, None]
        + normals * height[:, None]
    )


def _classes(normals: Floats) -> NDArray[np.int8]:
    """Class of each triangle: 1 to 6, the axis (+x, -x, +y, -y, +z, -z) that it looks along."""
    axis = np.abs(normals).argmax(axis=1)
    negative = np.take_along_axis(normals, axis[:, None], axis=1)[:, 0] < 0
    return (1 + 2 * axis + negative).astype(np.int8)


def _spread(sparse: Picture, facing: NDArray[np.int8]) -> Picture:
    """Light sampled on the coarse grid, averaged over neighbours of the same class, at every pixel."""
    size = facing.shape[::-1]
    # Coarse pixel (r, c) was sampled at fine pixel (r, c) * SAMPLE_STEP.
    to_fine = np.diag([SAMPLE_STEP, SAMPLE_STEP, 1.0])
    there = facing[::SAMPLE_STEP, ::SAMPLE_STEP]
    lit = np.zeros(facing.shape, np.float32)
    for kind in np.unique(there):
        here = (there == kind).astype(np.float32)
        weight = warp(smooth(here, SMOOTH_PX / SAMPLE_STEP), to_fine, size)
        total = warp(smooth(sparse * here, SMOOTH_PX / SAMPLE_STEP), to_fine, size)
        mine = facing == kind
        lit[mine] = total[mine] / (weight[mine] + np.float32(_TINY))
    return lit
