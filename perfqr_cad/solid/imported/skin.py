# pyright: reportAttributeAccessIssue=false
# The modeller's stubs are incomplete.
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

    def parameters(self, point: Array) -> tuple[float, float]:
        """Parameters of the surface point nearest to a point. Raises `KernelError` when the search fails."""
        from OCP.GeomAPI import GeomAPI_ProjectPointOnSurf
        from OCP.gp import gp_Pnt

        search = GeomAPI_ProjectPointOnSurf(gp_Pnt(*point.tolist()), self.surface, *self.bounds)
        if not search.NbPoints():
            raise KernelError("a point could not be projected onto the face: move the code")
        u, v = search.LowerDistanceParameters()
        return u, v

    def derivatives(
        self, u: float, v: float
    ) -> tuple[tuple[Array, Array, Array], tuple[Array, Array, Array]]:
        """Point, ∂u, ∂v; and ∂uu, ∂vv, ∂uv, each (3,)."""
        from OCP.gp import gp_Pnt, gp_Vec

        p, du, dv, duu, dvv, duv = gp_Pnt(), gp_Vec(), gp_Vec(), gp_Vec(), gp_Vec(), gp_Vec()
        self.surface.D2(u, v, p, du, dv, duu, dvv, duv)
        first = np.array([p.Coord(), du.Coord(), dv.Coord()])
        second = np.array([duu.Coord(), dvv.Coord(), duv.Coord()])
        return (first[0], first[1], first[2]), (second[0], second[1], second[2])

    def foot(self, point: Array) -> tuple[Array, Array] | None:
        """The exact point of the surface nearest to a point, and its outward normal; None at a pole."""
        (p, du, dv), _ = self.derivatives(*self.parameters(point))
        normal = np.cross(du, dv) * self.outward_sign
        length = float(np.linalg.norm(normal))
        if length <= 1e-9 * float(np.linalg.norm(du) * np.linalg.norm(dv)):
            return None
        return p, normal / length

    def meet(self, origins: Array, frames: Array, guesses: Array, reach_mm: float) -> tuple[Array, Array]:
        """Where lines meet the surface: parameters (k, 2) and points (k, 3).

        Line k passes through origins[k] along frames[k, 2]; guesses (k, 3) are within `reach_mm` of the
        meeting
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
                found = self._newton(
                    origins[k], frames[k], self.nearest_seed(guesses[k]), guesses[k], reach_mm
                )
            if found is None:
                where = ", ".join(f"{x:.3f}" for x in guesses[k])
                raise KernelError(f"the wall's surface cannot be followed at ({where}): move the code")
            at = found[0], found[1]
            uv[k], points[k] = at, found[2]
        return self._in_period(uv), points

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

    def _in_period(self, uv: Array) -> Array:
        """Parameters moved by whole periods into the face's range; outlines across a seam are not for us."""
        u0, _, v0, _ = self.bounds
        if self.surface.IsUPeriodic():
            uv[:, 0] = u0 + np.mod(uv[:, 0] - u0, self.surface.UPeriod())
        if self.surface.IsVPeriodic():
            uv[:, 1] = v0 + np.mod(uv[:, 1] - v0, self.surface.VPeriod())
        return uv
