"""What a verifier measures: the part from straight above, lit from four sides, through a round aperture."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from perfqr_cad.scan.camera.camera import Camera, View
from perfqr_cad.scan.camera.look import Light, Look
from perfqr_cad.scan.camera.photo import disc
from perfqr_cad.scan.camera.raster import sample
from perfqr_cad.scan.camera.scene import Scene
from perfqr_cad.symbol import QUIET_MODULES, Symbol

Floats = NDArray[np.float64]
# Four sides at 45° (15415 §7.3.3); an open level face of reflectance 1 gives 1.
LIGHT = Light(
    ambient=0.0, lamp=float(np.sqrt(2)), lamp_azimuth_deg=45.0, lamp_elevation_deg=45.0, lamp_sides=4
)
DISTANCE = 10.0  # of the camera, in edges of the code: a verifier looks nearly along parallel lines
FILL = 0.9
MODULE_PX = 12  # of the picture: more than the ten across an aperture that a verifier has
MOST_PX = 2400
RED = 0  # the channel that a lamp of 660 nm is seen in


@dataclass(frozen=True)
class Sampled:
    """A symbol under a verifier.

    picture      (H, W) reflectance, 1 = all light comes back
    centres_px   (m, m, 2) where the modules' centres are seen, m = modules with `quiet` of them on each side
    module_mm, module_px   edge of a module on the part and in the picture
    quiet        modules of the quiet zone that were looked at; the standard asks for four
    """

    picture: NDArray[np.float32]
    symbol: Symbol
    centres_px: Floats
    module_mm: float
    quiet: int

    @property
    def module_px(self) -> float:
        """Edge of a module in the picture, at the code's centre."""
        middle = len(self.centres_px) // 2
        return float(np.linalg.norm(self.centres_px[middle, middle + 1] - self.centres_px[middle, middle]))

    @cached_property
    def light(self) -> NDArray[np.bool_]:
        """(m, m) whether a module should be light."""
        return np.pad(~self.symbol.matrix.dark, self.quiet, constant_values=True)

    def through(self, aperture: float) -> NDArray[np.float32]:
        """The picture through a round aperture, its diameter in modules."""
        kernel = disc(aperture * self.module_px)
        assert kernel is not None  # an aperture has a width
        return np.asarray(cv2.filter2D(self.picture, -1, kernel), np.float32)

    def reflectances(self, aperture: float) -> Floats:
        """(m, m) mean reflectance in the aperture at the centre of every module."""
        at = np.ascontiguousarray(self.centres_px.reshape(-1, 2).T, np.float32)
        chunks = np.array_split(at, 1 + at.shape[1] // (1 << 14), axis=1)
        seen = self.through(aperture)
        found = np.concatenate([sample(seen, np.ascontiguousarray(chunk)) for chunk in chunks])
        return found.reshape(self.light.shape).astype(np.float64)

    def extremes(self, aperture: float) -> tuple[float, float]:
        """The least and the greatest reflectance met through the aperture anywhere in symbol and quiet
        zone."""
        edge = np.concatenate([
            self.centres_px[0], self.centres_px[:, -1], self.centres_px[-1, ::-1], self.centres_px[::-1, 0]
        ])  # fmt: skip
        inside = np.zeros(self.picture.shape, np.uint8)
        cv2.fillPoly(inside, [np.round(edge).astype(np.int32)], (1,))
        seen = self.through(aperture)[inside > 0]
        return float(seen.min()), float(seen.max())


def sampled(
    scene: Scene,
    look: Look,
    symbol: Symbol,
    *,
    module_mm: float,
    quiet: int,
    on_surface: Callable[[Floats], Floats] | None = None,
) -> Sampled:
    """The part before the ground of `look`, as a verifier sees it.

    on_surface   points (k, 3) of the front from (k, 2) in the pattern plane; None: the code is flat
    """
    quiet = min(quiet, QUIET_MODULES)
    count = symbol.size + 2 * quiet
    edge_mm = scene.part.code.edge_mm
    size_px = min(MOST_PX, int(np.ceil(edge_mm / module_mm * MODULE_PX / FILL)))
    view = View(fill=FILL, distance=DISTANCE, size_px=size_px)
    shot = scene.shot(view, Look(look.material, look.ground, look.gap_mm, light=LIGHT, phone=False))
    picture = look.material[RED] * shot.material + look.ground[RED] * shot.ground
    steps = (np.arange(count) - (count - 1) / 2) * module_mm
    plane = np.stack(np.meshgrid(steps, -steps), axis=-1).reshape(-1, 2).astype(np.float64)
    code = scene.part.code
    points = code.centre_mm + plane @ code.axes[:2] if on_surface is None else on_surface(plane)
    seen = Camera(view, code).project(np.asarray(points, np.float64)).reshape(count, count, 2)
    return Sampled(picture.astype(np.float32), symbol, seen, module_mm, quiet)


def centroid(sampled: Sampled, dark: NDArray[np.bool_], row: int, column: int, half: float) -> Floats:
    """Where the dark square about a module (row and column of the symbol) is seen: the centre of its dark
    pixels (2,).

    half   half of the square's edge in modules; half a module around it is looked at too. The module's own
           place when nothing there is dark.
    """
    at = sampled.centres_px[row + sampled.quiet, column + sampled.quiet]
    reach = (half + 0.5) * sampled.module_px
    low = np.maximum(np.round(at - reach).astype(int), 0)
    high = np.round(at + reach).astype(int) + 1
    y, x = np.nonzero(dark[low[1] : high[1], low[0] : high[0]])
    return at if len(x) == 0 else np.array([x.mean(), y.mean()]) + low
