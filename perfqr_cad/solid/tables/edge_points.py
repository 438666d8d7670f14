"""Points along the edges of a boundary representation, in space and in the parameters of its faces."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from perfqr_cad.geometry.arrays import Array, Indices, Mask
from perfqr_cad.geometry.cycles import numbering, owners, starts_of
from perfqr_cad.solid.tables.batches import Lines, Planes
from perfqr_cad.solid.tables.brep import Brep, CurveTable

PIECES = 8  # of a curved edge
JUMP = 1e-6  # between parameters, beyond which they are two places
FRACTIONS = np.linspace(0.0, 1.0, PIECES + 1)


@dataclass(frozen=True, eq=False)
class EdgePoints:
    """What the edges of a shell look like at equal fractions; NaN where they have no curve or image."""

    brep: Brep

    @cached_property
    def drawn(self) -> Array:
        """(E, q, 3) along the curve of each edge."""
        return _along(self.brep.curves, len(self.brep.ends), 3)

    @cached_property
    def imaged(self) -> Array:
        """(U, q, 2) along the image of each use, in the direction of its edge."""
        return _along(self.brep.images, len(self.brep.edges), 2)

    @cached_property
    def face_of_use(self) -> Indices:
        """(U,)."""
        return self.brep.face_of_use

    @cached_property
    def flat(self) -> Mask:
        """(U,) whether the face of each use is a plane."""
        found = np.zeros(self.brep.face_count, np.bool_)
        for batch in self.brep.surfaces:
            found[batch.rows] = isinstance(batch.of, Planes)
        return found[self.face_of_use]

    @cached_property
    def off_faces(self) -> Array:
        """(U,) greatest distance between the curve of an edge and its face, mm: from the plane, or, on curved
        faces, from where the image says that it lies."""
        off = np.zeros(len(self.brep.edges))
        for batch in self.brep.surfaces:
            place = numbering(self.brep.face_count, batch.rows)[self.face_of_use]
            uses = np.flatnonzero(place >= 0)
            which, drawn = place[uses], self.drawn[self.brep.edges[uses]]
            if isinstance(batch.of, Planes):
                normal, origin = batch.of.normal[which], batch.of.origin[which]
                away = np.abs(np.einsum("mqi,mi->mq", drawn - origin[:, None], normal))
            else:
                away = np.sqrt(((batch.of.at(which, self.imaged[uses]) - drawn) ** 2).sum(axis=2))
            off[uses] = away.max(axis=1, initial=0.0)
        return off

    @cached_property
    def outlines(self) -> tuple[Array, Indices]:
        """Corners (n, 2) of all loops as polygons of their face's parameters, the face to the left of travel,
        and where each loop starts, (L + 1,)."""
        brep = self.brep
        starts = starts_of(np.where(self._straight, 1, PIECES) + self._jumps)
        use = owners(starts)
        step = np.arange(len(use)) - starts[use]
        step = np.where(self._straight[use], PIECES * step, step)
        step = np.where(brep.ahead[use], step, PIECES - step)
        corners = self.imaged[use, step]
        face = self.face_of_use[use]
        for batch in brep.surfaces:
            if isinstance(batch.of, Planes):
                place = numbering(brep.face_count, batch.rows)[face]
                rows = np.flatnonzero(place >= 0)
                points = self.drawn[brep.edges[use[rows]], step[rows]]
                corners[rows] = batch.of.parameters(place[rows], points)
        loops = starts[brep.loops]
        corners += np.repeat(self._shifts(corners, loops), np.diff(loops), axis=0)
        corners[~brep.outward[face], 0] *= -1.0
        return corners, loops

    @cached_property
    def _jumps(self) -> Mask:
        """(U,) whether the next image begins elsewhere than one ends: there the surface closes in a point,
        which is a side of the polygon."""
        brep = self.brep
        begin, end = np.where(
            brep.ahead[:, None, None], self.imaged[:, [0, -1]], self.imaged[:, [-1, 0]]
        ).swapaxes(0, 1)
        return (np.abs(end - begin[brep.following]) > JUMP).any(axis=1)

    def _shifts(self, corners: Array, loops: Indices) -> Array:
        """(L, 2) whole periods of the surface that bring each loop next to the first one of its face."""
        brep = self.brep
        periods = np.zeros((brep.face_count, 2))
        for batch in brep.surfaces:
            periods[batch.rows] = batch.of.periods
        face = brep.face_of_loop
        middle = (np.minimum.reduceat(corners, loops[:-1]) + np.maximum.reduceat(corners, loops[:-1])) / 2
        off = middle[brep.bounds[:-1]][face] - middle
        turns = np.divide(off, periods[face], out=np.zeros_like(off), where=periods[face] > 0)
        return np.round(turns) * periods[face]

    @cached_property
    def _straight(self) -> Mask:
        """(U,) whether a use is a side of its face's polygon, without points between."""
        lines = _are_lines(self.brep.curves, len(self.brep.ends))
        images = _are_lines(self.brep.images, len(self.brep.edges))
        return np.where(self.flat, lines[self.brep.edges], images)


def _along(table: CurveTable, size: int, dimensions: int) -> Array:
    points = np.full((size, PIECES + 1, dimensions), np.nan)
    for batch in table:
        points[batch.rows] = batch.of.at(FRACTIONS)[0]
    return points


def _are_lines(table: CurveTable, size: int) -> Mask:
    found = np.zeros(size, np.bool_)
    for batch in table:
        found[batch.rows] = isinstance(batch.of, Lines)
    return found
