"""Formulas of surfaces against the modeller's own evaluation."""

import numpy as np
import pytest
from OCP.Geom import (
    Geom_Circle,
    Geom_ConicalSurface,
    Geom_CylindricalSurface,
    Geom_Line,
    Geom_OffsetSurface,
    Geom_Plane,
    Geom_RectangularTrimmedSurface,
    Geom_SphericalSurface,
    Geom_SurfaceOfLinearExtrusion,
    Geom_SurfaceOfRevolution,
    Geom_ToroidalSurface,
    Geom_TrimmedCurve,
)
from OCP.GeomConvert import GeomConvert
from OCP.gp import gp_Ax1, gp_Ax2, gp_Ax3, gp_Dir, gp_Pnt, gp_Vec

from perfqr_cad.solid.kernel.evaluate import FIRST, SECOND, evaluator

FRAME = gp_Ax3(gp_Pnt(1, 2, 3), gp_Dir(1, 1, 2), gp_Dir(1, -1, 0.3))
MIRRORED = gp_Ax3(FRAME.Ax2())
MIRRORED.YReverse()
AXIS = gp_Ax1(gp_Pnt(0, 1, 0), gp_Dir(0, 0.1, 1))
CIRCLE = Geom_Circle(gp_Ax2(gp_Pnt(9, 0, 0), gp_Dir(0, 1, 0)), 3)
TORUS = Geom_ToroidalSurface(FRAME, 9, 2)


def rational_arc():
    return GeomConvert.CurveToBSplineCurve_s(Geom_TrimmedCurve(CIRCLE, 0, 2))


def surfaces():
    yield "plane", Geom_Plane(FRAME)
    yield "cylinder", Geom_CylindricalSurface(FRAME, 5)
    yield "mirrored", Geom_CylindricalSurface(MIRRORED, 5)
    yield "cone", Geom_ConicalSurface(FRAME, 0.3, 5)
    yield "sphere", Geom_SphericalSurface(FRAME, 5)
    yield "torus", TORUS
    trimmed = Geom_RectangularTrimmedSurface(TORUS, 0.1, 2, 0.1, 2, True, True)
    yield "trimmed", trimmed
    yield "spline", GeomConvert.SurfaceToBSplineSurface_s(trimmed)
    yield "periodic spline", GeomConvert.SurfaceToBSplineSurface_s(TORUS)
    yield "revolved spline", Geom_SurfaceOfRevolution(rational_arc(), AXIS)
    yield "revolved line", Geom_SurfaceOfRevolution(Geom_Line(gp_Pnt(9, 0, 0), gp_Dir(0, 0.1, 1)), AXIS)
    yield "extruded spline", Geom_SurfaceOfLinearExtrusion(rational_arc(), gp_Dir(0, 0.1, 1))
    yield "extruded circle", Geom_SurfaceOfLinearExtrusion(CIRCLE, gp_Dir(0, 0.1, 1))
    yield "offset", Geom_OffsetSurface(TORUS, 0.3)


@pytest.mark.parametrize(("name", "surface"), list(surfaces()), ids=lambda x: x if isinstance(x, str) else "")
def test_points_and_derivatives_are_the_modellers(name, surface):
    u0, u1, v0, v1 = np.clip(surface.Bounds(), -20, 20)
    random = np.random.default_rng(3)
    uv = np.column_stack([random.uniform(u0, u1, 40), random.uniform(v0, v1, 40)])
    made = evaluator(surface)(uv, SECOND)
    for k, (u, v) in enumerate(uv.tolist()):
        p, du, dv, duu, dvv, duv = gp_Pnt(), gp_Vec(), gp_Vec(), gp_Vec(), gp_Vec(), gp_Vec()
        surface.D2(u, v, p, du, dv, duu, dvv, duv)
        wanted = [g.Coord() for g in (p, du, dv, duu, duv, dvv)]
        assert made[:, k] == pytest.approx(np.array(wanted), abs=1e-11 if name != "offset" else 0)
    for orders in (1, FIRST):
        assert np.array_equal(evaluator(surface)(uv, orders), made[:orders])
