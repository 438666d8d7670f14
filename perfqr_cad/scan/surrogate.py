"""How legible a part is from a tilt, from geometry and light alone: no picture, no decoder.

Seen from a tilt, each module shows a mixture of front face, wall and ground. Its tone is the mean light
over the module's middle, gamma-encoded as the camera does; a module is as legible as its tone lies on
the right side of the local threshold.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from perfqr_cad.errors import AnalysisError
from perfqr_cad.scan.camera.camera import Camera, View
from perfqr_cad.scan.camera.look import Look
from perfqr_cad.scan.camera.raster import warp
from perfqr_cad.scan.camera.scene import Scene
from perfqr_cad.symbol import Matrix

MODULE_PX = 8
CORE = 0.5  # edge of the middle of a module over which its tone is taken, as a part of the module
AZIMUTHS_DEG = (20.0, 110.0, 200.0, 290.0)  # near the code's axes, where walls hide most
# A local threshold lies about half-way between the tones around it; 5 modules are what the finders span.
THRESHOLD_MODULES = 5
RING_WIDTH = 7  # modules across a finder pattern
# A bar across the dark ring is seen as a gap when its light passes this part of the front's (measured on flat
# prints with a painted bar: read at every tilt to 40° up to 0.35, at none from 0.45 on; bar of 0.6 module).
GAP_LIGHT = 0.33


@dataclass(frozen=True)
class Legibility:
    """margins (n, n): tone's distance from the local threshold on the right side, part of full contrast.

    ring   the brightest light met on a walk around the dark ring of the lower-left finder, as a part of the
           front's: above `GAP_LIGHT` zxing-cpp finds it broken and takes the code for untilted
    """

    tilt_deg: float
    margins: NDArray[np.float32]
    ring: float

    @property
    def score(self) -> float:
        """One number to maximise: the 5 % weakest margins, and how far the rings stay closed."""
        weakest = float(np.quantile(self.margins, 0.05))
        return weakest + min(0.0, GAP_LIGHT - self.ring)


def legibility(
    scene: Scene, matrix: Matrix, module_mm: float, tilt_deg: float, *, look: Look | None = None
) -> Legibility:
    """The worst of four azimuths at one tilt, module by module.

    AnalysisError if the symbol does not fit the part. Deterministic.
    """
    look = look or Look()
    n = len(matrix.dark)
    if n * module_mm > scene.part.code.edge_mm * 1.001:
        raise AnalysisError(
            f"a symbol of {n * module_mm:.4g} mm does not fit a part of {scene.part.code.edge_mm:.4g} mm: "
            "check the module size"
        )
    faces = [_seen(scene, n, module_mm, tilt_deg, azimuth, look) for azimuth in AZIMUTHS_DEG]
    margins = np.min([_margins(tone, matrix.dark, look) for tone in faces], axis=0).astype(np.float32)
    margins.setflags(write=False)
    return Legibility(tilt_deg, margins, max(_ring_light(tone, n) for tone in faces))


def _seen(
    scene: Scene, n: int, module_mm: float, tilt_deg: float, azimuth_deg: float, look: Look
) -> NDArray[np.float32]:
    """Light from the symbol, rectified to the front face: (n * MODULE_PX,) squared, front face = 1."""
    view = View(tilt_deg, azimuth_deg, fill=0.8, distance=6.0, size_px=640)
    shot = scene.shot(view, look)
    reflectance = float(np.mean(look.material))
    darkness = np.float32(np.mean(look.ground) / reflectance)
    light = (shot.material + shot.ground * darkness).astype(np.float32)
    step = module_mm / MODULE_PX
    first = (n * MODULE_PX - 1) / 2 * step
    to_plane = np.array([[step, 0, -first], [0, -step, first], [0, 0, 1.0]])
    to_pixels = Camera(view, scene.part.code).homography(0.0) @ to_plane
    size = (n * MODULE_PX, n * MODULE_PX)
    return warp(light, np.linalg.inv(to_pixels).astype(np.float64), size) / np.float32(look.light.on_front)


def _margins(light: NDArray[np.float32], dark: NDArray[np.bool_], look: Look) -> NDArray[np.float32]:
    n = len(dark)
    tone = np.clip(light, 0, None) ** np.float32(1 / look.optics.gamma)
    inset = round(MODULE_PX * (1 - CORE) / 2)
    cells = tone.reshape(n, MODULE_PX, n, MODULE_PX)[
        :, inset : MODULE_PX - inset, :, inset : MODULE_PX - inset
    ]
    mean = cells.mean(axis=(1, 3))
    side = 2 * (THRESHOLD_MODULES // 2) + 1
    low, high = (f(mean, np.ones((side, side))) for f in (cv2.erode, cv2.dilate))
    side_of = np.where(dark, -1.0, 1.0).astype(np.float32)
    return (side_of * (mean - (low + high) / 2)).astype(np.float32)


def _ring_light(light: NDArray[np.float32], n: int) -> float:
    """The brightest cross-section met along the dark ring: a bar is bright over the whole ring's width."""
    ring = light[MODULE_PX * (n - RING_WIDTH) :, : MODULE_PX * RING_WIDTH]
    strips = (np.rot90(ring, side)[:MODULE_PX] for side in range(4))
    # The darkest point across the ring at each place along it; a bar leaves none dark.
    return max(float(strip.min(axis=0)[MODULE_PX:-MODULE_PX].max()) for strip in strips)
