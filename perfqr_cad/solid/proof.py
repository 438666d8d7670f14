# pyright: reportAttributeAccessIssue=false
# The modeller's stubs are incomplete.
"""Proof that a solid is valid, in time linear in its edges (to a logarithm).

`BRepCheck` compares the edges of a face pair by pair, which is quadratic on a perforated face, and passes
solids
that touch themselves. Here the shell is shown to be a closed, oriented 2-manifold with geometry to match:

1. one solid of one shell; every wire runs head to tail;
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

import numpy as np
import shapely
from OCP.TopoDS import TopoDS_Shape
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from . import occ
from .occ import SHELL, SOLID, Array
from .survey import Shell, at, survey

VERTEX_MM = 1e-6  # vertices of a part of whole millimetres that are this close are one


def check(
    shape: TopoDS_Shape,
    *,
    genus: int | None = None,
    expected_volume_mm3: float | None = None,
    volume_tol: float = 1e-9,
    volume_mm3: float | None = None,
) -> tuple[str, ...]:
    """What is wrong with a solid, one line each; empty when nothing is.

    genus                number of through-holes, where it is known
    expected_volume_mm3  from the outline, and the share of it by which the modeller's volume may differ
    volume_mm3           the modeller's, where it was taken already
    """
    counts = [occ.count(shape, kind) for kind in (SOLID, SHELL)]
    if counts != [1, 1]:
        return (f"{counts[0]} solids of {counts[1]} shells, not one of one",)
    shell = survey(shape)
    found = [*shell.problems, *_closed(shell), *_manifold(shell), *_apart(shell), *_loops(shell)]
    if not found:
        found += _euler(shell, genus)
    volume = occ.volume(shape) if volume_mm3 is None else volume_mm3
    if volume <= 0:
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


def _closed(shell: Shell) -> list[str]:
    """Every edge twice, once in each direction."""
    index, ahead = (np.array(x) for x in zip(*shell.uses, strict=True))
    size = max(shell.ends) + 1
    on, back = (np.bincount(index[ahead == way], minlength=size) for way in (True, False))
    used = np.array(sorted(shell.ends))
    wrong = np.flatnonzero((on[used] != 1) | (back[used] != 1))
    return [f"{len(wrong)} edges are not shared by two faces in opposite directions"] if len(wrong) else []


def _manifold(shell: Shell) -> list[str]:
    """The corners of faces around a vertex link its edges into one ring."""
    nodes = np.array([2 * i + end for i in shell.ends for end in (0, 1)])
    of_vertex = np.array([v for ends in shell.ends.values() for v in ends])
    order = np.full(int(nodes.max()) + 1, -1)
    order[nodes] = np.arange(len(nodes))
    links = order[np.array(shell.corners)]
    graph = coo_array((np.ones(len(links)), (links[:, 0], links[:, 1])), shape=(len(nodes), len(nodes)))
    _, fan = connected_components(graph, directed=False)
    fans = np.unique(np.column_stack([of_vertex, fan]), axis=0)
    doubled = np.flatnonzero(np.bincount(fans[:, 0]) > 1)
    return [f"the solid touches itself at the vertex {at(shell.points[v])}" for v in doubled]


def _apart(shell: Shell) -> list[str]:
    """No two vertices in one place."""
    pairs = cKDTree(shell.points).query_pairs(VERTEX_MM)
    return [f"two vertices coincide at {at(shell.points[a])}" for a, _ in sorted(pairs)]


def _loops(shell: Shell) -> list[str]:
    """Outlines are simple, apart, nested, and run with the face on their left."""
    outer: list[Array] = []
    inner: list[list[Array]] = []
    found: list[str] = []
    for outlines in shell.polygons:
        sizes = [_area(o) for o in outlines]
        if not outlines or any(len(o) < 3 for o in outlines):
            found.append("a face has no outline")
            continue
        first = int(np.argmax(np.abs(sizes)))
        if sizes[first] < 0 or any(size > 0 for k, size in enumerate(sizes) if k != first):
            found.append("a loop of a face runs the wrong way round")
        outer.append(outlines[first])
        inner.append([o for k, o in enumerate(outlines) if k != first])
    polygons = np.array([shapely.Polygon(o, i) for o, i in zip(outer, inner, strict=True)])
    for row in np.flatnonzero(~shapely.is_valid(polygons)):
        found.append(f"the loops of a face cross or touch: {shapely.is_valid_reason(polygons[row])}")
    return found


def _euler(shell: Shell, genus: int | None) -> list[str]:
    """Euler and Poincaré's formula for faces with inner loops; not applied where poles degenerate edges."""
    if shell.degenerate:
        return []
    inner = sum(len(outlines) - 1 for outlines in shell.polygons)
    euler = len(shell.points) - len(shell.ends) + len(shell.polygons) - inner
    if euler % 2 or euler > 2:
        return [f"Euler characteristic {euler} is that of no closed solid"]
    holes = (2 - euler) // 2
    return [] if genus is None or holes == genus else [f"{holes} through-holes, not {genus}"]


def _area(polygon: Array) -> float:
    x, y = polygon.T
    return float(x[:-1] @ y[1:] - y[:-1] @ x[1:] + x[-1] * y[0] - y[-1] * x[0]) / 2
