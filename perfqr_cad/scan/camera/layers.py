"""Views of a flat plate: its sections seen one behind the other through the holes before them.

Exact in the limit of many sections. With K >= 2 t tan(tilt) / (least web) every web covers what is
behind it; each view takes as many of the stack's sections as that needs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.scan.camera.camera import Camera
from perfqr_cad.scan.camera.marching import Picture
from perfqr_cad.scan.camera.raster import sample, warp, zoom
from perfqr_cad.scan.camera.skylight import Brightness
from perfqr_cad.scan.camera.stack import Stack

OPAQUE = 1 / 512  # a pixel of which less than this is still open shows nothing of what is behind
TOGETHER = 1 << 14  # pixels followed at a time: their values stay in the processor's cache
DROPPED = 0.9  # pixels that are covered are dropped when no more than this part is left


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
    stack: Stack, brightness: Brightness, camera: Camera, *, gap_mm: float, least_web_mm: float
) -> Shot:
    """Film a plate."""
    thickness = float(stack.depth_mm[-1])
    field = np.degrees(np.arctan(0.7 / camera.view.distance))  # half the picture's diagonal, as an angle
    wanted = layers_needed(thickness, camera.view.tilt_deg + field, least_web_mm)
    evenly = np.linspace(0, len(stack.depth_mm) - 1, wanted).round().astype(int)
    behind_front = np.union1d(evenly, np.array(brightness.steps, int))[1:]

    pixels = (camera.view.size_px, camera.view.size_px)
    rows, columns = _window(stack, camera)
    crop = np.array([[1, 0, -columns.start], [0, 1, -rows.start], [0, 0, 1.0]])
    size = (columns.stop - columns.start, rows.stop - rows.start)
    to_picture = crop @ camera.homography(0.0) @ stack.to_plane()
    cover = warp(stack.material[0], to_picture, size) * np.float32(1 / 255)
    to_light = stack.to_plane() @ zoom(stack.pixels / brightness.ground.shape[0])
    front = warp(brightness.front, crop @ camera.homography(0.0) @ to_light, size, beyond="edge")
    material, through = cover * front, 1 - cover
    if len(behind_front):
        _see_through(stack, brightness, camera, to_picture, behind_front, material, through)

    behind = camera.homography(thickness + gap_mm)
    shade = 1 - brightness.ground / brightness.front  # there is none beyond the picture
    ground = 1 - warp(shade, behind @ to_light, pixels)
    ground *= warp(brightness.front, behind @ to_light, pixels, beyond="edge")
    ground[rows, columns] *= through
    return Shot(
        _padded(material, rows, columns, pixels), ground, _padded(1 - through, rows, columns, pixels),
        np.linalg.inv(behind),
    )  # fmt: skip


def _see_through(
    stack: Stack,
    brightness: Brightness,
    camera: Camera,
    to_picture: np.ndarray,
    layers: NDArray[np.integer],
    material: Picture,
    through: Picture,
) -> None:
    """Add what the deeper sections show to `material`, and take it from `through`, in place.

    Seen from the eye, a section at depth d is the front one magnified by 1 + d / height about the eye's foot.
    """
    sums, rest = material.reshape(-1), through.reshape(-1)
    foot, height_mm = _foot(stack, camera)
    magnified = (1 + stack.depth_mm / height_mm).astype(np.float32)
    bounds = stack.bounds
    to_light = np.float32(len(brightness.front) / stack.pixels)
    shift = (to_light - 1) / 2  # centres of pixels are at whole numbers in both
    open_pixels = np.flatnonzero(rest > OPAQUE)
    walls = {int(k): brightness.wall(int(k)) for k in layers}
    for pixels in np.array_split(open_pixels, 1 + len(open_pixels) // TOGETHER):
        from_foot = _front_points(pixels, through.shape[1], to_picture) - foot
        near = _meets(bounds, from_foot + foot, from_foot * magnified[-1] + foot)
        pixels, from_foot = pixels[near], from_foot.take(np.flatnonzero(near), axis=1)
        left = rest[pixels]
        for k in layers:
            at = from_foot * magnified[k] + foot
            covered = sample(stack.material[k], at) * (left * np.float32(1 / 255))
            left -= covered
            met = np.flatnonzero(covered > 0)
            lit = sample(walls[k], at.take(met, axis=1) * to_light + shift)
            sums[pixels[met]] += covered[met] * lit
            still = np.flatnonzero(left > OPAQUE)
            if len(still) < DROPPED * len(left):
                rest[pixels] = left
                pixels, from_foot, left = pixels[still], from_foot.take(still, axis=1), left[still]
        rest[pixels] = left


def _meets(bounds: tuple[int, int, int, int], front: Picture, back: Picture) -> NDArray[np.bool_]:
    """Whether the ways (2, k) from front to back can pass a rectangle (left, top, right, bottom)."""
    low, high = np.minimum(front, back), np.maximum(front, back)
    left, top, right, bottom = bounds
    return (high[0] >= left) & (low[0] <= right) & (high[1] >= top) & (low[1] <= bottom)


def _foot(stack: Stack, camera: Camera) -> tuple[Picture, float]:
    """Where the eye stands over the front: section pixels (2, 1), and its height in mm."""
    eye = camera.code.axes @ (camera.eye_mm - camera.code.centre_mm)
    x, y, _ = np.linalg.inv(stack.to_plane()) @ [eye[0], eye[1], 1.0]
    return np.array([[x], [y]], np.float32), float(eye[2])


def _front_points(pixels: NDArray[np.intp], width: int, to_picture: np.ndarray) -> Picture:
    """Section pixels (2, k) at which the front is seen in pixels of the picture, given by flat index."""
    row, column = np.divmod(pixels, width)
    x, y, w = np.linalg.inv(to_picture) @ np.stack([column, row, np.ones_like(row)]).astype(float)
    return np.stack([x / w, y / w]).astype(np.float32)


def _window(stack: Stack, camera: Camera) -> tuple[slice, slice]:
    """Rows and columns of the picture that the plate can touch."""
    half, depth = stack.edge_mm / 2, float(stack.depth_mm[-1])
    corners = np.array([[x, y, z] for x in (-half, half) for y in (-half, half) for z in (0.0, -depth)])
    return camera.window(camera.code.centre_mm + corners @ camera.code.axes)


def _padded(picture: Picture, rows: slice, columns: slice, size: tuple[int, int]) -> Picture:
    whole = np.zeros(size, np.float32)
    whole[rows, columns] = picture
    return whole
