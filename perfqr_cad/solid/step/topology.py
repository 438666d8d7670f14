"""Boundary representations as STEP solids (ISO 10303-42), in time linear in their edges.

The kernel's own writer runs its shape-healing tools on every face first (`ShapeFix_SplitCommonVertex` looks
at all pairs of wires), which is quadratic in the wires of a perforated face. A solid that was checked needs
none.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from perfqr_cad.solid.step.geometry import Geometry
from perfqr_cad.solid.step.text import Part21, refs, text
from perfqr_cad.solid.tables.brep import Brep

FLAGS = (".F.", ".T.")


class Topology:
    """Writes solids into a file; an edge or vertex that several faces share is written once."""

    def __init__(self, part: Part21) -> None:
        self._add, self._add_all = part.add, part.add_all
        self._geometry = Geometry(part)

    def solid(self, brep: Brep, name: str) -> int:
        """The number of the solid's MANIFOLD_SOLID_BREP or, with cavities, BREP_WITH_VOIDS."""
        faces = self._faces(brep, self._loops(brep, self._edges(brep)))
        starts = pairwise(brep.shells.tolist())
        outer, *voids = [self._add(f"CLOSED_SHELL('',{refs(faces[a:b])})") for a, b in starts]
        if not voids:
            return self._add(f"MANIFOLD_SOLID_BREP({text(name)},#{outer})")
        cavities = refs([self._add(f"ORIENTED_CLOSED_SHELL('',*,#{v},.T.)") for v in voids])
        return self._add(f"BREP_WITH_VOIDS({text(name)},#{outer},{cavities})")

    def _edges(self, brep: Brep) -> range:
        """Edge curves; those without extent (poles) are not in the tables, as in STEP."""
        points = self._geometry.points(brep.points)
        vertices = self._add_all(f"VERTEX_POINT('',#{p})" for p in points)
        curves = np.empty(len(brep.ends), np.int64)
        for batch in brep.curves:
            curves[batch.rows] = list(self._geometry.curves(batch.of))
        first, ends = vertices.start, brep.ends.tolist()
        return self._add_all(
            f"EDGE_CURVE('',#{first + a},#{first + b},#{curve},.T.)"
            for (a, b), curve in zip(ends, curves.tolist(), strict=True)
        )

    def _loops(self, brep: Brep, edges: range) -> range:
        oriented = self._add_all(
            f"ORIENTED_EDGE('',*,*,#{edges[edge]},{FLAGS[ahead]})"
            for edge, ahead in zip(brep.edges.tolist(), brep.ahead.tolist(), strict=True)
        )
        return self._add_all(f"EDGE_LOOP('',{refs(oriented[a:b])})" for a, b in pairwise(brep.loops.tolist()))

    def _faces(self, brep: Brep, loops: range) -> range:
        """Faces, whose first loop is their outer one; loops run as one sees them from outside."""
        inner = np.ones(len(loops), np.int64)
        inner[brep.bounds[:-1]] = 0
        kinds = ("FACE_OUTER_BOUND", "FACE_BOUND")
        bounds = self._add_all(
            f"{kinds[kind]}('',#{loop},.T.)" for kind, loop in zip(inner.tolist(), loops, strict=True)
        )
        surfaces, senses = np.empty(brep.face_count, np.int64), brep.outward.copy()
        for batch in brep.surfaces:
            numbers, mirrored = self._geometry.surfaces(batch.of)
            surfaces[batch.rows] = list(numbers)
            senses[batch.rows] ^= mirrored
        sides = zip(pairwise(brep.bounds.tolist()), surfaces.tolist(), senses.tolist(), strict=True)
        return self._add_all(
            f"ADVANCED_FACE('',{refs(bounds[a:b])},#{surface},{FLAGS[sense]})"
            for (a, b), surface, sense in sides
        )
