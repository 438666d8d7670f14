"""Where the modules lie in the picture: a homography, and a smooth warp for pages that are not flat.

Module coordinates: x right, y down, the symbol from (0, 0) to (n, n); module (r, c) has its centre at
(c + 0.5, r + 0.5). Pixel coordinates: x right, y down, pixel centres at integers, as in OpenCV.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.floating]

CORNERS = np.array(
    [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
)  # of a unit square, clockwise from top left


@dataclass(frozen=True, eq=False)
class Grid:
    """Map from the n × n modules to pixels: pixel = H · (u + warp(u)).

    homography (3, 3);  warp (k, k, 2) displacement in modules at even steps over 0..n, [row, column]
    """

    size: int
    homography: Floats
    warp: Floats

    @classmethod
    def flat(cls, size: int, homography: Floats) -> Grid:
        """A grid without warp."""
        return cls(size, homography, np.zeros((2, 2, 2)))

    @classmethod
    def from_corners(cls, size: int, corners: ArrayLike) -> Grid:
        """Grid with outer corners (4, 2) given in pixels, clockwise from the one of the top-left finder."""
        return cls.flat(size, homography_of(CORNERS * size, np.asarray(corners, np.float64)))

    def pixels(self, points: Floats) -> Floats:
        """(…, 2) pixel coordinates of (…, 2) module coordinates."""
        return project(self.homography, points + self.displacement(points))

    def displacement(self, points: Floats) -> Floats:
        """(…, 2) warp at (…, 2) module coordinates, in modules; constant beyond the symbol."""
        if not self.warp.any():
            return np.zeros_like(points)
        steps = self.warp.shape[0] - 1
        at = np.clip(points / self.size, 0.0, 1.0) * steps
        low = np.minimum(at.astype(np.intp), steps - 1)
        part = (at - low)[..., None]
        column, row = low[..., 0], low[..., 1]
        right, down = part[..., 0, :], part[..., 1, :]
        top = self.warp[row, column] * (1 - right) + self.warp[row, column + 1] * right
        bottom = self.warp[row + 1, column] * (1 - right) + self.warp[row + 1, column + 1] * right
        return top * (1 - down) + bottom * down

    def moved(self, transform: Floats) -> Grid:
        """The grid in a picture whose pixels were mapped by a (3, 3) transform."""
        return replace(self, homography=transform @ self.homography)

    @property
    def corners(self) -> Floats:
        """(4, 2) outer corners in pixels, clockwise from the top-left finder's."""
        return self.pixels(CORNERS * self.size)

    @property
    def module_px(self) -> float:
        """Mean width of a module in pixels; 0 when the outline is not a convex quadrilateral."""
        area = convex_area(self.corners)
        return float(np.sqrt(area)) / self.size


def convex_area(corners: Floats) -> float:
    """Area of a convex quadrilateral (4, 2) in either sense of rotation; 0 for any other."""
    if not np.all(np.isfinite(corners)):
        return 0.0
    edges = np.roll(corners, -1, axis=0) - corners
    turns = cross(edges, np.roll(edges, -1, axis=0))
    if not (np.all(turns > 0) or np.all(turns < 0)):
        return 0.0
    return float(abs(cross(corners[2] - corners[0], corners[3] - corners[1]))) / 2


def cross(a: Floats, b: Floats) -> Any:
    """z of the cross product of (…, 2) vectors."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def homography_of(source: Floats, target: Floats) -> Floats:
    """The (3, 3) homography through four point pairs, scaled so that its last entry is 1."""
    return np.asarray(
        cv2.getPerspectiveTransform(source.astype(np.float32), target.astype(np.float32)), np.float64
    )


def project(homography: Floats, points: Floats) -> Floats:
    """(…, 2) points through a (3, 3) homography; those on its horizon come out as no finite numbers."""
    lifted = points @ homography[:, :2].T + homography[:, 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        return lifted[..., :2] / lifted[..., 2:]


def look_up(image: NDArray[Any], points: Floats) -> NDArray[np.float32]:
    """(r, c, …) bilinear values of an (h, w[, 3]) image at (r, c, 2) pixel coordinates; edges repeat."""
    at = np.ascontiguousarray(points, np.float32)
    values = cv2.remap(image, at[..., 0], at[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return values.astype(np.float32, copy=False)
