# pyright: reportAttributeAccessIssue=false
# The modeller's stubs are incomplete.
"""What is taken away: prisms for the modeller, and closed meshes for manifold3d."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from perfqr_cad.errors import KernelError
from perfqr_cad.pattern.outline import Loop, Region
from perfqr_cad.solid.chart import Level
from perfqr_cad.solid.imported.body import Array, Body
from perfqr_cad.solid.imported.lay import Laid, Projected
from perfqr_cad.solid.imported.probe import probe
from perfqr_cad.solid.imported.removed import quadrature
from perfqr_cad.solid.mesh import triangulate
from perfqr_cad.solid.sections import Well
from perfqr_cad.solid.walls import Walls
from perfqr_cad.surface import Plane, Triangles

if TYPE_CHECKING:
    from manifold3d import Manifold
    from OCP.TopoDS import TopoDS_Shape

SAMPLE_MM = 0.02  # chord error of the outline that feels for the wall
CLEARANCE = 0.2  # of the wall: how far tools stand out before and behind it


def prism(body: Body, hole: Loop, laid: Projected, depth_mm: float | None) -> TopoDS_Shape:
    """A straight prism over a hole, through the wall or down to a flat floor `depth_mm` below its lowest
    rim.
    """
    from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
    from OCP.gp import gp_Ax3, gp_Trsf

    from perfqr_cad.solid.occ import direction, pnt
    from perfqr_cad.solid.plane_chart import PlaneChart
    from perfqr_cad.solid.punch import panel
    from perfqr_cad.solid.sections import sections

    uv = hole.flatten()
    points = laid.point(uv)
    met = probe(body, points, np.tile(laid.frame_at_centre.axes[2], (len(points), 1)))
    front = laid.frame_at_centre.to_frame(points)[:, 2] + met.offset_mm
    margin = CLEARANCE * laid.thickness_mm
    top = float(front.max()) + margin
    bottom = (
        float((front - met.wall_mm).min()) - margin if depth_mm is None else float(front.min()) - depth_mm
    )
    plate = PlaneChart(Plane(top - bottom))
    block = panel(sections([Region(hole.oriented(ccw=True))], top - bottom, Walls(), True), plate)
    e1, _, n = laid.frame_at_centre.axes
    place = gp_Trsf()
    foot = laid.frame_at_centre.to_space([[0.0, 0.0, bottom]])[0]
    place.SetTransformation(gp_Ax3(pnt(foot), direction(n), direction(e1)), gp_Ax3())
    return BRepBuilderAPI_Transform(block, place, True).Shape()


def carved_mesh(body: Body, wells: Sequence[Well], laid: Laid) -> Triangles:
    """The body less all wells, closed and in as many bodies as before.

    Raises `KernelError` when manifold3d objects or something falls off.
    """
    import manifold3d

    solid = manifold_of(body.triangles)
    result = solid - manifold3d.Manifold.compose(_tools(body, wells, laid))
    if result.status() != manifold3d.Error.NoError:
        raise KernelError(f"carving the mesh failed in manifold3d ({result.status().name}): move the code")
    before, after = len(solid.decompose()), len(result.decompose())
    if after > before:
        raise KernelError(
            f"carving left {after - before} loose pieces: choose a thicker place or a larger code"
        )
    return triangles_of(result)


def _tools(body: Body, wells: Sequence[Well], laid: Laid) -> list[Manifold]:
    """Each hole as a closed mesh that stands out of the wall on both sides (a pocket: only in front)."""
    feelers = [np.vstack([w.loops[0].flatten(SAMPLE_MM), quadrature([w.loops[0]])[0]]) for w in wells]
    lines, frames = laid.line(np.vstack(feelers))
    met = probe(body, lines, frames[:, 2])
    front = lines + met.offset_mm[:, None] * frames[:, 2]
    splits = np.cumsum([len(uv) for uv in feelers])[:-1]
    by_well = zip(*(np.split(felt, splits) for felt in (front, met.offset_mm, met.wall_mm)), strict=True)
    return [
        _tool(well, laid, front, offset, wall, body.faceted)
        for well, (front, offset, wall) in zip(wells, by_well, strict=True)
    ]


def _tool(well: Well, laid: Laid, front: Array, offset_mm: Array, wall_mm: Array, faceted: bool) -> Manifold:
    """One hole, from what was felt under it: front points (k, 3), their offset from the map, and the wall."""
    wall = float(np.nanmax(wall_mm))
    margin = CLEARANCE * wall
    straight = len(well.loops) == 2 and well.loops[0] == well.loops[1]
    if isinstance(laid, Projected) and straight and not well.floor:
        return _straight_tool(well.loops[0], laid, front, wall_mm, margin)
    # A flared through-hole goes on straight from the nominal back to the far end of an uneven wall.
    proud = margin + float(np.nanmax(np.abs(offset_mm)))
    depths, loops = [level.depth_mm for level in well.levels], list(well.loops)
    if not well.floor:
        depths.append(max(wall, depths[-1]) + proud)
        loops.append(loops[-1])
    levels = tuple(Level(d + proud if d else 0.0, False) for d in depths)

    def place(uv: Array, depth_mm: float) -> Array:
        return laid.at_depth(uv, depth_mm - proud)

    rim = Well(tuple(loop.reversed() for loop in loops), levels)
    return manifold_of(triangulate([rim], levels[-1].depth_mm, place, flat=faceted))


def _straight_tool(hole: Loop, laid: Projected, front: Array, wall_mm: Array, margin: float) -> Manifold:
    """A prism along the projection's axis from above the highest front to below the lowest back."""
    height = laid.frame_at_centre.to_frame(front)[:, 2]
    top, bottom = float(np.nanmax(height)) + margin, float(np.nanmin(height - wall_mm)) - margin
    loop = hole.reversed()

    def place(uv: Array, depth_mm: float) -> Array:
        return laid.frame_at_centre.to_space(np.column_stack([uv, np.full(len(uv), top - depth_mm)]))

    levels = (Level(0.0, False), Level(top - bottom, False))
    return manifold_of(triangulate([Well((loop, loop), levels)], top - bottom, place, flat=True))


def manifold_of(mesh: Triangles) -> Manifold:
    """manifold3d's form of a closed mesh. Raises `KernelError` when it is none."""
    import manifold3d

    made = manifold3d.Manifold(
        manifold3d.Mesh64(np.array(mesh.vertices, np.float64), np.array(mesh.faces, np.uint64))
    )
    if made.status() != manifold3d.Error.NoError:
        raise KernelError(f"the mesh is not a closed body ({made.status().name}): repair it first")
    return made


def triangles_of(manifold: Manifold) -> Triangles:
    """Triangles of a manifold."""
    mesh = manifold.to_mesh64()
    return Triangles(np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts))
