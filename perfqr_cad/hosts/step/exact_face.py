"""Exact faces: where a straight line through the wall meets them, and whether an outline stays inside."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from perfqr_cad.errors import KernelError
from perfqr_cad.geometry.arrays import Array, Mask

if TYPE_CHECKING:
    from OCP.Geom import Geom_Surface
    from OCP.ShapeAnalysis import ShapeAnalysis_Surface
    from OCP.TopoDS import TopoDS_Face
    from scipy.spatial import cKDTree

    from perfqr_cad.hosts.step.quadric import Quadric
    from perfqr_cad.solid.kernel.evaluate import Evaluator

NEWTON_TOL_MM = 1e-10
NEWTON_STEPS = 40
SEEDS = 24  # a side: starting points of Newton's iteration


@dataclass(frozen=True)
class ExactFace:
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
    def evaluate(self) -> Evaluator:
        """Points and derivatives at many parameters."""
        from perfqr_cad.solid.kernel.evaluate import evaluator

        return evaluator(self.surface)

    @cached_property
    def _quadric(self) -> Quadric | None:
        from perfqr_cad.hosts.step.quadric import quadric

        return quadric(self.surface)

    @cached_property
    def _seeds(self) -> tuple[cKDTree, Array]:
        from scipy.spatial import cKDTree

        u0, u1, v0, v1 = self.bounds
        u, v = np.meshgrid(np.linspace(u0, u1, SEEDS), np.linspace(v0, v1, SEEDS))
        uv = np.column_stack([u.ravel(), v.ravel()])
        return cKDTree(self.evaluate(uv, 1)[0]), uv

    def normals(self, uv: Array) -> Array:
        """Unit normals (k, 3) out of the solid at parameters (k, 2)."""
        _, du, dv = self.evaluate(uv, 3)
        normal = np.cross(du, dv) * self.outward_sign
        return normal / np.linalg.norm(normal, axis=1)[:, None]

    @cached_property
    def _seeker(self) -> ShapeAnalysis_Surface:
        from OCP.ShapeAnalysis import ShapeAnalysis_Surface

        return ShapeAnalysis_Surface(self.surface)

    def parameters(self, point: Array) -> tuple[float, float]:
        """Parameters of the surface point nearest to a point on or near the face."""
        from OCP.gp import gp_Pnt

        found = self._seeker.ValueOfUV(gp_Pnt(*point.tolist()), NEWTON_TOL_MM)
        (uv,) = self._in_period(np.array([[found.X(), found.Y()]]))
        return float(uv[0]), float(uv[1])

    def foot(self, point: Array) -> tuple[Array, Array] | None:
        """The exact point of the surface nearest to a point, and its outward normal; None at a pole."""
        p, du, dv = self.evaluate(np.array([self.parameters(point)]), 3)[:, 0]
        normal = np.cross(du, dv) * self.outward_sign
        length = float(np.linalg.norm(normal))
        if length <= 1e-9 * float(np.linalg.norm(du) * np.linalg.norm(dv)):
            return None
        return p, normal / length

    def meet(self, origins: Array, frames: Array, guesses: Array, reach_mm: float) -> tuple[Array, Array]:
        """Where lines meet the surface: parameters (k, 2) and points (k, 3).

        Line k passes through origins[k] along frames[k, 2]; guesses (k, 3) are within `reach_mm` of the
        meeting places, so that the far side of a bent surface is not taken for the near one.
        Closed forms on planes, cylinders, cones and spheres; else Newton's iteration on the two coordinates
        across the line, from the nearest of the face's seeds, and where that fails from the nearest meeting
        place found. Raises `KernelError` where a line does not meet the surface transversally.
        """
        if self._quadric is not None:
            uv, points = self._quadric.meet(guesses, frames[:, 2])
            met = np.linalg.norm(points - guesses, axis=1) < reach_mm
            return self._all(met, uv, points, guesses)
        tree, seeds = self._seeds
        uv, points, met = self._newton(origins, frames, seeds[tree.query(guesses)[1]], guesses, reach_mm)
        if met.any() and not met.all():
            from scipy.spatial import cKDTree

            lost = np.flatnonzero(~met)
            near = np.flatnonzero(met)[cKDTree(guesses[met]).query(guesses[lost])[1]]
            uv[lost], points[lost], met[lost] = self._newton(
                origins[lost], frames[lost], uv[near], guesses[lost], reach_mm
            )
        return self._all(met, uv, points, guesses)

    def _all(self, met: Mask, uv: Array, points: Array, guesses: Array) -> tuple[Array, Array]:
        """What was met, once all is. Raises `KernelError` with the first place where the surface was lost."""
        if not met.all():
            where = ", ".join(f"{x:.3f}" for x in guesses[np.argmin(met)])
            raise KernelError(f"the wall's surface cannot be followed at ({where}): move the code")
        return self._in_period(uv), points

    def _newton(
        self, origins: Array, frames: Array, start: Array, guesses: Array, reach_mm: float
    ) -> tuple[Array, Array, Mask]:
        """Parameters, points, and which of them lie on their line and near their guess."""
        uv, points = start.astype(float), np.full_like(guesses, np.inf)
        met = np.zeros(len(uv), bool)
        left = np.arange(len(uv))
        u0, u1, v0, v1 = self.bounds
        low, high = np.array([2 * u0 - u1, 2 * v0 - v1]), np.array([2 * u1 - u0, 2 * v1 - v0])
        for _ in range(NEWTON_STEPS):
            p, du, dv = self.evaluate(uv[left], 3)
            across = frames[left, :2]
            (fa, fb), (au, bu), (av, bv) = (
                np.einsum("kij,kj->ik", across, vector) for vector in (p - origins[left], du, dv)
            )
            there = np.abs(fa) + np.abs(fb) < NEWTON_TOL_MM
            points[left[there]], met[left[there]] = p[there], True
            det = au * bv - av * bu
            going = ~there & (det != 0.0) & np.isfinite(det)
            if not going.any():
                break
            step = np.stack([bv * fa - av * fb, au * fb - bu * fa], axis=1)[going] / det[going, None]
            left = left[going]
            uv[left] = np.clip(uv[left] - step, low, high)  # a spline far beyond its knots overflows
        near = np.linalg.norm(np.where(met[:, None], points - guesses, 0.0), axis=1) < reach_mm
        return uv, points, met & near

    def _in_period(self, uv: Array) -> Array:
        """Parameters moved by whole periods into the face's range; outlines across a seam are not for us."""
        u0, _, v0, _ = self.bounds
        if self.surface.IsUPeriodic():
            uv[:, 0] = u0 + np.mod(uv[:, 0] - u0, self.surface.UPeriod())
        if self.surface.IsVPeriodic():
            uv[:, 1] = v0 + np.mod(uv[:, 1] - v0, self.surface.VPeriod())
        return uv
