"""Views of a flat plate: its sections painted one over the other, each by its own homography.

Exact in the limit of many sections. With K >= 2 t tan(tilt) / (least web) every web covers what is
behind it; each view takes as many of the stack's sections as that needs.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from perfqr_cad.scan.camera import Camera
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
    size = (camera.view.size_px, camera.view.size_px)
    to_plane = stack.to_plane()
    field = np.degrees(np.arctan(0.7 / camera.view.distance))  # half the picture's diagonal, as an angle
    thickness = float(stack.depth_mm[-1])
    wanted = layers_needed(thickness, camera.view.tilt_deg + field, least_web_mm)
    chosen = np.unique(np.linspace(0, len(stack.depth_mm) - 1, wanted).round().astype(int))

    behind = camera.homography(thickness + gap_mm)
    scale = stack.material.shape[1] / brightness.ground.shape[0]
    light_to_plane = to_plane @ _zoom(scale)
    open_ground = float(front)
    ground = cv2.warpPerspective(
        brightness.ground, behind @ light_to_plane, size, flags=cv2.INTER_LINEAR, borderValue=open_ground
    )
    material = np.zeros(size, np.float32)
    through = np.ones(size, np.float32)
    for k in chosen[::-1]:
        plane = camera.homography(float(stack.depth_mm[k]))
        cover = cv2.warpPerspective(stack.material[k], plane @ to_plane, size, flags=cv2.INTER_LINEAR)
        if k == 0:
            lit = np.float32(front)
        else:
            lit = cv2.warpPerspective(brightness.wall[k], plane @ light_to_plane, size, flags=cv2.INTER_LINEAR)
        material += cover * (lit - material)
        through *= 1 - cover
    return Shot(material, ground * through, 1 - through, np.linalg.inv(behind))


def _zoom(scale: float) -> np.ndarray:
    """Pixels of a picture `scale` times smaller to pixels of the large one; centres at whole numbers."""
    return np.array([[scale, 0, (scale - 1) / 2], [0, scale, (scale - 1) / 2], [0, 0, 1.0]])
