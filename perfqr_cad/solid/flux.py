# pyright: reportAttributeAccessIssue=false
# The modeller's stubs are incomplete.
"""The volume of a solid from its own faces, in time linear in their edges.

3 V = ∮ p · dA. The modeller's rule is quick and good on the small faces of walls; on a spline face with many
holes it is coarse, or takes minutes when asked to adapt. There dA = p_u × p_v du dv, and Green's theorem
turns the integral into ∮ G dv along the face's own outlines, ∂G/∂u = p · (p_u × p_v), G by a fine table.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepGProp import BRepGProp_Domain, BRepGProp_Face, BRepGProp_Vinert
from OCP.BRepTools import BRepTools
from OCP.Geom import Geom_BezierSurface, Geom_BSplineSurface
from OCP.gp import gp_Pnt, gp_Pnt2d, gp_Vec2d
from OCP.TopoDS import TopoDS, TopoDS_Face, TopoDS_Shape
from scipy.interpolate import RectBivariateSpline, make_interp_spline

from .evaluate import FIRST, evaluator
from .expected import gauss
from .occ import EDGE, FACE, FORWARD, REVERSED, VERTEX, WIRE, Array, count, explore

NODES = 8  # of the Gauss rule along an edge, exact to degree 15
PANELS = 32  # across the face: longer edges run over many knots and are integrated in pieces
SIDES = 4  # of a spline patch
BOX_SLACK = 1e-9  # share of its parameters by which an outline may miss a border
BOX_PANELS = 2  # each way across a patch
TABLE = 161  # grid lines of G over the outlines: a quarter of a module, or less


def volume_mm3(shape: TopoDS_Shape) -> float:
    """Volume of a closed solid; negative when it is inside out."""
    faces = [TopoDS.Face_s(face) for face in explore(shape, FACE)]
    origin = BRep_Tool.Pnt_s(TopoDS.Vertex_s(explore(shape, VERTEX)[0]))  # near by: rounding stays small
    return sum(_through(face, origin) for face in faces)


def _through(face: TopoDS_Face, origin: gp_Pnt) -> float:
    """A third of the flux through a face, by what suits it."""
    if isinstance(BRep_Tool.Surface_s(face), Geom_BSplineSurface | Geom_BezierSurface):
        if count(face, WIRE) > 1:
            return _by_outlines(face, origin)
        if _fills_its_box(face):
            return _by_box(face, origin)
    return _by_rule(face, origin)


def _fills_its_box(face: TopoDS_Face) -> bool:
    """Whether a face has no outline but the four borders of its spline, as walls ruled between edges have."""
    edges = [TopoDS.Edge_s(edge) for edge in explore(face, EDGE)]
    if len(edges) != SIDES:
        return False
    u0, u1, v0, v1 = BRep_Tool.Surface_s(face).Bounds()
    slack = BOX_SLACK * np.array([u1 - u0, v1 - v0])
    for edge in edges:
        first, last = BRep_Tool.Range_s(edge, face)
        image = BRep_Tool.CurveOnSurface_s(edge, face, 0.0, 0.0)
        at = np.array([image.Value(t).Coord() for t in np.linspace(first, last, 3)])
        if not any((abs(at - corner) <= slack).all(axis=0).any() for corner in ((u0, v0), (u1, v1))):
            return False
    return True


def _by_box(face: TopoDS_Face, origin: gp_Pnt) -> float:
    """A third of the flux through a whole spline patch: Gauss nodes across its parameters."""
    surface = BRep_Tool.Surface_s(face)
    u0, u1, v0, v1 = surface.Bounds()
    node, weight = _rule(BOX_PANELS)
    uv = np.stack(np.meshgrid(u0 + node * (u1 - u0), v0 + node * (v1 - v0), indexing="ij"), axis=-1)
    point, along_u, along_v = evaluator(surface)(uv.reshape(-1, 2), FIRST)
    density = np.einsum("ki,ki->k", point - np.array(origin.Coord()), np.cross(along_u, along_v))
    flux = float(density @ np.outer(weight, weight).ravel()) * (u1 - u0) * (v1 - v0)
    return (-flux if face.Orientation() == REVERSED else flux) / 3


def _by_rule(face: TopoDS_Face, origin: gp_Pnt) -> float:
    """A third of the flux through a face, by the modeller's Gauss rule."""
    return BRepGProp_Vinert(BRepGProp_Face(face), BRepGProp_Domain(face), origin).Mass()


def _by_outlines(face: TopoDS_Face, origin: gp_Pnt) -> float:
    """The same by Green's theorem in the face's parameters."""
    at, fall = _outlines(TopoDS.Face_s(face.Oriented(FORWARD)))
    swept = _swept(face, np.array(origin.Coord()), at)
    flux = float(np.sum(swept(at) * fall))
    return (-flux if face.Orientation() == REVERSED else flux) / 3


def _outlines(face: TopoDS_Face) -> tuple[Array, Array]:
    """Gauss nodes (k, 2) along all outlines and dv (k,) weighted there, the face to the left of travel."""
    u0, u1, v0, v1 = BRepTools.UVBounds_s(face)
    panel = np.array([u1 - u0, v1 - v0]) / PANELS
    at: list[tuple[float, float]] = []
    fall: list[float] = []
    p, slope = gp_Pnt2d(), gp_Vec2d()
    for found in explore(face, EDGE):
        edge = TopoDS.Edge_s(found)
        first, last = BRep_Tool.Range_s(edge, face)
        image = BRep_Tool.CurveOnSurface_s(edge, face, 0.0, 0.0)
        ahead = (first - last) if edge.Orientation() == REVERSED else (last - first)
        start, end = image.Value(first), image.Value(last)
        steps = np.abs(np.subtract(end.Coord(), start.Coord())) / panel
        node, weight = _rule(max(1, math.ceil(steps.max())))
        for t, share in zip((first + node * (last - first)).tolist(), weight.tolist(), strict=True):
            image.D1(t, p, slope)
            at.append(p.Coord())
            fall.append(slope.Y() * share * ahead)
    return np.array(at), np.array(fall)


@lru_cache(maxsize=64)
def _rule(panels: int) -> tuple[Array, Array]:
    return gauss(NODES, panels)


def _swept(face: TopoDS_Face, origin: Array, over: Array) -> Callable[[Array], Array]:
    """G(u, v) on the box of some parameters. Its lower limit is free: over closed loops ∮ c(v) dv = 0."""
    surface = evaluator(BRep_Tool.Surface_s(face))
    low, high = over.min(axis=0), over.max(axis=0)
    u, v = np.linspace(low[0], high[0], TABLE), np.linspace(low[1], high[1], TABLE)
    grid = np.stack(np.meshgrid(u, v, indexing="ij"), axis=-1).reshape(-1, 2)
    point, along_u, along_v = surface(grid, FIRST)
    density = np.einsum("ki,ki->k", point - origin, np.cross(along_u, along_v)).reshape(TABLE, TABLE)
    table = RectBivariateSpline(u, v, make_interp_spline(u, density, axis=0).antiderivative()(u), s=0)
    return lambda at: np.asarray(table.ev(at[:, 0], at[:, 1]), np.float64)
