"""The flat print of a code: what a decoder can do at best with it, from the same views."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.scan.camera import layers, photo, skylight
from perfqr_cad.scan.camera.camera import Camera, View, facing_up
from perfqr_cad.scan.camera.look import Look
from perfqr_cad.scan.camera.phone import PhoneBody
from perfqr_cad.scan.camera.stack import Stack

LEAST_PX = 720  # edge of the printed picture: finer than the camera sees it


@dataclass(frozen=True)
class FlatPrint:
    """A print with its quiet zone: `material` (k, k) bool is as bright as that, all else as the ground."""

    material: NDArray[np.bool_]
    edge_mm: float

    def prepare(self, look: Look) -> None:
        """Nothing has to be worked out before a flat print is filmed."""

    def photo(self, view: View, look: Look | None = None, *, seed: int = 0) -> NDArray[np.uint8]:
        """Gray picture (H, W) uint8, by the same camera as the part's."""
        look = look or Look()
        camera = Camera(view, facing_up((0.0, 0.0, 0.0), self.edge_mm))
        hidden = PhoneBody.of(camera).shares(skylight.towards(look.light)) if look.phone else None
        lit = skylight.open_face(look.light, hidden)
        shot = layers.shoot(self._stack(), lit, camera, gap_mm=0.0, least_web_mm=1.0)
        return photo.develop(shot, look, front=look.light.on_front, seed=seed)

    def _stack(self) -> Stack:
        repeat = -(-LEAST_PX // len(self.material))
        picture = np.kron(self.material, np.ones((repeat, repeat), bool)) * np.uint8(255)
        return Stack((picture,), np.zeros(1), self.edge_mm)


def printed(
    dark: NDArray[np.bool_],
    edge_mm: float,
    *,
    quiet_modules: int = 4,
    scale: int = 1,
    inverted: bool = False,
) -> FlatPrint:
    """The print of a symbol, or of its art at `scale` samples a module; `edge_mm` with the quiet zone.

    inverted   the material is what is dark, and the ground what is light

    >>> printed(np.ones((21, 21), bool), 29.0).photo(View(size_px=64)).shape
    (64, 64)
    """
    light = np.pad(~dark, quiet_modules * scale, constant_values=True)
    return FlatPrint(light ^ inverted, edge_mm)
