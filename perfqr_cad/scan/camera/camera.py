"""A pinhole camera that looks at a code: where it stands, and where points and planes appear to it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.errors import AnalysisError

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class View:
    """From where a square code is filmed.

    tilt_deg      angle between the optical axis and the code's normal, 0 to below 90
    azimuth_deg   direction of the tilt in the code's plane, from its x axis towards y
    roll_deg      rotation of the camera about its optical axis; at 0 the code's top is up
    fill          edge of the code over the edge of the picture, seen frontally
    distance      camera to the code's centre, in edges of the code (a phone's main camera, some
                  65° wide, is 1.6 edges away when the code fills half of its frame)
    size_px       edge of the square picture
    """

    tilt_deg: float = 0.0
    azimuth_deg: float = 0.0
    roll_deg: float = 0.0
    fill: float = 0.7
    distance: float = 2.5
    size_px: int = 1000

    def __post_init__(self) -> None:
        if not 0.0 <= self.tilt_deg < 90.0:
            raise AnalysisError(f"tilt {self.tilt_deg:g}° is outside 0° to 90°: film the code from its front")
        if not (self.fill > 0.0 and self.distance > 0.5 and 16 <= self.size_px <= 8192):
            raise AnalysisError(
                f"no picture with fill {self.fill:g}, distance {self.distance:g}, {self.size_px} px: "
                "choose fill > 0, distance > 0.5 and 16 to 8192 px"
            )


@dataclass(frozen=True)
class CodeFrame:
    """The square that is looked at: its centre and axes (rows: x, y, normal) in mm, and its edge."""

    centre_mm: Floats
    axes: Floats
    edge_mm: float


def facing_up(centre_mm: tuple[float, float, float], edge_mm: float) -> CodeFrame:
    """A code whose normal is z and whose right is x."""
    return CodeFrame(np.asarray(centre_mm, float), np.eye(3), edge_mm)


@dataclass(frozen=True)
class Camera:
    """Projection of a view of a code. Pixel centres are at whole numbers, row 0 at the top."""

    view: View
    code: CodeFrame

    @cached_property
    def eye_mm(self) -> Floats:
        """Centre of projection (3,)."""
        return self.code.centre_mm + self._outward * self.view.distance * self.code.edge_mm

    @cached_property
    def _outward(self) -> Floats:
        tilt, azimuth = np.radians(self.view.tilt_deg), np.radians(self.view.azimuth_deg)
        local = [np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), np.cos(tilt)]
        return np.asarray(local) @ self.code.axes

    @cached_property
    def rotation(self) -> Floats:
        """World to camera (3, 3): rows are the picture's right, down and forward."""
        forward = -self._outward
        up = self.code.axes[1]
        # Looking along the code's y axis, its x axis is kept level instead.
        right = self.code.axes[0] if abs(forward @ up) > 0.99 else np.cross(forward, up)
        right = np.asarray(right / np.linalg.norm(right), np.float64)
        down = np.cross(forward, right)
        roll = np.radians(self.view.roll_deg)
        turned = np.cos(roll) * right + np.sin(roll) * down
        return np.stack([turned, np.cross(forward, turned), forward]).astype(np.float64)

    @property
    def focal_px(self) -> float:
        """Focal length in pixels: what makes the code fill the asked part of the picture."""
        return self.view.fill * self.view.size_px * self.view.distance

    @cached_property
    def intrinsics(self) -> Floats:
        """The matrix K (3, 3)."""
        centre = (self.view.size_px - 1) / 2
        return np.array([[self.focal_px, 0, centre], [0, self.focal_px, centre], [0, 0, 1.0]])

    def homography(self, depth_mm: float) -> Floats:
        """(3, 3) from the code's (x, y) in mm, on the plane `depth_mm` behind it, to pixels."""
        axes, origin = self.code.axes, self.code.centre_mm - depth_mm * self.code.axes[2]
        return self.intrinsics @ self.rotation @ np.column_stack([axes[0], axes[1], origin - self.eye_mm])

    def project(self, points_mm: Floats) -> Floats:
        """Pixels (k, 2) of points (k, 3) in mm."""
        seen = (points_mm - self.eye_mm) @ self.rotation.T @ self.intrinsics.T
        return seen[:, :2] / seen[:, 2:]

    def rays(self, axes: Floats, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Ways through the pixels of a window, row by row (k, 3), in the frame with these axes (rows).

        Their length is such that they advance by 1 along the optical axis.
        """
        right, down, forward = (self.rotation @ axes.T).astype(np.float32)
        pixel = (np.arange(self.view.size_px) - (self.view.size_px - 1) / 2) / self.focal_px
        pixel = pixel.astype(np.float32)
        ways = pixel[rows][:, None, None] * down + (pixel[columns][:, None] * right + forward)
        return ways.reshape(-1, 3)

    def window(self, points_mm: Floats) -> tuple[slice, slice]:
        """Rows and columns of the picture that hold points (k, 3), with a pixel around.

        The whole picture when some of the points are not before the camera.
        """
        if np.any((points_mm - self.eye_mm) @ self.rotation[2] <= 0):
            return slice(0, self.view.size_px), slice(0, self.view.size_px)
        seen = self.project(points_mm)
        low = np.clip(np.floor(seen.min(axis=0)), 0, self.view.size_px - 1).astype(int)
        high = np.clip(np.ceil(seen.max(axis=0)) + 1, low + 1, self.view.size_px).astype(int)
        return slice(low[1], high[1]), slice(low[0], high[0])
