"""Exact surfaces as arrays: points and derivatives at many parameters at once.

The modeller answers one point a call; holes ask for tens of thousands. Elementary surfaces, B-splines and
sweeps of curves are evaluated here by their own formulas (parameters as the modeller's), all others by it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from OCP.Geom import (
    Geom_BezierCurve,
    Geom_BezierSurface,
    Geom_BSplineCurve,
    Geom_BSplineSurface,
    Geom_ConicalSurface,
    Geom_Curve,
    Geom_CylindricalSurface,
    Geom_Line,
    Geom_Plane,
    Geom_RectangularTrimmedSurface,
    Geom_SphericalSurface,
    Geom_Surface,
    Geom_SurfaceOfLinearExtrusion,
    Geom_SurfaceOfRevolution,
    Geom_ToroidalSurface,
    Geom_TrimmedCurve,
)
from OCP.GeomConvert import GeomConvert
from OCP.gp import gp_Pnt, gp_Vec

from perfqr_cad.geometry.arrays import Array

if TYPE_CHECKING:
    from scipy.interpolate import NdBSpline

# Parameters (k,) to the radius and the height there, each with its first and second derivative, (3, k).
Meridian = Callable[[Array], tuple[Array, Array]]
# Parameters (k,) to the point there, its first and its second derivative, (3, k, 3).
Curve = Callable[[Array], Array]

# Orders of differentiation by (u, v): the point, two first and three second derivatives.
ORDERS = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
FIRST, SECOND = 3, 6  # how many of them: up to the first or the second derivatives


class Evaluator(Protocol):
    """A parametric surface."""

    def __call__(self, uv: Array, orders: int) -> Array:
        """The first `orders` of `ORDERS` at parameters (k, 2): (orders, k, 3)."""
        ...


def evaluator(surface: Geom_Surface) -> Evaluator:
    """The formulas of a modeller's surface."""
    match surface:
        case Geom_RectangularTrimmedSurface():
            return evaluator(surface.BasisSurface())
        case Geom_Plane():
            origin, x, y, _ = frame_of(surface)
            return _Plane(origin, x, y)
        case Geom_CylindricalSurface():
            return _turned(surface, lambda v: _profile(v, (surface.Radius(), 0.0), (v, 1.0)))
        case Geom_ConicalSurface():
            slope, radius = surface.SemiAngle(), surface.RefRadius()
            sin, cos = float(np.sin(slope)), float(np.cos(slope))
            return _turned(surface, lambda v: _profile(v, (radius + v * sin, sin), (v * cos, cos)))
        case Geom_SphericalSurface():
            return _turned(surface, lambda v: _circle(v, 0.0, surface.Radius()))
        case Geom_ToroidalSurface():
            return _turned(surface, lambda v: _circle(v, surface.MajorRadius(), surface.MinorRadius()))
        case Geom_BSplineSurface():
            return _Spline.of_surface(surface)
        case Geom_BezierSurface():
            return _Spline.of_surface(GeomConvert.SurfaceToBSplineSurface_s(surface))
        case Geom_SurfaceOfLinearExtrusion():
            return _Extruded(_curve(surface.BasisCurve()), np.array(surface.Direction().Coord()))
        case Geom_SurfaceOfRevolution():
            axis = surface.Axis()
            origin, along = (np.array(p.Coord()) for p in (axis.Location(), axis.Direction()))
            return _Revolved(_curve(surface.BasisCurve()), origin, along)
        case _:
            return _Modelled(surface)


@dataclass(frozen=True)
class _Plane:
    origin: Array
    x: Array
    y: Array

    def __call__(self, uv: Array, orders: int) -> Array:
        made = np.zeros((SECOND, len(uv), 3))
        made[0] = self.origin + uv @ np.stack([self.x, self.y])
        made[1], made[2] = self.x, self.y
        return made[:orders]


