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

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
import shapely
from OCP.BRep import BRep_Tool
from OCP.Geom import Geom_Line, Geom_Plane
from OCP.gp import gp_Pnt
from OCP.TopExp import TopExp
from OCP.TopoDS import TopoDS, TopoDS_Edge, TopoDS_Face, TopoDS_Shape
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from . import occ
from .occ import EDGE, FACE, FORWARD, REVERSED, SHELL, SOLID, VERTEX, WIRE, Array
from .step_topology import children, in_order

SAMPLES = 8  # points of a curved edge in the polygon of its face, and of the check that it lies on the face
SLACK = 1.5  # between points sampled here and the tolerance that an edge was given from other points
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
    shell = _survey(shape)
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


@dataclass
class _Shell:
    """What one walk over the faces collects; edges and vertices by their index."""

    points: Array  # vertices, mm
    rows: list[tuple[float, float, float]]  # the same
    ends: dict[int, tuple[int, int]] = field(default_factory=dict[int, tuple[int, int]])
    uses: list[tuple[int, bool]] = field(default_factory=list[tuple[int, bool]])  # edge, ahead
    corners: list[tuple[int, int]] = field(
        default_factory=list[tuple[int, int]]
    )  # edge ends that meet in a face
    polygons: list[list[Array]] = field(
        default_factory=list[list[Array]]
    )  # of each face, outlines in parameters
    problems: list[str] = field(default_factory=list[str])
    degenerate: bool = False


def _survey(shape: TopoDS_Shape) -> _Shell:
    vertices, edges = occ.distinct(shape, VERTEX), occ.distinct(shape, EDGE)
    points = [
        BRep_Tool.Pnt_s(TopoDS.Vertex_s(vertices.FindKey(i))).Coord() for i in range(1, vertices.Extent() + 1)
    ]
    shell = _Shell(np.array(points).reshape(-1, 3), points)
    straight: dict[int, bool] = {}
    for i in range(1, edges.Extent() + 1):
        edge = TopoDS.Edge_s(edges.FindKey(i).Oriented(FORWARD))
        if BRep_Tool.Degenerated_s(edge):
            shell.degenerate = True
            continue
        first, last = TopExp.FirstVertex_s(edge), TopExp.LastVertex_s(edge)
        if first.IsNull() or last.IsNull():
            shell.problems.append("an edge has no vertex at an end")
            continue
        shell.ends[i] = vertices.FindIndex(first) - 1, vertices.FindIndex(last) - 1
        straight[i] = _meets_vertices(shell, edge, i)
    for face in occ.explore(shape, FACE):
        _walk(shell, TopoDS.Face_s(face), edges, straight)
    return shell


def _meets_vertices(shell: _Shell, edge: TopoDS_Edge, index: int) -> bool:
    """Whether the edge is straight; notes where its curve misses its vertices."""
    curve = BRep_Tool.Curve_s(edge, 0.0, 0.0)
    if curve is None:
        shell.problems.append("an edge has no curve")
        return True
    parameters = BRep_Tool.Range_s(edge)
    if not parameters[0] < parameters[1]:
        shell.problems.append("an edge has an empty range")
    for vertex, parameter in zip(shell.ends[index], parameters, strict=True):
        missed = curve.Value(parameter).Distance(gp_Pnt(*shell.rows[vertex]))
        if missed > SLACK * BRep_Tool.Tolerance_s(edge):
            shell.problems.append(
                f"an edge misses its vertex by {missed:.2g} mm at {_at(shell.points[vertex])}"
            )
    return isinstance(curve, Geom_Line)


def _walk(
    shell: _Shell, face: TopoDS_Face, edges: occ.TopTools_IndexedMapOfShape, straight: dict[int, bool]
) -> None:
    """One face: the uses of its edges, its corners, its outlines, and whether its edges lie on it."""
    forward = TopoDS.Face_s(face.Oriented(FORWARD))
    surface = BRep_Tool.Surface_s(forward)
    plane = surface if isinstance(surface, Geom_Plane) else None
    flipped = face.Orientation() == REVERSED
    outlines: list[Array] = []
    for wire in children(forward):
        if wire.ShapeType() != WIRE:
            continue
        steps = [_Step(edges.FindIndex(e), e.Orientation() != REVERSED, e) for e in in_order(wire, forward)]
        steps = [step for step in steps if step.index in shell.ends]
        for step, following in zip(steps, steps[1:] + steps[:1], strict=True):
            shell.uses.append((step.index, step.ahead != flipped))
            shell.corners.append((2 * step.index + step.ahead, 2 * following.index + (not following.ahead)))
            here = shell.ends[step.index][step.ahead]
            if here != shell.ends[following.index][not following.ahead]:
                shell.problems.append(f"a wire is broken at {_at(shell.points[here])}")
        if plane is not None:
            outlines.append(_plane_outline(shell, steps, plane, straight, forward))
        else:
            outlines.append(_curved_outline(shell, steps, forward))
    shell.polygons.append(outlines)


