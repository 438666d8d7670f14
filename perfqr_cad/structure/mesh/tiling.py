"""A light region cut into square tiles about the module corners, sorted by what is in them.

Modules repeat, so a plain code of 3,000 tiles has some 30 different ones: meshing and condensing those serves
all of them. The cuts run near module centres, where outlines cross them squarely, and a tile holds one module
corner with its fillet.

Coordinates here are whole units of about 0.05 µm. Outline points lie on even units and cuts on odd ones, so
no point is on a cut, and both tiles beside a cut agree exactly on where an outline crosses it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry import MultiPolygon, Polygon

from perfqr_cad.structure.mesh.triangle import Floats, Ints

UNIT_MM = 5e-5  # about: far below any printer, far above the rounding of a double at 1 m
SHIFTS = (0.0, 0.25, -0.25, 0.125, -0.125, 0.375, -0.375)  # of half a tile: where cuts may run instead
NEAR_CUT = 0.04  # of a tile: an outline this close to a cut and along it makes slivers


@dataclass(frozen=True)
class TileLattice:
    """Squares of `pitch_mm` that repeat in a region; four of them meet at `corner_mm`."""

    pitch_mm: float
    corner_mm: tuple[float, float] = (0.0, 0.0)

    @property
    def half(self) -> int:
        """Units in half a pitch, an even number."""
        return 2 * max(1, round(self.pitch_mm / 4 / UNIT_MM))

    @property
    def unit_mm(self) -> float:
        """Millimetres to a unit."""
        return self.pitch_mm / 2 / self.half


@dataclass(frozen=True)
class TileContent:
    """What a tile holds, in units from its centre.

    `edges` (k, 4) are directed pieces x0 y0 x1 y1 of outline with material on their left, `classes` (k,) the
    class of that material, `corners` (classes, 4) whether the low left, low right, up right and up left
    corner of the tile are in it.
    """

    edges: Ints
    classes: Ints
    corners: NDArray[np.bool_]

    @property
    def key(self) -> bytes:
        """Equal for tiles of equal content."""
        return b"|".join(part.tobytes() for part in (self.edges, self.classes, self.corners))


@dataclass(frozen=True)
class Tiling:
    """Tiles by rows: column and row on the lattice (k, 2), and which of the `contents` each has (k,).

    A tile spans [low, low + 2·half] units from its centre on both axes.
    """

    lattice: TileLattice
    low: int
    places: Ints
    content_of: Ints
    contents: tuple[TileContent, ...]

    @property
    def centres(self) -> Ints:
        """Centres (k, 2) of the tiles in units from `lattice.corner_mm`."""
        return self.places * (2 * self.lattice.half)

    @property
    def centres_mm(self) -> Floats:
        """Centres (k, 2) of the tiles in mm."""
        x, y = self.lattice.corner_mm
        return np.array([x, y]) + self.places.astype(float) * self.lattice.pitch_mm


def cut(regions: Sequence[Polygon | MultiPolygon], lattice: TileLattice) -> Tiling:
    """Cut regions, one for each class of material and disjoint, into tiles; empty ones are left out."""
    loops = [_edges(region, lattice) for region in regions]
    size = 2 * lattice.half
    low = _low(np.concatenate(loops), size)
    parts = [_split(_split(edges, 0, low, size), 1, low, size) for edges in loops]
    edges = np.concatenate(parts)
    classes = np.repeat(np.arange(len(parts)), [len(part) for part in parts])
    places = (edges[:, :2] + edges[:, 2:] - 2 * low) // (2 * size)
    first, shape = places.min(axis=0), np.ptp(places, axis=0) + 1
    corners = np.stack([_corners_inside(part, low, size, first, shape) for part in parts])
    edges = edges - np.tile(places * size, 2)
    number = (places - first) @ [shape[1], 1]
    order = np.lexsort((*edges.T[::-1], classes, number))
    edges, classes, number = edges[order], classes[order], number[order]
    full = np.flatnonzero(corners.all(axis=3).any(axis=0).ravel())
    tiles = np.union1d(number, full)
    bounds = np.searchsorted(number, np.append(tiles, tiles[-1] + 1))
    row, column = np.divmod(tiles, shape[1])
    inside = corners[:, row, column].transpose(1, 0, 2)
    index: dict[bytes, int] = {}
    contents: list[TileContent] = []
    content_of = np.empty(len(tiles), np.int64)
    for k, (start, end) in enumerate(pairwise(bounds)):
        content = TileContent(edges[start:end], classes[start:end], inside[k])
        content_of[k] = index.setdefault(content.key, len(contents))
        if content_of[k] == len(contents):
            contents.append(content)
    places = np.stack([row, column], axis=1) + first
    return Tiling(lattice, low, places, content_of, tuple(contents))


def _edges(region: Polygon | MultiPolygon, lattice: TileLattice) -> Ints:
    """Directed edges (k, 4), material on the left, repeated points dropped."""
    rings = shapely.get_rings(shapely.get_parts(shapely.orient_polygons(region)))
    points, ring = shapely.get_coordinates(rings, return_index=True)
    units = (points - np.asarray(lattice.corner_mm)) / lattice.unit_mm
    even = 2 * np.rint(units / 2).astype(np.int64)
    edges = np.hstack([even[:-1], even[1:]])[ring[1:] == ring[:-1]]
    return edges[(edges[:, :2] != edges[:, 2:]).any(axis=1)]


def _low(edges: Ints, size: int) -> int:
    """Where cuts run: where the least length of outline lies along them."""
    run = edges[:, 2:] - edges[:, :2]
    length = np.hypot(run[:, 0], run[:, 1])

    def along(low: int) -> float:
        off = (edges[:, :2] - low + size // 2) % size - size // 2
        near = (np.abs(off) < NEAR_CUT * size) & (np.abs(run) < NEAR_CUT * size)
        return float(length @ near.sum(axis=1))

    return min((-size // 2 + 2 * round(shift * size / 4) - 1 for shift in SHIFTS), key=along)


def _split(edges: Ints, axis: int, low: int, size: int) -> Ints:
    """Edges cut where they cross the lines low + k·size of one axis."""
    cells = (edges[:, [axis, 2 + axis]] - low) // size
    crossings = np.abs(cells[:, 1] - cells[:, 0])
    edge = np.repeat(np.arange(len(edges)), crossings + 1)
    step = np.arange(len(edge)) - np.repeat(np.cumsum(crossings + 1) - crossings - 1, crossings + 1)
    start, end = edges[edge, :2], edges[edge, 2:]
    rising = cells[edge, 1] > cells[edge, 0]

    def point(step: Ints) -> Ints:
        """Where the edge crosses its line number `step` from 1; its ends before the first, after the last."""
        line = low + size * np.where(rising, cells[edge, 0] + step, cells[edge, 0] - step + 1)
        run = (end - start).astype(float)
        run_across = np.where(run[:, axis] == 0.0, 1.0, run[:, axis])
        at = start[:, 1 - axis] + (line - start[:, axis]) / run_across * run[:, 1 - axis]
        crossing = np.empty_like(start)
        crossing[:, axis] = line
        crossing[:, 1 - axis] = 2 * np.rint(at / 2)
        first, last = (step < 1)[:, None], (step > crossings[edge])[:, None]
        return np.where(first, start, np.where(last, end, crossing))

    parts = np.hstack([point(step), point(step + 1)])
    return parts[(parts[:, :2] != parts[:, 2:]).any(axis=1)]


def _corners_inside(edges: Ints, low: int, size: int, first: Ints, shape: Ints) -> NDArray[np.bool_]:
    """Which corners of each tile of a grid lie in a region: (columns, rows, 4), by parity along the cuts."""
    crossing = edges[(edges[:, 1] - low) % size == 0, :2]
    column, line = ((crossing - low) // size - first).T
    counts = np.zeros((shape[0] + 1, shape[1] + 1), np.int64)
    np.add.at(counts, (column + 1, line), 1)
    inside = np.cumsum(counts, axis=0) % 2 == 1
    return np.stack([inside[:-1, :-1], inside[1:, :-1], inside[1:, 1:], inside[:-1, 1:]], axis=-1)
