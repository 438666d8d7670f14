"""How the pattern plane lies in a wall of material.

A chart maps pattern points to space at any depth behind the front: depth 0 is the front face, depth
`thickness_mm` the back face. Segments of the pattern become exact or fitted curves on those levels, and walls
between them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np

from perfqr_cad.geometry.arrays import Array, Indices, Mask
from perfqr_cad.geometry.outline import Segment
from perfqr_cad.profile.loft import Level
from perfqr_cad.solid.tables.batches import Surfaces
from perfqr_cad.solid.tables.brep import Batch, CurveTable, Kind, SurfaceTable
from perfqr_cad.surface import Placement

Images = tuple[CurveTable, ...]  # upper edges, lower edges, side edges at the segments' starts and ends


@dataclass(frozen=True, eq=False)
class Traces:
    """Segments on one level of the wall, as edges that run as the segments do; rows count segments.

    images        the same in the parameters of the level's surface; none on planes, or where no face lies
    tolerance_mm  (k,) how far a curve may stray from the surface and from the image's points
    """

    curves: CurveTable
    tolerance_mm: Array
    images: CurveTable = ()


@dataclass(frozen=True, eq=False)
class Band:
    """The surfaces between segments on one level and on the next; rows count segments.

    outward  (k,) whether the surface's own normal points out of the material (to the right of travel)
    images   of the four edges, side edges running downwards; none on planes
    """

    surfaces: SurfaceTable
    outward: Mask
    images: Images


@dataclass(frozen=True, eq=False)
class Columns:
    """What stands on segments of the pattern: their traces level by level, and the walls between."""

    traces: tuple[Traces, ...]
    bands: tuple[Band, ...]

    @staticmethod
    def joined(count: int, levels: int, parts: Sequence[tuple[Indices, Columns]]) -> Columns:
        """One of so many segments, from parts on some of them each."""
        return Columns(
            tuple(_joined_traces(count, [(on, part.traces[k]) for on, part in parts]) for k in range(levels)),
            tuple(
                _joined_bands(count, [(on, part.bands[k]) for on, part in parts]) for k in range(levels - 1)
            ),
        )

    def walled(self, rows: Indices, surfaces: Surfaces) -> Columns:
        """The same with plane walls on some segments."""
        kept = np.arange(len(self.traces[0].tolerance_mm))
        kept[rows] = -1
        bands: list[Band] = []
        for band in self.bands:
            images = tuple(_renumbered(table, kept) for table in band.images)
            walls = (*_renumbered(band.surfaces, kept), Batch(rows, surfaces))
            bands.append(Band(walls, band.outward | (kept < 0), images))
        return Columns(self.traces, tuple(bands))


def _renumbered(table: tuple[Batch[Kind], ...], numbers: Indices) -> tuple[Batch[Kind], ...]:
    return tuple(batch.renumbered(numbers) for batch in table)


def _joined_traces(count: int, parts: Sequence[tuple[Indices, Traces]]) -> Traces:
    tolerance = np.empty(count)
    for on, part in parts:
        tolerance[on] = part.tolerance_mm
    curves = tuple(batch for on, part in parts for batch in _renumbered(part.curves, on))
    images = tuple(batch for on, part in parts for batch in _renumbered(part.images, on))
    return Traces(curves, tolerance, images)


def _joined_bands(count: int, parts: Sequence[tuple[Indices, Band]]) -> Band:
    outward = np.empty(count, np.bool_)
    for on, part in parts:
        outward[on] = part.outward
    surfaces = tuple(batch for on, part in parts for batch in _renumbered(part.surfaces, on))
    images = tuple(
        tuple(batch for on, part in parts for batch in _renumbered(part.images[side], on))
        for side in range(4)
    )
    return Band(surfaces, outward, images)


class Chart(Protocol):
    """What is to be known of a wall of material."""

    @property
    def thickness_mm(self) -> float: ...

    @property
    def whole_circles(self) -> bool:
        """Whether a circle stays one closed segment; else it is given as two half-circles."""
        ...

    def points(self, uv: Array, depth_mm: float) -> Array:
        """Points (k, 3) in space of (k, 2) pattern points at a depth."""
        ...

    def surface(self, depth_mm: float) -> Surfaces:
        """The surface of a face at that depth, one."""
        ...

    def towards_reader(self, depth_mm: float) -> bool:
        """Whether the own normal of `surface(depth_mm)` points towards the reader."""
        ...

    def columns(self, stacks: Sequence[tuple[Segment, ...]], levels: tuple[Level, ...]) -> Columns:
        """Columns on stacks of segments, one segment for each level, front first."""
        ...


Wall = TypeVar("Wall", bound=Placement)


@dataclass(frozen=True, eq=False)
class WallChart(Generic[Wall]):
    """What charts of placements have in common: levels lie where the placement says, and all their surfaces
    look at the reader."""

    wall: Wall

    @property
    def thickness_mm(self) -> float:
        return self.wall.thickness_mm

    def points(self, uv: Array, depth_mm: float) -> Array:
        """As `Chart.points`."""
        return self.wall.at_depth(uv, depth_mm)

    def towards_reader(self, depth_mm: float) -> bool:
        """As `Chart.towards_reader`."""
        return True