@dataclass(frozen=True, slots=True)
class _Step:
    """An edge of a wire, by its index, and whether the wire runs along it or against it."""

    index: int
    ahead: bool
    edge: TopoDS_Edge


def _plane_outline(
    shell: _Shell, steps: list[_Step], plane: Geom_Plane, straight: dict[int, bool], face: TopoDS_Face
) -> Array:
    """The wire in the plane's coordinates; notes where it leaves the plane."""
    samples: list[tuple[float, ...]] = []
    slack = BRep_Tool.Tolerance_s(face)
    for step in steps:
        if straight[step.index]:
            samples.append(shell.rows[shell.ends[step.index][not step.ahead]])
        else:
            curve = BRep_Tool.Curve_s(step.edge, 0.0, 0.0)
            samples += [curve.Value(t).Coord() for t in _parameters(step)]
            slack = max(slack, BRep_Tool.Tolerance_s(step.edge))
    frame = plane.Position()
    axes = np.array([d.Coord() for d in (frame.XDirection(), frame.YDirection(), frame.Direction())])
    local = (np.array(samples).reshape(-1, 3) - frame.Location().Coord()) @ axes.T
    off = float(np.abs(local[:, 2]).max(initial=0.0))
    if off > SLACK * slack:
        shell.problems.append(
            f"an edge at {_at(samples[0])} is {off:.2g} mm off its plane (limit {slack:.2g} mm)"
        )
    return local[:, :2]


def _curved_outline(shell: _Shell, steps: list[_Step], face: TopoDS_Face) -> Array:
    """The wire in the surface's parameters; notes where curve and image are apart."""
    outline: list[tuple[float, float]] = []
    surface, slack = BRep_Tool.Surface_s(face), BRep_Tool.Tolerance_s(face)
    for step in steps:
        image = BRep_Tool.CurveOnSurface_s(step.edge, face, 0.0, 0.0)
        if image is None:
            shell.problems.append("an edge has no image on its curved face")
            continue
        curve = BRep_Tool.Curve_s(step.edge, 0.0, 0.0)
        limit = SLACK * max(slack, BRep_Tool.Tolerance_s(step.edge))
        for t in _parameters(step):
            drawn = image.Value(t)
            outline.append(drawn.Coord())
            off = surface.Value(drawn.X(), drawn.Y()).Distance(curve.Value(t))
            if off > limit:
                at = _at(curve.Value(t).Coord())
                shell.problems.append(f"an edge at {at} is {off:.2g} mm off its face (limit {limit:.2g} mm)")
                break
    return np.array(outline).reshape(-1, 2)


def _parameters(step: _Step) -> list[float]:
    """Samples of an edge in the direction of travel, without the last, which the next edge begins with."""
    first, last = BRep_Tool.Range_s(step.edge)
    start, end = (first, last) if step.ahead else (last, first)
    return [start + (end - start) * k / SAMPLES for k in range(SAMPLES)]


def _closed(shell: _Shell) -> list[str]:
    """Every edge twice, once in each direction."""
    index, ahead = (np.array(x) for x in zip(*shell.uses, strict=True))
    size = max(shell.ends) + 1
    on, back = (np.bincount(index[ahead == way], minlength=size) for way in (True, False))
    used = np.array(sorted(shell.ends))
    wrong = np.flatnonzero((on[used] != 1) | (back[used] != 1))
    return [f"{len(wrong)} edges are not shared by two faces in opposite directions"] if len(wrong) else []


def _manifold(shell: _Shell) -> list[str]:
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
    return [f"the solid touches itself at the vertex {_at(shell.points[v])}" for v in doubled]


def _apart(shell: _Shell) -> list[str]:
    """No two vertices in one place."""
    pairs = cKDTree(shell.points).query_pairs(VERTEX_MM)
    return [f"two vertices coincide at {_at(shell.points[a])}" for a, _ in sorted(pairs)]


def _loops(shell: _Shell) -> list[str]:
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


def _euler(shell: _Shell, genus: int | None) -> list[str]:
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


def _at(p: Iterable[float]) -> str:
    return "({:.3f}, {:.3f}, {:.3f})".format(*p)