@dataclass(frozen=True)
class _Turned:
    """A profile in the half-plane of an axis, turned by u."""

    origin: Array
    x: Array
    y: Array
    axis: Array
    profile: Meridian

    def __call__(self, uv: Array, orders: int) -> Array:
        radius, height = self.profile(uv[:, 1])
        cos, sin = np.cos(uv[:, :1]), np.sin(uv[:, :1])
        out, across = cos * self.x + sin * self.y, cos * self.y - sin * self.x
        turned = (out, across, -out)  # the ray by order of differentiation
        made = np.empty((orders, len(uv), 3))
        for i, (by_u, by_v) in enumerate(ORDERS[:orders]):
            made[i] = radius[by_v][:, None] * turned[by_u]
            if not by_u:
                made[i] += height[by_v][:, None] * self.axis
        made[0] += self.origin
        return made


@dataclass(frozen=True)
class _Spline:
    """A rational tensor-product B-spline: (x w, y w, z w, w) by one polynomial spline."""

    homogeneous: NdBSpline = field(repr=False)

    @staticmethod
    def of_surface(surface: Geom_BSplineSurface) -> _Spline:
        from scipy.interpolate import NdBSpline

        plain: Any = surface.Copy()
        plain.SetUNotPeriodic()
        plain.SetVNotPeriodic()
        rows, columns = range(1, plain.NbUPoles() + 1), range(1, plain.NbVPoles() + 1)
        poles = np.array([[(*plain.Pole(i, j).Coord(), 1.0) for j in columns] for i in rows])
        if surface.IsURational() or surface.IsVRational():  # else what was periodic has weights of 0
            poles *= np.array([[plain.Weight(i, j) for j in columns] for i in rows])[..., None]
        u_knots = _flat(plain.UKnots(), plain.UMultiplicities())
        v_knots = _flat(plain.VKnots(), plain.VMultiplicities())
        return _Spline(NdBSpline((u_knots, v_knots), poles, (plain.UDegree(), plain.VDegree())))

    def __call__(self, uv: Array, orders: int) -> Array:
        return _projected([self.homogeneous(uv, nu=order) for order in ORDERS[:orders]])


def _projected(homogeneous: list[Array]) -> Array:
    """Derivatives of a quotient from those of numerator and denominator (Piegl and Tiller, §4.5)."""
    made = np.empty((len(homogeneous), len(homogeneous[0]), 3))
    weight = [h[:, 3:] for h in homogeneous]
    made[0] = homogeneous[0][:, :3] / weight[0]
    for i in range(1, min(len(homogeneous), FIRST)):
        made[i] = (homogeneous[i][:, :3] - weight[i] * made[0]) / weight[0]
    for i, (a, b) in enumerate(((1, 1), (1, 2), (2, 2))[: max(0, len(homogeneous) - FIRST)], FIRST):
        mixed = weight[a] * made[b] + weight[b] * made[a] + weight[i] * made[0]
        made[i] = (homogeneous[i][:, :3] - mixed) / weight[0]
    return made


@dataclass(frozen=True)
class _Extruded:
    """A curve of u moved along a direction by v."""

    curve: Curve
    along: Array

    def __call__(self, uv: Array, orders: int) -> Array:
        drawn = self.curve(uv[:, 0])
        made = np.zeros((SECOND, len(uv), 3))
        made[0], made[1], made[2], made[3] = drawn[0] + uv[:, 1:] * self.along, drawn[1], self.along, drawn[2]
        return made[:orders]


@dataclass(frozen=True)
class _Revolved:
    """A curve of v turned about an axis by u."""

    curve: Curve
    origin: Array
    axis: Array

    def __call__(self, uv: Array, orders: int) -> Array:
        drawn = self.curve(uv[:, 1])
        drawn[0] -= self.origin
        cos, sin = np.cos(uv[:, :1]), np.sin(uv[:, :1])
        made = np.empty((orders, len(uv), 3))
        for i, (by_u, by_v) in enumerate(ORDERS[:orders]):
            along = (drawn[by_v] @ self.axis)[:, None] * self.axis
            out, across = drawn[by_v] - along, np.cross(self.axis, drawn[by_v])
            turned = (along + cos * out + sin * across, cos * across - sin * out, -cos * out - sin * across)
            made[i] = turned[by_u]
        made[0] += self.origin
        return made


