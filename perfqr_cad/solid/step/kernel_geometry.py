"""Curves and surfaces of the modeller as STEP geometry (ISO 10303-42): faces of imported solids."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from OCP.Geom import (
    Geom_BezierCurve,
    Geom_BezierSurface,
    Geom_BSplineCurve,
    Geom_BSplineSurface,
    Geom_Circle,
    Geom_ConicalSurface,
    Geom_Curve,
    Geom_CylindricalSurface,
    Geom_Ellipse,
    Geom_Line,
    Geom_OffsetSurface,
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
from OCP.gp import gp_Dir, gp_Pnt

from perfqr_cad.errors import KernelError
from perfqr_cad.geometry.arrays import Mask
from perfqr_cad.solid.kernel import occ
from perfqr_cad.solid.kernel.modelled import ModelledCurves, ModelledSurfaces
from perfqr_cad.solid.step.text import UNIT_DIGITS, Part21, real, reals, refs

REBUILD = "writing STEP", "rebuild the faces of other kinds as B-spline surfaces"


class ModelledGeometry:
    """Writes the modeller's geometry into a file; equal points, directions and axes are written once."""

    def __init__(self, part: Part21) -> None:
        self._add, self._shared = part.add, part.shared
        self._curves: dict[type, Callable[[Any], int]] = {
            Geom_Line: self._line,
            Geom_Circle: self._circle,
            Geom_Ellipse: self._ellipse,
            Geom_BSplineCurve: self._spline,
            Geom_BezierCurve: lambda c: self._spline(GeomConvert.CurveToBSplineCurve_s(c)),
        }
        self._surfaces: dict[type, Callable[[Any], int]] = {
            Geom_Plane: lambda s: self._add(f"PLANE('',#{self._axes(s)})"),
            Geom_CylindricalSurface: self._cylinder,
            Geom_ConicalSurface: self._cone,
            Geom_SphericalSurface: self._sphere,
            Geom_ToroidalSurface: self._torus,
            Geom_SurfaceOfRevolution: self._revolution,
            Geom_SurfaceOfLinearExtrusion: self._extrusion,
            Geom_BSplineSurface: self._spline_surface,
            Geom_BezierSurface: lambda s: self._spline_surface(GeomConvert.SurfaceToBSplineSurface_s(s)),
            Geom_OffsetSurface: lambda s: self._spline_surface(GeomConvert.SurfaceToBSplineSurface_s(s)),
        }

    def curves(self, curves: ModelledCurves) -> list[int]:
        """The numbers of curves."""
        with occ.kernel(*REBUILD):
            return [self.curve(*run) for run in curves.runs]

    def surfaces(self, surfaces: ModelledSurfaces) -> tuple[list[int], Mask]:
        """The numbers of surfaces, and whether their normals in the file are opposite to their own."""
        with occ.kernel(*REBUILD):
            numbers, mirrored = zip(*map(self.surface, surfaces.handles), strict=True)
        return list(numbers), np.array(mirrored)

    def curve(self, curve: Geom_Curve, first: float, last: float) -> int:
        """A curve; `first` and `last` bound what must be converted because STEP has no such kind."""
        if isinstance(curve, Geom_TrimmedCurve):
            return self.curve(curve.BasisCurve(), first, last)
        writer = self._curves.get(type(curve))
        if writer is None:
            return self._spline(GeomConvert.CurveToBSplineCurve_s(Geom_TrimmedCurve(curve, first, last)))
        return writer(curve)

    def surface(self, surface: Geom_Surface) -> tuple[int, bool]:
        """A surface, and whether its normal in the file is opposite to the kernel's (left-handed axes)."""
        if isinstance(surface, Geom_RectangularTrimmedSurface):
            return self.surface(surface.BasisSurface())
        writer = self._surfaces.get(type(surface))
        if writer is None:
            raise KernelError(
                f"STEP has no {type(surface).__name__}: rebuild that face as a B-spline surface"
            )
        mirrored = hasattr(surface, "Position") and not surface.Position().Direct()
        return writer(surface), mirrored

    def point(self, p: gp_Pnt) -> int:
        return self._shared(f"CARTESIAN_POINT('',{reals(p.Coord())})")

    def direction(self, d: gp_Dir) -> int:
        return self._shared(f"DIRECTION('',{reals(d.Coord(), UNIT_DIGITS)})")

    def _frame(self, origin: gp_Pnt, z: gp_Dir, x: gp_Dir) -> int:
        return self._shared(
            f"AXIS2_PLACEMENT_3D('',#{self.point(origin)},#{self.direction(z)},#{self.direction(x)})"
        )

    def _axes(self, elementary: Any) -> int:
        frame = elementary.Position()
        return self._frame(frame.Location(), frame.Direction(), frame.XDirection())

    def _vector(self, d: gp_Dir) -> int:
        return self._shared(f"VECTOR('',#{self.direction(d)},1.)")

    def _line(self, line: Geom_Line) -> int:
        axis = line.Position()
        return self._add(f"LINE('',#{self.point(axis.Location())},#{self._vector(axis.Direction())})")

    def _circle(self, circle: Geom_Circle) -> int:
        return self._add(f"CIRCLE('',#{self._axes(circle)},{real(circle.Radius())})")

    def _ellipse(self, ellipse: Geom_Ellipse) -> int:
        radii = f"{real(ellipse.MajorRadius())},{real(ellipse.MinorRadius())}"
        return self._add(f"ELLIPSE('',#{self._axes(ellipse)},{radii})")

    def _spline(self, curve: Geom_BSplineCurve) -> int:
        if curve.IsPeriodic():
            curve = curve.Copy()
            curve.SetNotPeriodic()
        indices = range(1, curve.NbPoles() + 1)
        shape = f"{curve.Degree()},{refs(self.point(curve.Pole(i)) for i in indices)},.UNSPECIFIED.,.F.,.F."
        spans = range(1, curve.NbKnots() + 1)
        mults = ",".join(str(curve.Multiplicity(i)) for i in spans)
        knots = f"({mults}),{reals((curve.Knot(i) for i in spans), UNIT_DIGITS)},.UNSPECIFIED."
        if not curve.IsRational():
            return self._add(f"B_SPLINE_CURVE_WITH_KNOTS('',{shape},{knots})")
        weights = reals((curve.Weight(i) for i in indices), UNIT_DIGITS)
        return self._add(
            f"(BOUNDED_CURVE()B_SPLINE_CURVE({shape})B_SPLINE_CURVE_WITH_KNOTS({knots})CURVE()"
            f"GEOMETRIC_REPRESENTATION_ITEM()RATIONAL_B_SPLINE_CURVE({weights})REPRESENTATION_ITEM(''))"
        )

    def _cylinder(self, surface: Geom_CylindricalSurface) -> int:
        return self._add(f"CYLINDRICAL_SURFACE('',#{self._axes(surface)},{real(surface.Radius())})")

    def _cone(self, surface: Geom_ConicalSurface) -> int:
        """STEP wants a semi-angle above 0: a cone that narrows along its axis is turned about, normal
        kept."""
        frame, angle = surface.Position(), surface.SemiAngle()
        axis = frame.Direction() if angle > 0 else frame.Direction().Reversed()
        at = self._frame(frame.Location(), axis, frame.XDirection())
        return self._add(
            f"CONICAL_SURFACE('',#{at},{real(surface.RefRadius())},{real(abs(angle), UNIT_DIGITS)})"
        )

    def _sphere(self, surface: Geom_SphericalSurface) -> int:
        return self._add(f"SPHERICAL_SURFACE('',#{self._axes(surface)},{real(surface.Radius())})")

    def _torus(self, surface: Geom_ToroidalSurface) -> int:
        radii = f"{real(surface.MajorRadius())},{real(surface.MinorRadius())}"
        return self._add(f"TOROIDAL_SURFACE('',#{self._axes(surface)},{radii})")

    def _revolution(self, surface: Geom_SurfaceOfRevolution) -> int:
        axis = surface.Axis()
        at = self._add(
            f"AXIS1_PLACEMENT('',#{self.point(axis.Location())},#{self.direction(axis.Direction())})"
        )
        basis = surface.BasisCurve()
        profile = self.curve(basis, basis.FirstParameter(), basis.LastParameter())
        return self._add(f"SURFACE_OF_REVOLUTION('',#{profile},#{at})")

    def _extrusion(self, surface: Geom_SurfaceOfLinearExtrusion) -> int:
        basis = surface.BasisCurve()
        profile = self.curve(basis, basis.FirstParameter(), basis.LastParameter())
        return self._add(f"SURFACE_OF_LINEAR_EXTRUSION('',#{profile},#{self._vector(surface.Direction())})")

    def _spline_surface(self, surface: Geom_BSplineSurface) -> int:
        if surface.IsUPeriodic() or surface.IsVPeriodic():
            surface = surface.Copy()
            surface.SetUNotPeriodic()
            surface.SetVNotPeriodic()
        rows, columns = range(1, surface.NbUPoles() + 1), range(1, surface.NbVPoles() + 1)
        poles = ",".join(refs(self.point(surface.Pole(i, j)) for j in columns) for i in rows)
        shape = f"{surface.UDegree()},{surface.VDegree()},({poles}),.UNSPECIFIED.,.F.,.F.,.F."
        us, vs = range(1, surface.NbUKnots() + 1), range(1, surface.NbVKnots() + 1)
        u_mults = ",".join(str(surface.UMultiplicity(i)) for i in us)
        v_mults = ",".join(str(surface.VMultiplicity(i)) for i in vs)
        knots = (
            f"({u_mults}),({v_mults}),{reals((surface.UKnot(i) for i in us), UNIT_DIGITS)},"
            f"{reals((surface.VKnot(i) for i in vs), UNIT_DIGITS)},.UNSPECIFIED."
        )
        if not (surface.IsURational() or surface.IsVRational()):
            return self._add(f"B_SPLINE_SURFACE_WITH_KNOTS('',{shape},{knots})")
        weights = ",".join(reals((surface.Weight(i, j) for j in columns), UNIT_DIGITS) for i in rows)
        return self._add(
            f"(BOUNDED_SURFACE()B_SPLINE_SURFACE({shape})B_SPLINE_SURFACE_WITH_KNOTS({knots})"
            f"GEOMETRIC_REPRESENTATION_ITEM()RATIONAL_B_SPLINE_SURFACE(({weights}))REPRESENTATION_ITEM('')SURFACE())"
        )
