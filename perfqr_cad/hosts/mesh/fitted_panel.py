"""The surface under a code as an exact B-spline panel, for CAD programs that want faces and not triangles."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry.arrays import Array
from perfqr_cad.geometry.spline import DEGREE, collocation, greville
from perfqr_cad.hosts.body import Body
from perfqr_cad.hosts.frame import Frame
from perfqr_cad.hosts.host_placement import Projected
from perfqr_cad.hosts.survey import survey

if TYPE_CHECKING:
    from OCP.TopoDS import TopoDS_Solid

    from perfqr_cad.pattern import Pattern
    from perfqr_cad.profile.walls import Walls
    from perfqr_cad.solid.shape import Solid

SAMPLES = 121  # heights a side that the spline is fitted to
SPANS = (4, 6, 9, 13, 18, 24)  # polynomial pieces a side, the fewest first
FIT_MM = 0.05  # wanted worst error: half the accuracy of a printer
WORST_SHARE = 0.15  # of the wall: a worse fit is refused
BEYOND = 1.01  # the fit reaches a little over the code's rim


@dataclass(frozen=True)
class FittedPanel:
    """A bicubic height field fitted under a code, and the wall behind it.

    knots      flat, the same across and up; `heights_mm` are the poles (n, n), rows up, columns right
    worst_mm   greatest distance between mesh and spline along the axis, over all samples
    """

    frame: Frame
    size_mm: float
    thickness_mm: float
    knots: Array = field(repr=False)
    heights_mm: Array = field(repr=False)
    worst_mm: float

    def solid(self, pattern: Pattern, walls: Walls) -> Solid:
        """The perforated panel, where it lies on the mesh; its name states the fitting error."""
        from perfqr_cad.hosts.host_profile import host_profile
        from perfqr_cad.hosts.step.carve import carve
        from perfqr_cad.hosts.step.host import Host
        from perfqr_cad.hosts.step.imported_face import projected
        from perfqr_cad.solid.kernel import booleans as kernel

        name = f"panel fitted within {self.worst_mm:.3f} mm"
        host = Host(name, kernel.sound(self._panel(), name))
        placement = projected(host, survey(host.body, self.frame, self.size_mm), self.thickness_mm)
        return carve(host, host_profile(pattern), placement, walls)

    def _panel(self) -> TopoDS_Solid:
        """The spline swept along the axis by the wall's thickness."""
        from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
        from OCP.BRepPrimAPI import BRepPrimAPI_MakePrism
        from OCP.gp import gp_Vec
        from OCP.TopoDS import TopoDS

        from perfqr_cad.solid.kernel.occ import spline_surface
        from perfqr_cad.solid.tables.brep import TOLERANCE_MM

        across = greville(self.knots)
        x, y = np.meshgrid(across, across, indexing="ij")
        poles = self.frame.to_space(np.stack([x, y, self.heights_mm.T], axis=-1).reshape(-1, 3))
        surface = spline_surface(poles.reshape(*x.shape, 3), self.knots, self.knots, (DEGREE, DEGREE))
        half = self.size_mm / 2
        face = BRepBuilderAPI_MakeFace(surface, -half, half, -half, half, TOLERANCE_MM).Face()
        inward = gp_Vec(*(-self.thickness_mm * self.frame.axes[2]).tolist())
        return TopoDS.Solid_s(BRepPrimAPI_MakePrism(face, inward).Shape())


def fit_panel(body: Body, placement: Projected, size_mm: float) -> FittedPanel:
    """The coarsest bicubic spline within `FIT_MM` of the mesh under the code, or the finest.

    Raises `DesignError` when even that misses by more than `WORST_SHARE` of the wall: the surface is too
    rough.
    """
    half = BEYOND * size_mm / 2
    line = np.linspace(-half, half, SAMPLES)
    height = survey(body, placement.frame_at_centre, 2 * half, SAMPLES).height_mm
    if np.isnan(height).any():
        raise DesignError(
            "the code lies too near to the rim for an exact panel: move it 1 % of its size inwards"
        )
    knots, poles, worst = line, height, np.inf
    for spans in SPANS:
        knots, poles, error = _least_squares(line, height, spans)
        worst = float(np.abs(error).max())
        if worst <= FIT_MM:
            break
    if worst > WORST_SHARE * placement.thickness_mm:
        raise DesignError(
            f"the surface under the code is too rough for an exact panel: the fit misses it by "
            f"{worst:.3g} mm "
            f"(limit {WORST_SHARE * placement.thickness_mm:.3g} mm); take a smoother spot, or the mesh result"
        )
    return FittedPanel(placement.frame_at_centre, size_mm, placement.thickness_mm, knots, poles, worst)


def _least_squares(line: Array, height: Array, spans: int) -> tuple[Array, Array, Array]:
    """Knots, poles (n, n) and residuals of the bicubic of `spans` equal pieces a side nearest to the
    heights."""
    breaks = np.linspace(line[0], line[-1], spans + 1)
    knots = np.concatenate([[breaks[0]] * DEGREE, breaks, [breaks[-1]] * DEGREE])
    basis = collocation(knots, line)
    solve = np.linalg.pinv(basis)
    poles = solve @ height @ solve.T
    return knots, poles, basis @ poles @ basis.T - height
