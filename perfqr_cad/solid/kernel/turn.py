"""A finished plate turned over."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
from OCP.gp import gp_Ax1, gp_Dir, gp_Pnt, gp_Trsf
from OCP.TopoDS import TopoDS

from perfqr_cad.geometry import Triangles
from perfqr_cad.remedy import Remedy
from perfqr_cad.solid.kernel import occ

if TYPE_CHECKING:
    from perfqr_cad.solid.shape import Solid

TURNING = "turning the part over", Remedy(mirror=None)


def turned(solid: Solid, thickness_mm: float) -> Solid:
    """The solid after half a turn about the y axis at half the thickness: (−x, y, thickness − z).

    Nothing is mirrored: what was on the front at z = thickness is at z = 0, and the reader below.
    """
    half_turn = gp_Trsf()
    half_turn.SetMirror(gp_Ax1(gp_Pnt(0, 0, thickness_mm / 2), gp_Dir(0, 1, 0)))  # about an axis: half a turn
    with occ.kernel(*TURNING):
        shape = TopoDS.Solid_s(BRepBuilderAPI_Transform(solid.shape, half_turn, True).Shape())
    (x0, y0, z0), (x1, y1, z1) = solid.bbox_mm
    return replace(
        solid,
        exact=shape,
        triangles=Triangles(
            solid.triangles.vertices * (-1.0, 1.0, -1.0) + (0.0, 0.0, thickness_mm), solid.triangles.faces
        ),
        bbox_mm=((-x1, y0, thickness_mm - z1), (-x0, y1, thickness_mm - z0)),
        extras=tuple(turned(extra, thickness_mm) for extra in solid.extras),
    )
