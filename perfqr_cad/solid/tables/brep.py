"""A boundary representation as a value: tables of vertices, edges, loops and faces.

Loops are given as one sees a face from outside the material, the face to the left of travel. Geometry comes
in batches of one kind, each with the rows of the table that it belongs to.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Generic, TypeVar

import numpy as np

from perfqr_cad.geometry.arrays import Array, Indices, Mask
from perfqr_cad.geometry.cycles import following, owners
from perfqr_cad.solid.tables.batches import Curves, Surfaces

TOLERANCE_MM = 1e-7  # of an exact edge: what solid modellers take for one point (Precision::Confusion)

Kind = TypeVar("Kind", Curves, Surfaces)


@dataclass(frozen=True, eq=False)
class Batch(Generic[Kind]):
    """Geometry of one kind, and the rows (edges, faces or uses) of a table that it belongs to, (k,)."""

    rows: Indices
    of: Kind

    def renumbered(self, numbers: Indices) -> Batch[Kind]:
        """The same for other rows: the number of each old one, −1 for those to leave out."""
        rows = numbers[self.rows]
        kept = np.flatnonzero(rows >= 0)
        if len(kept) == len(rows):
            return Batch(rows, self.of)
        return Batch(rows[kept], self.of[kept])


CurveTable = tuple[Batch[Curves], ...]
SurfaceTable = tuple[Batch[Surfaces], ...]


@dataclass(frozen=True, eq=False)
class Brep:
    """The boundary of a solid, mm.

    points        (V, 3) of the vertices
    ends          (E, 2) vertices where each edge starts and ends; −1 where it has none
    curves        by edge
    tolerance_mm  (E,) by which an edge may miss its vertices, its faces and its images
    edges, ahead  (U,) the edge of each use, and whether the loop runs along it
    images        by use, in the parameters of the face's surface; planes need none
    loops         (L + 1,) first use of each loop, and the end
    bounds        (F + 1,) first loop of each face, which is its outer one, and the end
    surfaces      by face
    outward       (F,) whether the surface's own normal points out of the material
    shells        (S + 1,) first face of each shell, the outer one first, and the end

    Where a surface closes in a point there is a vertex, and no edge.
    """

    points: Array
    ends: Indices
    curves: CurveTable
    tolerance_mm: Array
    edges: Indices
    ahead: Mask
    images: CurveTable
    loops: Indices
    bounds: Indices
    surfaces: SurfaceTable
    outward: Mask
    shells: Indices

    def __post_init__(self) -> None:
        for field in fields(self):
            table = getattr(self, field.name)
            if isinstance(table, np.ndarray):
                table.setflags(write=False)

    @property
    def face_count(self) -> int:
        return len(self.outward)

    @property
    def face_of_loop(self) -> Indices:
        """(L,)."""
        return owners(self.bounds)

    @property
    def face_of_use(self) -> Indices:
        """(U,)."""
        return self.face_of_loop[owners(self.loops)]

    @property
    def following(self) -> Indices:
        """(U,) the next use of the same loop."""
        return following(self.loops)

    @property
    def tails(self) -> Indices:
        """(U,) the vertex at which each use begins."""
        return self.ends[self.edges, np.where(self.ahead, 0, 1)]

    @property
    def heads(self) -> Indices:
        """(U,) the vertex at which each use ends."""
        return self.ends[self.edges, np.where(self.ahead, 1, 0)]
