"""Exact faces: where a straight line through the wall meets them, and whether an outline stays inside."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from perfqr_cad.errors import KernelError
from perfqr_cad.solid.imported.body import Array

if TYPE_CHECKING:
    from OCP.BRepTopAdaptor import BRepTopAdaptor_FClass2d
    from OCP.Geom import Geom_Surface
    from OCP.TopoDS import TopoDS_Face
    from scipy.spatial import cKDTree

NEWTON_TOL_MM = 1e-10
NEWTON_STEPS = 40
SEEDS = 24  # a side: starting points of Newton's iteration


@dataclass(frozen=True)
class Skin:
    """One face of a solid with its exact surface."""

    face: TopoDS_Face

    @cached_property
    def surface(self) -> Geom_Surface:
        """The surface in its place."""
        from OCP.BRep import BRep_Tool

        return BRep_Tool.Surface_s(self.face)

    @cached_property
    def bounds(self) -> tuple[float, float, float, float]:
        """Least and greatest u, then v, of the trimmed face."""
        from OCP.BRepTools import BRepTools

        return BRepTools.UVBounds_s(self.face)

    @cached_property
    def is_plane(self) -> bool:
        """Whether the face is flat."""
        from OCP.BRepAdaptor import BRepAdaptor_Surface
        from OCP.GeomAbs import GeomAbs_SurfaceType

        return BRepAdaptor_Surface(self.face).GetType() == GeomAbs_SurfaceType.GeomAbs_Plane

    @cached_property
    def outward_sign(self) -> float:
        """+1 when ∂S/∂u × ∂S/∂v points out of the solid, −1 when into it."""
        from OCP.TopAbs import TopAbs_Orientation

        return -1.0 if self.face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED else 1.0

    @cached_property
    def _classifier(self) -> BRepTopAdaptor_FClass2d:
        from OCP.BRepTopAdaptor import BRepTopAdaptor_FClass2d

        return BRepTopAdaptor_FClass2d(self.face, 1e-7)

    @cached_property
    def _seeds(self) -> tuple[cKDTree, Array]:
        from scipy.spatial import cKDTree

        u0, u1, v0, v1 = self.bounds
        uv = [(u, v) for u in np.linspace(u0, u1, SEEDS) for v in np.linspace(v0, v1, SEEDS)]
        return cKDTree(np.array([self.surface.Value(u, v).Coord() for u, v in uv])), np.array(uv)

    def nearest_seed(self, point: Array) -> tuple[float, float]:
        """Parameters of the seed nearest to a point."""
        tree, uv = self._seeds
        u, v = uv[tree.query(point)[1]]
        return float(u), float(v)

    def normal(self, u: float, v: float) -> Array:
        """Unit normal out of the solid."""
        from OCP.gp import gp_Pnt, gp_Vec

        p, du, dv = gp_Pnt(), gp_Vec(), gp_Vec()
        self.surface.D1(u, v, p, du, dv)
        normal = np.cross(du.Coord(), dv.Coord()) * self.outward_sign
        return normal / np.linalg.norm(normal)

    def foot(self, point: Array) -> tuple[Array, Array] | None:
        """The exact point of the face's surface nearest to a point, and its outward normal; None at a pole."""
        from OCP.GeomAPI import GeomAPI_ProjectPointOnSurf
        from OCP.gp import gp_Pnt, gp_Vec

        search = GeomAPI_ProjectPointOnSurf(gp_Pnt(*point.tolist()), self.surface, *self.bounds)
        if not search.NbPoints():
            return None
        u, v = search.LowerDistanceParameters()
        p, du, dv = gp_Pnt(), gp_Vec(), gp_Vec()
        self.surface.D1(u, v, p, du, dv)
        normal = np.cross(du.Coord(), dv.Coord()) * self.outward_sign
        length = float(np.linalg.norm(normal))
        if length < 1e-9 * np.linalg.norm(du.Coord()) * np.linalg.norm(dv.Coord()) or length == 0.0:
            return None
        return np.array(p.Coord()), normal / length

    def meet(self, origins: Array, frames: Array, guesses: Array, reach_mm: float) -> tuple[Array, Array]:
        """Where lines meet the surface: parameters (k, 2) and points (k, 3).

        Line k passes through origins[k] along frames[k, 2]; guesses (k, 3) are within `reach_mm` of the meeting
        places, so that the far side of a bent surface is not taken for the near one.
        Newton's iteration on the two coordinates across the line, continued from one line to the next.
        Raises `KernelError` where a line does not meet the surface transversally.
        """
        uv, points = np.empty((len(origins), 2)), np.empty((len(origins), 3))
        at: tuple[float, float] | None = None
        for k in range(len(origins)):
            found = None
            if at is not None:
                found = self._newton(origins[k], frames[k], at, guesses[k], reach_mm)
            if found is None:
                found = self._newton(origins[k], frames[k], self.nearest_seed(guesses[k]), guesses[k], reach_mm)
            if found is None:
                where = ", ".join(f"{x:.3f}" for x in guesses[k])
                raise KernelError(f"the wall's surface cannot be followed at ({where}): move the code")
            at = found[0], found[1]
            uv[k], points[k] = at, found[2]
        return uv, points

    def _newton(
        self, origin: Array, frame: Array, start: tuple[float, float], guess: Array, reach: float
    ) -> tuple[float, float, tuple[float, float, float]] | None:
        from OCP.gp import gp_Pnt, gp_Vec

        (ox, oy, oz), (ax, ay, az), (bx, by, bz) = origin.tolist(), frame[0].tolist(), frame[1].tolist()
        u, v = start
        p, du, dv, d1 = gp_Pnt(), gp_Vec(), gp_Vec(), self.surface.D1
        for _ in range(NEWTON_STEPS):
            d1(u, v, p, du, dv)
            x, y, z = p.Coord()
            fa = (x - ox) * ax + (y - oy) * ay + (z - oz) * az
            fb = (x - ox) * bx + (y - oy) * by + (z - oz) * bz
            if abs(fa) + abs(fb) < NEWTON_TOL_MM:
                near = math.dist((x, y, z), guess.tolist())
                return (u, v, (x, y, z)) if near < reach else None
            ux, uy, uz = du.Coord()
            vx, vy, vz = dv.Coord()
            au, av = ux * ax + uy * ay + uz * az, vx * ax + vy * ay + vz * az
            bu, bv = ux * bx + uy * by + uz * bz, vx * bx + vy * by + vz * bz
            det = au * bv - av * bu
            if det == 0.0:
                return None
            u -= (bv * fa - av * fb) / det
            v -= (au * fb - bu * fa) / det
        return None

    def contains(self, uv: Array) -> bool:
        """Whether all parameters (k, 2) lie strictly inside the trimmed face, in one period of it."""
        from OCP.gp import gp_Pnt2d
        from OCP.TopAbs import TopAbs_State

        u0, u1, v0, v1 = self.bounds
        inside_box = (uv.min(axis=0) > (u0, v0)).all() and (uv.max(axis=0) < (u1, v1)).all()
        inside = TopAbs_State.TopAbs_IN
        return bool(inside_box) and all(
            self._classifier.Perform(gp_Pnt2d(u, v), False) == inside for u, v in uv.tolist()
        )

    def in_period(self, uv: Array) -> Array:
        """Parameters moved by whole periods, all by the same, so that their mean lies in the face's range."""
        u0, u1, v0, v1 = self.bounds
        moved = uv.copy()
        if self.surface.IsUPeriodic():
            moved[:, 0] -= _whole(moved[:, 0].mean() - (u0 + u1) / 2, self.surface.UPeriod())
        if self.surface.IsVPeriodic():
            moved[:, 1] -= _whole(moved[:, 1].mean() - (v0 + v1) / 2, self.surface.VPeriod())
        return moved


def _whole(offset: float, period: float) -> float:
    return period * round(offset / period)
