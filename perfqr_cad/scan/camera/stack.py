"""A plate as a stack of sections: how much of every pixel is material, at several depths.

A section of a closed mesh is the set of directed segments in which its triangles cut a plane; its
picture is the exact area of material in each pixel, by the signed-area sum used for glyphs.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
# Sections are cut this far inside the end faces, as a part of the thickness: a cut in a face is undefined.
END_INSET = 1e-4
MARGIN = 1.08  # sections reach this far beyond the part, so that its outer walls have lit air beside them
UPRIGHT = 1e-6  # walls lean by less than this (sine) when all sections between two levels are the same


@dataclass(frozen=True)
class Stack:
    """Sections of a plate, front first.

    material   K pictures (n, n) uint8, 255 = solid, row 0 at the top (largest y); where walls are upright,
               neighbours are one and the same array
    depth_mm   (K,) below the front face, increasing
    edge_mm    edge of the square that the pictures cover, centred on the code
    """

    material: tuple[NDArray[np.uint8], ...]
    depth_mm: Floats
    edge_mm: float

    @property
    def pixels(self) -> int:
        """Edge of the pictures in pixels."""
        return self.material[0].shape[0]

    @property
    def px_per_mm(self) -> float:
        """Resolution of the pictures."""
        return self.pixels / self.edge_mm

    @cached_property
    def bounds(self) -> tuple[int, int, int, int]:
        """The pixels (left, top, right, bottom) beyond which no section has material."""
        pictures = {id(picture): picture for picture in self.material}.values()
        columns = np.flatnonzero(np.any([picture.any(axis=0) for picture in pictures], axis=0))
        rows = np.flatnonzero(np.any([picture.any(axis=1) for picture in pictures], axis=0))
        if len(rows) == 0:
            return 0, 0, 0, 0
        return int(columns[0]) - 1, int(rows[0]) - 1, int(columns[-1]) + 1, int(rows[-1]) + 1

    def to_plane(self) -> Floats:
        """(3, 3) from picture pixels (centres at whole numbers) to (x, y) in mm."""
        step, n = self.edge_mm / self.pixels, self.pixels
        first = (n - 1) / 2 * step
        return np.array([[step, 0, -first], [0, -step, first], [0, 0, 1.0]])


def section_outline(vertices: Floats, faces: NDArray[np.integer], height: float) -> Floats:
    """Directed segments (s, 2, 2) in which the plane z = `height` cuts the mesh, material on their left.

    vertices (k, 3), faces (m, 3) closed and oriented outward.
    """
    above = vertices[:, 2] > height
    count = above[faces].sum(axis=1)
    crossed = faces[(count == 1) | (count == 2)]
    if len(crossed) == 0:
        return np.zeros((0, 2, 2))
    side = above[crossed]
    # Turn each triangle so that its first vertex is the one alone on its side of the plane.
    alone = np.where(side.sum(axis=1) == 1, side.argmax(axis=1), (~side).argmax(axis=1))
    turned = np.take_along_axis(crossed, (alone[:, None] + np.arange(3)) % 3, axis=1)
    corner = vertices[turned]

    def crossing(other: int) -> Floats:
        start, end = corner[:, 0], corner[:, other]
        part = (height - start[:, 2]) / (end[:, 2] - start[:, 2])
        return (start + part[:, None] * (end - start))[:, :2]

    segments = np.stack([crossing(1), crossing(2)], axis=1)
    lone_above = above[turned[:, 0]]
    segments[lone_above] = segments[lone_above][:, ::-1]
    return segments


def _upright(vertices: Floats, faces: NDArray[np.integer], height: float) -> bool:
    """Whether every triangle that the plane z = `height` cuts stands upright."""
    above = (vertices[:, 2] > height)[faces].sum(axis=1)
    corner = vertices[faces[(above == 1) | (above == 2)]]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    return bool(np.all(np.abs(normal[:, 2]) <= UPRIGHT * np.linalg.norm(normal, axis=1)))


def area(segments: Floats, shape: tuple[int, int]) -> NDArray[np.float32]:
    """Exact area (H, W) in [0, 1] that directed loops, given as segments in pixels, cover of each pixel.

    Pixel (row, column) is the square [column, column + 1] x [row, row + 1]; a loop that runs
    clockwise on the screen (y down) counts as positive or negative alike: the result is |area|.
    """
    height, width = shape
    pieces = _split(_split(segments, axis=1), axis=0)
    middle = pieces.mean(axis=1)
    row = np.floor(middle[:, 1]).astype(np.int64)
    column = np.clip(np.floor(middle[:, 0]), -1, width).astype(np.int64)
    rise = pieces[:, 1, 1] - pieces[:, 0, 1]
    inside = (row >= 0) & (row < height) & (rise != 0)
    row, column, rise, x = row[inside], column[inside], rise[inside], middle[inside, 0]
    right = np.clip(x - column, 0.0, 1.0)
    # Two guard columns take what lies left and right of the picture.
    start = row * (width + 3) + column + 1
    size = height * (width + 3)
    sums = np.bincount(start, rise * (1 - right), size) + np.bincount(start + 1, rise * right, size)
    covered = np.abs(np.cumsum(sums.reshape(height, width + 3), axis=1))[:, 1 : width + 1]
    return np.clip(covered, 0.0, 1.0).astype(np.float32)


def _split(segments: Floats, axis: int) -> Floats:
    """Cut segments (s, 2, 2) wherever the coordinate `axis` passes a whole number."""
    start, end = segments[:, 0], segments[:, 1]
    low = np.minimum(start[:, axis], end[:, axis])
    high = np.maximum(start[:, axis], end[:, axis])
    first = np.floor(low) + 1
    cuts = np.maximum(np.ceil(high) - first, 0).astype(np.int64)
    owner = np.repeat(np.arange(len(segments)), cuts + 1)
    order = np.arange(len(owner)) - np.repeat(np.cumsum(cuts + 1) - (cuts + 1), cuts + 1)
    span = np.where(high > low, high - low, 1.0)
    lower = np.where(order > 0, (first[owner] + order - 1 - low[owner]) / span[owner], 0.0)
    upper = np.where(order < cuts[owner], (first[owner] + order - low[owner]) / span[owner], 1.0)
    flip = start[owner, axis] > end[owner, axis]
    begin = np.where(flip, 1 - upper, lower)[:, None]
    finish = np.where(flip, 1 - lower, upper)[:, None]
    step = end[owner] - start[owner]
    return np.stack([start[owner] + begin * step, start[owner] + finish * step], axis=1)


def cut_stack(
    vertices: Floats, faces: NDArray[np.integer], *, edge_mm: float, layers: int, pixels: int
) -> Stack:
    """Sections of a plate between its lowest and highest z.

    vertices (k, 3) mm in the code's frame: x right, y up, z towards the reader.
    """
    top, bottom = float(vertices[:, 2].max()), float(vertices[:, 2].min())
    inset = END_INSET * (top - bottom)
    scale = pixels / edge_mm
    levels = np.unique(np.round(vertices[:, 2], 6))
    kept: dict[int, NDArray[np.uint8]] = {}
    material: list[NDArray[np.uint8]] = []
    for height in np.linspace(top - inset, bottom + inset, layers):
        slab = int(np.searchsorted(levels, height))
        if slab not in kept:
            segments = section_outline(vertices, faces, float(height)) * [scale, -scale] + pixels / 2
            picture = (255 * area(segments, (pixels, pixels)) + 0.5).astype(np.uint8)
            picture.setflags(write=False)
            material.append(picture)
            if _upright(vertices, faces, float(height)):
                kept[slab] = picture
        else:
            material.append(kept[slab])
    return Stack(tuple(material), np.linspace(0.0, top - bottom, layers), edge_mm)
