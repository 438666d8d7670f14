"""The body of the phone that takes the picture: it stands before the part and hides some of the light."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.scan.camera.camera import Camera

Floats = NDArray[np.float64]
BODY_MM = (75.0, 150.0)  # of a common phone, width and height
CAMERA_MM = (-18.0, -58.0)  # its main camera from the middle of the body, right and down in the picture
PATCH_DEG = 16.6  # radius of a patch of sky that one of 24 directions stands for
PATCH_POINTS = 24


@dataclass(frozen=True)
class PhoneBody:
    """A rectangle through the camera, in the frame of the code (z towards the reader).

    eye (3,) mm, axes (3, 3): the picture's right, down and forward
    """

    eye: Floats
    axes: Floats

    @classmethod
    def of(cls, camera: Camera) -> PhoneBody:
        """The phone behind a camera."""
        code = camera.code
        return cls((camera.eye_mm - code.centre_mm) @ code.axes.T, camera.rotation @ code.axes.T)

    def hides(self, origins: NDArray[np.floating], ways: NDArray[np.floating]) -> NDArray[np.bool_]:
        """Whether rays (k, 3) from points (k, 3) end on the body."""
        right, down, forward = self.axes
        towards = -(ways @ forward)
        reach = ((origins - self.eye) @ forward) / np.where(towards > 1e-9, towards, np.inf)
        met = origins + ways * reach[:, None] - self.eye
        across, along = (met @ right + CAMERA_MM[0], met @ down + CAMERA_MM[1])
        inside = (np.abs(across) < BODY_MM[0] / 2) & (np.abs(along) < BODY_MM[1] / 2)
        return inside & (towards > 1e-9)

    def shares(self, towards: Floats) -> Floats:
        """How much of patches of sky around directions (k, 3) it hides from the code's centre, 0 to 1."""
        k = np.arange(PATCH_POINTS)
        angle = np.radians(PATCH_DEG) * np.sqrt((k + 0.5) / PATCH_POINTS)
        turn = k * np.pi * (3 - np.sqrt(5))
        shares = np.zeros(len(towards))
        for index, direction in enumerate(towards):
            first = np.cross(direction, [0.0, 1.0, 0.0] if abs(direction[1]) < 0.9 else [1.0, 0.0, 0.0])
            first /= np.linalg.norm(first)
            second = np.cross(direction, first)
            aside = np.cos(turn)[:, None] * first + np.sin(turn)[:, None] * second
            ways = np.cos(angle)[:, None] * direction + np.sin(angle)[:, None] * aside
            shares[index] = self.hides(np.zeros((PATCH_POINTS, 3)), ways).mean()
        return shares
