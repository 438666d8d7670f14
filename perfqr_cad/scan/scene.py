"""A part ready to be filmed: built once, photographed from many sides and in many lights."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.scan import photo, plate, sections, skylight
from perfqr_cad.scan.camera import Camera, View
from perfqr_cad.scan.look import Light, Look
from perfqr_cad.scan.part import Part
from perfqr_cad.scan.plate import Shot

STEEPEST_DEG = 65.0  # no decoder reads a flat print beyond 60° (paper, Fig. 14)
LEAST_WEB_MM = 0.4  # one line of the common nozzle: nothing thinner is printed
SECTION_PX = 800  # sections as fine as a 1000-pixel view that the part fills to 80 %
MARGIN = 1.08  # sections reach this far beyond the part, so that its outer walls have lit air beside them


@dataclass(frozen=True)
class Scene:
    """A part, whose light is worked out on first use. `photo` gives a gray picture (H, W) uint8."""

    part: Part
    least_web_mm: float = LEAST_WEB_MM

    def photo(self, view: View, look: Look | None = None, *, seed: int = 0) -> NDArray[np.uint8]:
        """What the camera delivers, gray."""
        look = look or Look()
        return photo.develop(self.shot(view, look), look, front=look.light.on_front, seed=seed)

    def photo_colour(self, view: View, look: Look | None = None, *, seed: int = 0) -> NDArray[np.uint8]:
        """The same in colour (H, W, 3), red first."""
        look = look or Look()
        return photo.develop_colour(self.shot(view, look), look, front=look.light.on_front, seed=seed)

    def shot(self, view: View, look: Look) -> Shot:
        """Light on the picture before colours and camera faults."""
        camera = Camera(view, self.part.target)
        stack = self._stack()
        reflectance = round(float(np.dot(photo.LUMA, look.material)), 2)
        lit = _lit(self, look.light, look.gap_mm, reflectance)
        return plate.shoot(
            stack, lit, camera, gap_mm=look.gap_mm, front=look.light.on_front, least_web_mm=self.least_web_mm
        )

    def _stack(self) -> sections.Stack:
        return _stack(self)

    def __hash__(self) -> int:
        return id(self.part)


@lru_cache(maxsize=4)
def _stack(scene: Scene) -> sections.Stack:
    vertices = scene.part.in_frame()
    thickness = float(np.ptp(vertices[:, 2]))
    return sections.stack(
        vertices,
        scene.part.faces,
        edge_mm=MARGIN * 2 * float(np.abs(vertices[:, :2]).max()),
        layers=plate.layers_needed(thickness, STEEPEST_DEG, scene.least_web_mm),
        pixels=SECTION_PX,
    )


@lru_cache(maxsize=16)
def _lit(scene: Scene, light: Light, gap_mm: float, reflectance: float) -> skylight.Brightness:
    return skylight.brightness(_stack(scene), light, gap_mm=gap_mm, reflectance=reflectance)


def jittered(view: View, rng: np.random.Generator) -> View:
    """The same view by a hand that is not quite still: a few degrees and a few percent."""
    return replace(
        view,
        tilt_deg=float(np.clip(view.tilt_deg + rng.uniform(-1, 1), 0, 89)),
        azimuth_deg=view.azimuth_deg + float(rng.uniform(-3, 3)),
        roll_deg=view.roll_deg + float(rng.uniform(-4, 4)),
        fill=view.fill * float(rng.uniform(0.92, 1.05)),
    )
