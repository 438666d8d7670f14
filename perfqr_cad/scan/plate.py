"""Views of a flat plate: its sections painted one over the other, each by its own homography.

Exact in the limit of many sections. With K >= 2 t tan(tilt) / (least web) every web covers what is
behind it; each view takes as many of the stack's sections as that needs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from perfqr_cad.scan.camera import Camera
from perfqr_cad.scan.raster import warp, zoom
from perfqr_cad.scan.sections import Stack
from perfqr_cad.scan.skylight import Brightness, Picture


@dataclass(frozen=True)
class Shot:
    """A view before colours: what each pixel gets per unit of reflectance.

    material   (H, W) light sent by the part, per unit of its reflectance
    ground     (H, W) light sent by the ground, per unit of its reflectance
    cover      (H, W) part of the pixel that is material
    to_ground  (3, 3) pixels to (x, y) in mm on the ground, for its texture
    """

    material: Picture
    ground: Picture
    cover: Picture
    to_ground: np.ndarray


def layers_needed(thickness_mm: float, tilt_deg: float, least_web_mm: float) -> int:
    """Sections that a view needs so that no web is seen through."""
    slope = np.tan(np.radians(min(tilt_deg, 85.0)))
    return max(2, int(np.ceil(2 * thickness_mm * slope / least_web_mm)) + 1)


def shoot(
    stack: Stack, brightness: Brightness, camera: Camera, *, gap_mm: float, front: float, least_web_mm: float
) -> Shot:
    """Film a plate. `front` is the irradiance of its front face."""
    to_plane = stack.to_plane()
    light_to_plane = to_plane @ zoom(stack.pixels / brightness.ground.shape[0])
    thickness = float(stack.depth_mm[-1])
    field = np.degrees(np.arctan(0.7 / camera.view.distance))  # half the picture's diagonal, as an angle
    wanted = layers_needed(thickness, camera.view.tilt_deg + field, least_web_mm)
    evenly = np.linspace(0, len(stack.depth_mm) - 1, wanted).round().astype(int)
    chosen = np.union1d(evenly, np.array(brightness.steps, int))

    pixels = (camera.view.size_px, camera.view.size_px)
    rows, columns, crop = _window(stack, camera)
    size = (columns.stop - columns.start, rows.stop - rows.start)
    material = np.zeros(size[::-1], np.float32)
    through = np.ones(size[::-1], np.float32)
    for k in chosen[::-1]:
        plane = crop @ camera.homography(float(stack.depth_mm[k]))
        cover = warp(stack.material[k], plane @ to_plane, size)
        cover = cover * np.float32(1 / 255)
        lit = warp(brightness.wall[k], plane @ light_to_plane, size) if k else np.float32(front)
        material += cover * (lit - material)
        through *= 1 - cover

    behind = camera.homography(thickness + gap_mm)
    ground = warp(brightness.ground, behind @ light_to_plane, pixels, outside=front)
    ground[rows, columns] *= through
    return Shot(
        _padded(material, rows, columns, pixels), ground, _padded(1 - through, rows, columns, pixels),
        np.linalg.inv(behind),
    )  # fmt: skip


def _window(stack: Stack, camera: Camera) -> tuple[slice, slice, np.ndarray]:
    """Rows and columns of the picture that the plate can touch, and the shift (3, 3) into them."""
    half = stack.edge_mm / 2
    square = np.array([[x, y, 1.0] for x in (-half, half) for y in (-half, half)])
    seen = np.vstack(
        [square @ camera.homography(float(d)).T for d in (stack.depth_mm[0], stack.depth_mm[-1])]
    )
    corners = seen[:, :2] / seen[:, 2:]
    low = np.clip(np.floor(corners.min(axis=0)), 0, camera.view.size_px - 1).astype(int)
    high = np.clip(np.ceil(corners.max(axis=0)) + 1, low + 1, camera.view.size_px).astype(int)
    crop = np.array([[1, 0, -low[0]], [0, 1, -low[1]], [0, 0, 1.0]])
    return slice(low[1], high[1]), slice(low[0], high[0]), crop


def _padded(picture: Picture, rows: slice, columns: slice, size: tuple[int, int]) -> Picture:
    whole = np.zeros(size, np.float32)
    whole[rows, columns] = picture
    return whole
