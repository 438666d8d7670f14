"""Which nodes of a mesh a support holds."""

from __future__ import annotations

import numpy as np
import shapely
from shapely.geometry import Polygon

from perfqr_cad.errors import AnalysisError
from perfqr_cad.structure.elements import mindlin_plate as plate
from perfqr_cad.structure.elements import mindlin_shell as shell
from perfqr_cad.structure.elements.assembly import Flags
from perfqr_cad.structure.loads import CORNER_PAD_FRACTION, Hold, Support
from perfqr_cad.structure.mesh.triangle import Floats, Ints, Mesh

LEAST_SIDE_SHARE = 0.1  # of its height: a part held along less of a side is held at points
ON_HULL_FRACTION = 2e-3  # of the part's size: an outline this close to the convex hull lies on it


def held_nodes(mesh: Mesh, polygon: Polygon, support: Support) -> Flags:
    """Flags (n,) of the nodes that are held.

    The held boundary is where the outline lies on its own convex hull: the outer edge of the quiet zone, also
    of a rounded or round tag, but not the notches that dark modules cut into a frame without quiet zone.

    Raises:
        AnalysisError: the support touches no material.
    """
    if support.hold is Hold.CORNERS:
        return _in_corner_pads(mesh, polygon, support)
    edges = _edges_on_hull(mesh, polygon)
    if support.hold is Hold.TWO_SIDES:
        edges = _edges_on_sides(mesh, polygon, edges)
    held = np.zeros(len(mesh.nodes), bool)
    held[edges] = True
    return held


def pins(positions: Floats, flat: bool) -> Flags:
    """Flags (n, d) that hold a free part against rigid motion and nothing else.

    Three nodes far apart: of a flat plate their deflections; of a shell three directions of the first, two of
    the second, one of the third. Loads that balance by themselves leave no force in them.
    """
    first = int(np.argmin(positions @ np.array([1.0, 1.0, 0.0])))
    second = int(np.argmax(np.linalg.norm(positions - positions[first], axis=1)))
    along = positions[second] - positions[first]
    off = np.linalg.norm(np.cross(positions - positions[first], along), axis=1)
    third = int(np.argmax(off))
    if flat:
        held = np.zeros((len(positions), plate.DOFS), bool)
        held[[first, second, third], plate.W] = True
        return held
    held = np.zeros((len(positions), shell.DOFS), bool)
    held[first, :3] = True
    # The direction along the line that joins the first two is held already; the last turns about that line.
    held[second, np.delete(np.arange(3), np.argmax(np.abs(along)))] = True
    held[third, np.argmax(np.abs(np.cross(along, positions[third] - positions[first])))] = True
    return held


def _edges_on_hull(mesh: Mesh, polygon: Polygon) -> Ints:
    hull = shapely.boundary(shapely.convex_hull(polygon))
    near = ON_HULL_FRACTION * _span(polygon)
    distance = np.asarray(shapely.distance(shapely.points(mesh.nodes[mesh.boundary]), hull))
    return mesh.boundary[(distance < near).all(axis=1)]


def _edges_on_sides(mesh: Mesh, polygon: Polygon, edges: Ints) -> Ints:
    left, bottom, right, top = polygon.bounds
    near = ON_HULL_FRACTION * _span(polygon)
    ends = mesh.nodes[edges[:, :2]]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    least = LEAST_SIDE_SHARE * (top - bottom)
    held_edges = np.zeros(len(edges), bool)
    for name, where in (("left", left), ("right", right)):
        on_side = (np.abs(ends[..., 0] - where) < near).all(axis=1)
        held_edges |= on_side
        held = float(length[on_side].sum())
        if held < least:
            raise AnalysisError(
                f"the part touches its {name} support (x = {where:.2f} mm) along {held:.2f} mm"
                f" (least {least:.2f} mm): square its sides or clamp it all round"
            )
    return edges[held_edges]


def _in_corner_pads(mesh: Mesh, polygon: Polygon, support: Support) -> Flags:
    left, bottom, right, top = polygon.bounds
    pad = support.pad_mm or CORNER_PAD_FRACTION * min(right - left, top - bottom)
    x, y = mesh.nodes.T
    held = np.zeros(len(mesh.nodes), bool)
    for in_x, cx in ((x <= left + pad, left), (x >= right - pad, right)):
        for in_y, cy in ((y <= bottom + pad, bottom), (y >= top - pad, top)):
            inside = in_x & in_y
            if not inside.any():
                raise AnalysisError(
                    f"no material on the {pad:.2f} mm corner pad at ({cx:.1f}, {cy:.1f}) mm:"
                    " make the pads larger or choose another support"
                )
            held |= inside
    return held


def _span(polygon: Polygon) -> float:
    left, bottom, right, top = polygon.bounds
    return max(right - left, top - bottom)
