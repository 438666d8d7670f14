"""Small, typed helpers over OCP: points, splines, measures. The kernel's exceptions are translated here."""

from __future__ import annotations

from collections import Counter
from collections.abc import Generator
from contextlib import contextmanager
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from OCP.BRepGProp import BRepGProp
from OCP.Geom import Geom_BSplineCurve, Geom_BSplineSurface
from OCP.Geom2d import Geom2d_BSplineCurve, Geom2d_Line
from OCP.gp import gp_Dir, gp_Dir2d, gp_Pnt, gp_Pnt2d
from OCP.GProp import GProp_GProps
from OCP.Message import Message, Message_Gravity
from OCP.TColgp import TColgp_Array1OfPnt, TColgp_Array1OfPnt2d, TColgp_Array2OfPnt
from OCP.TColStd import TColStd_Array1OfInteger, TColStd_Array1OfReal, TColStd_Array2OfReal
from OCP.TopAbs import TopAbs_Orientation, TopAbs_ShapeEnum
from OCP.TopExp import TopExp, TopExp_Explorer
from OCP.TopoDS import TopoDS_Shape
from OCP.TopTools import TopTools_IndexedMapOfShape

from perfqr_cad.errors import KernelError
from perfqr_cad.geometry.arrays import Array
from perfqr_cad.remedy import Remedy

FACE = TopAbs_ShapeEnum.TopAbs_FACE
EDGE = TopAbs_ShapeEnum.TopAbs_EDGE
VERTEX = TopAbs_ShapeEnum.TopAbs_VERTEX
WIRE = TopAbs_ShapeEnum.TopAbs_WIRE
SHELL = TopAbs_ShapeEnum.TopAbs_SHELL
SOLID = TopAbs_ShapeEnum.TopAbs_SOLID
FORWARD = TopAbs_Orientation.TopAbs_FORWARD
REVERSED = TopAbs_Orientation.TopAbs_REVERSED


@contextmanager
def kernel(doing: str, remedy: str | Remedy) -> Generator[None, None, None]:
    """Translate the kernel's exceptions into one-line `KernelError`s."""
    try:
        yield
    except Exception as error:
        if not type(error).__module__.startswith("OCP."):  # their classes have no base of their own
            raise
        reason = " ".join(str(error).split()) or type(error).__name__
        told = f"{doing} failed in the solid modeller ({reason})"
        if isinstance(remedy, Remedy):
            raise KernelError(told, remedy) from error
        raise KernelError(f"{told}: {remedy}") from error


def silence() -> None:
    """Keep the kernel's progress talk off standard output; failures still come as exceptions."""
    for printer in Message.DefaultMessenger_s().Printers():
        printer.SetTraceLevel(Message_Gravity.Message_Fail)


def pnt(p: ArrayLike) -> gp_Pnt:
    x, y, z = np.asarray(p, dtype=np.float64).tolist()
    return gp_Pnt(x, y, z)


def direction(p: ArrayLike) -> gp_Dir:
    x, y, z = np.asarray(p, dtype=np.float64).tolist()
    return gp_Dir(x, y, z)


def line_2d(u: float, v: float, du: float, dv: float) -> Geom2d_Line:
    return Geom2d_Line(gp_Pnt2d(u, v), gp_Dir2d(du, dv))


def spline_curve(poles: Array, knots: ArrayLike, degree: int) -> Geom_BSplineCurve:
    """B-spline curve from (k, 3) poles and a flat knot vector."""
    return Geom_BSplineCurve(_points(poles), *_knots(knots), degree)


def spline_curve_2d(poles: Array, knots: ArrayLike, degree: int) -> Geom2d_BSplineCurve:
    """B-spline curve in parameter space from (k, 2) poles and a flat knot vector."""
    array = TColgp_Array1OfPnt2d(1, len(poles))
    for i, (u, v) in enumerate(poles.tolist(), 1):
        array.SetValue(i, gp_Pnt2d(u, v))
    return Geom2d_BSplineCurve(array, *_knots(knots), degree)


def spline_surface(
    poles: Array,
    u_knots: ArrayLike,
    v_knots: ArrayLike,
    degrees: tuple[int, int],
    weights: Array | None = None,
) -> Geom_BSplineSurface:
    """B-spline surface from (k, m, 3) poles, flat knot vectors and, when rational, (k, m) weights."""
    rows, columns, _ = poles.shape
    array = TColgp_Array2OfPnt(1, rows, 1, columns)
    for i, row in enumerate(poles.tolist(), 1):
        for j, (x, y, z) in enumerate(row, 1):
            array.SetValue(i, j, gp_Pnt(x, y, z))
    (u, u_mults), (v, v_mults) = _knots(u_knots), _knots(v_knots)
    if weights is None:
        return Geom_BSplineSurface(array, u, v, u_mults, v_mults, *degrees)
    weighting = TColStd_Array2OfReal(1, rows, 1, columns)
    for i, row in enumerate(weights.tolist(), 1):
        for j, weight in enumerate(row, 1):
            weighting.SetValue(i, j, weight)
    return Geom_BSplineSurface(array, weighting, u, v, u_mults, v_mults, *degrees)


def volume(shape: TopoDS_Shape, accuracy: float | None = None) -> float:
    """Volume in mm³ by the kernel's surface integrals; negative when inside out.

    The kernel's fixed rule is exact on elementary faces; with `accuracy`, a share of each face's part, it
    integrates adaptively, which perforated spline faces need.
    """
    properties = GProp_GProps()
    if accuracy is None:
        BRepGProp.VolumeProperties_s(shape, properties)
    else:
        BRepGProp.VolumeProperties_s(shape, properties, accuracy, False, False)
    return properties.Mass()


def explore(shape: TopoDS_Shape, kind: TopAbs_ShapeEnum) -> list[Any]:
    """Every use of a kind of sub-shape, oriented; an edge between two faces comes twice."""
    explorer = TopExp_Explorer(shape, kind)
    found: list[Any] = []
    while explorer.More():
        found.append(explorer.Current())
        explorer.Next()
    return found


def distinct(shape: TopoDS_Shape, kind: TopAbs_ShapeEnum) -> TopTools_IndexedMapOfShape:
    """Each sub-shape of a kind once."""
    found = TopTools_IndexedMapOfShape()
    TopExp.MapShapes_s(shape, kind, found)
    return found


def count(shape: TopoDS_Shape, kind: TopAbs_ShapeEnum) -> int:
    """How many distinct sub-shapes of a kind there are."""
    return distinct(shape, kind).Extent()


def _points(poles: Array) -> TColgp_Array1OfPnt:
    array = TColgp_Array1OfPnt(1, len(poles))
    for i, (x, y, z) in enumerate(poles.tolist(), 1):
        array.SetValue(i, gp_Pnt(x, y, z))
    return array


def _knots(flat: ArrayLike) -> tuple[TColStd_Array1OfReal, TColStd_Array1OfInteger]:
    return _packed_knots(tuple(np.asarray(flat, dtype=np.float64).tolist()))


@lru_cache(maxsize=256)
def _packed_knots(flat: tuple[float, ...]) -> tuple[TColStd_Array1OfReal, TColStd_Array1OfInteger]:
    """Distinct knots and multiplicities; cached, since thousands of edges share one knot vector."""
    counts = Counter(flat)
    knots, mults = TColStd_Array1OfReal(1, len(counts)), TColStd_Array1OfInteger(1, len(counts))
    for i, (value, times) in enumerate(counts.items(), 1):
        knots.SetValue(i, value)
        mults.SetValue(i, times)
    return knots, mults