@dataclass(frozen=True)
class _Modelled:
    """Any other surface: one call of the modeller a point."""

    surface: Geom_Surface

    def __call__(self, uv: Array, orders: int) -> Array:
        p, du, dv, duu, dvv, duv = gp_Pnt(), gp_Vec(), gp_Vec(), gp_Vec(), gp_Vec(), gp_Vec()
        made = np.empty((orders, len(uv), 3))
        for k, (u, v) in enumerate(uv.tolist()):
            if orders <= FIRST:
                self.surface.D1(u, v, p, du, dv)
            else:
                self.surface.D2(u, v, p, du, dv, duu, dvv, duv)
            made[:, k] = [g.Coord() for g in (p, du, dv, duu, duv, dvv)[:orders]]
        return made


def _curve(curve: Geom_Curve) -> Curve:
    """Points and derivatives of a basis curve."""
    match curve:
        case Geom_TrimmedCurve():
            return _curve(curve.BasisCurve())
        case Geom_Line():
            start, along = (np.array(g.Coord()) for g in (curve.Lin().Location(), curve.Lin().Direction()))
            return lambda t: np.stack(
                [start + t[:, None] * along, np.tile(along, (len(t), 1)), np.zeros((len(t), 3))]
            )
        case Geom_BSplineCurve():
            return _spline_curve(curve)
        case Geom_BezierCurve():
            return _spline_curve(GeomConvert.CurveToBSplineCurve_s(curve))
        case _:
            return lambda t: _modelled_curve(curve, t)


def _spline_curve(curve: Geom_BSplineCurve) -> Curve:
    from scipy.interpolate import BSpline

    plain: Any = curve.Copy()
    plain.SetNotPeriodic()
    every = range(1, plain.NbPoles() + 1)
    poles = np.array([(*plain.Pole(i).Coord(), 1.0) for i in every])
    if curve.IsRational():  # else what was periodic has weights of 0
        poles *= np.array([plain.Weight(i) for i in every])[:, None]
    spline = BSpline(_flat(plain.Knots(), plain.Multiplicities()), poles, plain.Degree())

    def drawn(t: Array) -> Array:
        point, first, second = (spline(t, nu=order) for order in range(3))
        # A curve is a surface that does not depend on v.
        still = np.zeros_like(first)
        return _projected([point, first, still, second, still, still])[[0, 1, 3]]

    return drawn


def _modelled_curve(curve: Geom_Curve, t: Array) -> Array:
    p, first, second = gp_Pnt(), gp_Vec(), gp_Vec()
    made = np.empty((3, len(t), 3))
    for k, parameter in enumerate(t.tolist()):
        curve.D2(parameter, p, first, second)
        made[:, k] = [g.Coord() for g in (p, first, second)]
    return made


def _turned(surface: Any, profile: Meridian) -> _Turned:
    return _Turned(*frame_of(surface), profile)


def frame_of(surface: Any) -> tuple[Array, Array, Array, Array]:
    """Origin, x, y and axis of an elementary surface; left-handed ones as they are."""
    frame = surface.Position()
    x, y, z = (np.array(d.Coord()) for d in (frame.XDirection(), frame.YDirection(), frame.Direction()))
    return np.array(frame.Location().Coord()), x, y, z


def _profile(v: Array, radius: tuple[Any, float], height: tuple[Any, float]) -> tuple[Array, Array]:
    """A straight profile: value and slope of radius and height."""
    still = np.zeros_like(v)
    return (
        np.stack([still + radius[0], still + radius[1], still]),
        np.stack([still + height[0], still + height[1], still]),
    )


def _circle(v: Array, centre: float, radius: float) -> tuple[Array, Array]:
    """A circular profile about a point `centre` off the axis."""
    cos, sin = radius * np.cos(v), radius * np.sin(v)
    return np.stack([centre + cos, -sin, -cos]), np.stack([sin, cos, -sin])


def _flat(knots: Any, multiplicities: Any) -> Array:
    """A flat knot vector from distinct knots and their multiplicities."""
    low, high = knots.Lower(), knots.Upper()
    values = [knots.Value(i) for i in range(low, high + 1)]
    return np.repeat(values, [multiplicities.Value(i) for i in range(low, high + 1)])
