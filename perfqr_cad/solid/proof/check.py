"""Proof that a solid is valid, in time linear in its edges (to a logarithm).

`BRepCheck` compares the edges of a face pair by pair, which is quadratic on a perforated face, and passes
solids that touch themselves. Here the shell is shown to be a closed, oriented 2-manifold with geometry to
match:

1. one shell, of one piece; every loop runs head to tail;
2. every edge is used twice, in opposite directions: the shell is closed and oriented;
3. the faces around every vertex form one fan, and no two vertices coincide: nothing touches at a point;
4. every edge runs from vertex to vertex, and lies on both its faces, within its tolerance;
5. the loops of every face are simple, disjoint and rightly nested, as polygons of the face's parameters;
6. V − E + F − inner loops = 2 − 2 · genus, the genus being the number of through-holes where it is known;
7. the volume is positive and, where it is known, as computed from the outline alone.

Faces are not intersected with one another: walls are ruled between loops that step 5 shows to be disjoint at
both their ends, and widen monotonically between.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import shapely
from scipy.spatial import cKDTree

from perfqr_cad.geometry.arrays import Array, Indices
from perfqr_cad.geometry.cycles import following, owners
from perfqr_cad.geometry.graph import components
from perfqr_cad.solid.proof import flux
from perfqr_cad.solid.tables.brep import Brep
from perfqr_cad.solid.tables.edge_points import EdgePoints

VERTEX_MM = 1e-6  # vertices of a part of whole millimetres that are this close are one
SLACK = 1.5  # between points sampled here and the tolerance that an edge was given from other points


def check(
    brep: Brep,
    *,
    genus: int | None = None,
    expected_volume_mm3: float | None = None,
    volume_tol: float = 1e-9,
    volume_mm3: float | None = None,
) -> tuple[str, ...]:
    """What is wrong with a solid, one line each; empty when nothing is.

    genus                number of through-holes, where it is known
    expected_volume_mm3  from the outline, and the share of it by which the measured volume may differ
    volume_mm3           as measured on the faces, where that was done already
    """
    samples = EdgePoints(brep)
    if missing := _missing(samples):
        return missing
    found = [*_whole(brep), *_chained(brep), *_closed(brep), *_manifold(brep), *_apart(brep)]
    found += [*_on_vertices(samples), *_on_faces(samples), *_loops(samples)]
    if not found:
        found += _euler(brep, genus)
    volume = flux.volume_mm3(brep) if volume_mm3 is None else volume_mm3
    if not volume > 0:
        found.append(f"volume {volume:.6g} mm³: the shell is inside out")
    elif (
        expected_volume_mm3 is not None
        and abs(volume - expected_volume_mm3) > volume_tol * expected_volume_mm3
    ):
        found.append(
            f"volume {volume:.9g} mm³, from the outline {expected_volume_mm3:.9g} mm³ "
            f"(limit {volume_tol:g} of it)"
        )
    return tuple(found)


def _missing(samples: EdgePoints) -> tuple[str, ...]:
    """What there is nothing to look at without."""
    brep = samples.brep
    flaws = {
        f"{len(brep.shells) - 1} shells, not one": np.array(len(brep.shells) != 2),
        "an edge has no vertex at an end": brep.ends < 0,
        "an edge has no curve": np.isnan(samples.drawn),
        "an edge has no image on its curved face": np.isnan(samples.imaged[~samples.flat]),
        "a face has no outline": np.diff(brep.bounds) == 0,
        "a loop has no edges": np.diff(brep.loops) == 0,
    }
    return tuple(flaw for flaw, where in flaws.items() if where.any())


def _whole(brep: Brep) -> list[str]:
    """All faces hang together by their edges."""
    size = brep.face_count + len(brep.ends)
    links = np.column_stack([brep.face_of_use, brep.face_count + brep.edges])
    count = components(links, size).max() + 1
    return [f"the shell is in {count} pieces"] if count > 1 else []


def _chained(brep: Brep) -> list[str]:
    """Loops run head to tail."""
    broken = np.flatnonzero(brep.heads != brep.tails[brep.following])
    return [f"a loop is broken at {at(brep.points[v])}" for v in brep.heads[broken]]


def _closed(brep: Brep) -> list[str]:
    """Every edge twice, once in each direction."""
    on, back = (np.bincount(brep.edges[brep.ahead == way], minlength=len(brep.ends)) for way in (True, False))
    wrong = np.count_nonzero((on != 1) | (back != 1))
    return [f"{wrong} edges are not shared by two faces in opposite directions"] if wrong else []


def _manifold(brep: Brep) -> list[str]:
    """The corners of faces around a vertex link the ends of its edges into one ring."""
    heads = 2 * brep.edges + brep.ahead
    tails = (2 * brep.edges + ~brep.ahead)[brep.following]
    size = 2 * len(brep.ends)
    fan = components(np.column_stack([heads, tails]), size)
    pairs = np.sort(brep.ends.ravel() * size + fan)
    fans = np.bincount(pairs[np.diff(pairs, prepend=-1) > 0] // size)
    doubled = np.flatnonzero(fans > 1)
    return [f"the solid touches itself at the vertex {at(brep.points[v])}" for v in doubled]


def _apart(brep: Brep) -> list[str]:
    """No two vertices in one place."""
    pairs = cKDTree(brep.points).query_pairs(VERTEX_MM)
    return [f"two vertices coincide at {at(brep.points[a])}" for a, _ in sorted(pairs)]


def _on_vertices(samples: EdgePoints) -> list[str]:
    """Every edge has an extent, and runs from vertex to vertex."""
    brep, drawn = samples.brep, samples.drawn
    extent = np.abs(drawn[:, 1:] - drawn[:, :1]).max(axis=(1, 2), initial=0.0)
    found = [f"an edge has no extent at {at(p)}" for p in drawn[extent == 0, 0]]
    for place, end in ((0, 0), (-1, 1)):
        there = brep.points[brep.ends[:, end]]
        missed = np.sqrt(((drawn[:, place] - there) ** 2).sum(axis=1))
        found += [
            f"an edge misses its vertex by {missed[edge]:.2g} mm at {at(there[edge])}"
            for edge in np.flatnonzero(missed > SLACK * brep.tolerance_mm)
        ]
    return found


def _on_faces(samples: EdgePoints) -> list[str]:
    """Every edge lies on its faces."""
    brep, off = samples.brep, samples.off_faces
    limit = brep.tolerance_mm[brep.edges]
    return [
        f"an edge at {at(brep.points[brep.tails[use]])} is {off[use]:.2g} mm off its face "
        f"(limit {limit[use]:.2g} mm)"
        for use in np.flatnonzero(off > SLACK * limit)
    ]


def _loops(samples: EdgePoints) -> list[str]:
    """Outlines are simple, apart, nested, and run with the face on their left."""
    corners, starts = samples.outlines
    if (np.diff(starts) < 3).any():
        return ["a loop has no area"]
    face = samples.brep.face_of_loop
    sizes = _areas(corners, starts)
    rightly = np.full(len(face), -1.0)
    rightly[samples.brep.bounds[:-1]] = 1.0
    wrong = np.count_nonzero(sizes * rightly <= 0)
    found = [f"{wrong} loops of faces run the wrong way round"] if wrong else []
    rings = np.asarray(shapely.linearrings(corners, indices=owners(starts)))
    polygons = np.asarray(shapely.polygons(rings, indices=face))
    return found + [
        f"the loops of a face cross or touch: {shapely.is_valid_reason(polygon)}"
        for polygon in polygons[~shapely.is_valid(polygons)]
    ]


def _areas(corners: Array, starts: Indices) -> Array:
    """Signed areas (L,) of polygons."""
    (x, y), (x1, y1) = corners.T, corners[following(starts)].T
    return np.add.reduceat(x * y1 - x1 * y, starts[:-1]) / 2


def _euler(brep: Brep, genus: int | None) -> list[str]:
    """Euler and Poincaré's formula for faces with inner loops."""
    inner = len(brep.face_of_loop) - brep.face_count
    euler = len(brep.points) - len(brep.ends) + brep.face_count - inner
    if euler % 2 or euler > 2:
        return [f"Euler characteristic {euler} is that of no closed solid"]
    holes = (2 - euler) // 2
    return [] if genus is None or holes == genus else [f"{holes} through-holes, not {genus}"]


def at(p: Iterable[float]) -> str:
    """A point for people."""
    return "({:.3f}, {:.3f}, {:.3f})".format(*p)
