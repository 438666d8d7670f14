"""Prisms that the modeller takes away where a hole lies over an edge of the host's face."""

from __future__ import annotations

import numpy as np
from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
from OCP.gp import gp_Ax3, gp_Trsf
from OCP.TopoDS import TopoDS_Shape

from perfqr_cad.geometry.outline import Loop, Region
from perfqr_cad.hosts.body import Body
from perfqr_cad.hosts.cutters import CLEARANCE
from perfqr_cad.hosts.host_placement import Projected
from perfqr_cad.hosts.probe import probe
from perfqr_cad.profile import Walls
from perfqr_cad.profile.sections import sections
from perfqr_cad.solid.charts.plane_chart import PlaneChart
from perfqr_cad.solid.kernel.occ import direction, pnt
from perfqr_cad.solid.kernel.to_shape import KernelShape
from perfqr_cad.solid.stitch import panel
from perfqr_cad.surface import Plane


def prism(body: Body, hole: Loop, placement: Projected, depth_mm: float | None) -> TopoDS_Shape:
    """A straight prism over a hole, through the wall or down to a flat floor `depth_mm` below its lowest
    rim."""
    uv = hole.flatten()
    points = placement.point(uv)
    met = probe(body, points, np.tile(placement.frame_at_centre.axes[2], (len(points), 1)))
    front = placement.frame_at_centre.to_frame(points)[:, 2] + met.offset_mm
    margin = CLEARANCE * placement.thickness_mm
    top = float(front.max()) + margin
    bottom = (
        float((front - met.wall_mm).min()) - margin if depth_mm is None else float(front.min()) - depth_mm
    )
    plate = PlaneChart(Plane(top - bottom))
    block = panel(sections([Region(hole.oriented(ccw=True))], top - bottom, Walls(), True), plate)
    e1, _, n = placement.frame_at_centre.axes
    place = gp_Trsf()
    foot = placement.frame_at_centre.to_space([[0.0, 0.0, bottom]])[0]
    place.SetTransformation(gp_Ax3(pnt(foot), direction(n), direction(e1)), gp_Ax3())
    return BRepBuilderAPI_Transform(KernelShape(block).solid(), place, True).Shape()
