# pyright: reportAttributeAccessIssue=false
# The modeller's stubs are incomplete.
"""What is taken away: prisms for the modeller, and closed meshes for manifold3d."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import shapely

from perfqr_cad.errors import KernelError
from perfqr_cad.geometry import Triangles
from perfqr_cad.geometry.outline import Loop, Region
from perfqr_cad.hosts.body import Array, Body
from perfqr_cad.hosts.lay import Laid, Projected
from perfqr_cad.hosts.motif import Motif
from perfqr_cad.hosts.probe import probe
from perfqr_cad.hosts.removed import quadrature
from perfqr_cad.profile.walls import Walls
from perfqr_cad.profile.well import Level, Well
from perfqr_cad.solid.mesh import triangulate
from perfqr_cad.surface import Plane

if TYPE_CHECKING:
    from manifold3d import Manifold
    from OCP.TopoDS import TopoDS_Shape

SAMPLE_MM = 0.02  # chord error of the outline that feels for the wall
BITE_MM = 0.1  # how far a bar is let into what it joins: an eighth of the usual web
CLEARANCE = 0.2  # of the wall: how far tools stand out before and behind it


def prism(body: Body, hole: Loop, laid: Projected, depth_mm: float | None) -> TopoDS_Shape:
    """A straight prism over a hole, through the wall or down to a flat floor `depth_mm` below its lowest
    rim.
    """
    from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
    from OCP.gp import gp_Ax3, gp_Trsf

    from perfqr_cad.profile.sections import sections
    from perfqr_cad.solid.charts.plane import PlaneChart
    from perfqr_cad.solid.kernel.occ import direction, pnt
    from perfqr_cad.solid.kernel.to_shape import KernelShape
    from perfqr_cad.solid.stitch import panel

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
    return BRepBuilderAPI_Transform(KernelShape(block).solid(), place, True).Shape()


def carved_mesh(body: Body, motif: Motif, laid: Laid, walls: Walls) -> Triangles:
    """The body less all holes of a motif's front, its bars standing at the back of through-holes; closed and
    in as many bodies as before.

    Raises `KernelError` when manifold3d objects or something falls off, `NoRecess` where the wall is too thin
    for bars behind its face.
    """
    import manifold3d

    solid = manifold_of(body.triangles)
    wells = motif.sections(laid.thickness_mm, walls, barred=False).wells
    result = solid - manifold3d.Manifold.compose(_tools(body, _drilled(wells), laid))
    if motif.bars and walls.depth_mm is None:
        result = manifold3d.Manifold.batch_boolean(
            [result, *_bars(body, solid, motif, laid, walls)], manifold3d.OpType.Add
        )
    if result.status() != manifold3d.Error.NoError:
        raise KernelError(f"carving the mesh failed in manifold3d ({result.status().name}): move the code")
    before, after = len(solid.decompose()), len(result.decompose())
    if after > before:
        raise KernelError(
            f"carving left {after - before} loose pieces: choose a thicker place or a larger code"
        )
    return triangles_of(result)


def _drilled(wells: Sequence[Well]) -> list[list[Well]]:
    """Each hole with the outlines of the pieces that stand in it and in no hole nearer to them."""
    holes = [well for well in wells if well.loops[0].area < 0]
    areas = [shapely.Polygon(hole.loops[0].flatten()) for hole in holes]
    drilled = [[hole] for hole in holes]
    for island in wells:
        if island.loops[0].area < 0:
            continue
        at = shapely.Point(island.loops[0].segments[0].start)
        around = [k for k, area in enumerate(areas) if area.contains(at)]
        drilled[min(around, key=lambda k: areas[k].area)].append(island)
    return drilled


def _tools(body: Body, drilled: Sequence[Sequence[Well]], laid: Laid) -> list[Manifold]:
    """Each hole as a closed mesh that stands out of the wall on both sides (a pocket: only in front)."""
    holes = [hole.loops[0] for hole, *_ in drilled]
    feelers = [np.vstack([hole.flatten(SAMPLE_MM), quadrature([hole])[0]]) for hole in holes]
    lines, frames = laid.line(np.vstack(feelers))
    met = probe(body, lines, frames[:, 2])
    front = lines + met.offset_mm[:, None] * frames[:, 2]
    splits = np.cumsum([len(uv) for uv in feelers])[:-1]
    by_hole = zip(*(np.split(felt, splits) for felt in (front, met.offset_mm, met.wall_mm)), strict=True)
    return [
        _tool(wells, laid, front, offset, wall, body.faceted)
        for wells, (front, offset, wall) in zip(drilled, by_hole, strict=True)
    ]


def _tool(
    wells: Sequence[Well], laid: Laid, front: Array, offset_mm: Array, wall_mm: Array, faceted: bool
) -> Manifold:
    """One hole, from what was felt under it: front points (k, 3), their offset from the map, and the wall."""
    wall = float(np.nanmax(wall_mm))
    margin = CLEARANCE * wall
    straight = all(len(well.loops) == 2 and well.loops[0] == well.loops[1] for well in wells)
    if isinstance(laid, Projected) and straight and not wells[0].floor:
        return _straight_tool([well.loops[0] for well in wells], laid, front, wall_mm, margin)
    # A flared through-hole goes on straight from the nominal back to the far end of an uneven wall.
    proud = margin + float(np.nanmax(np.abs(offset_mm)))
    if faceted:  # the lid is as flat as its rim allows: it clears what bulges in the middle
        proud += float(np.ptp(front @ laid.frame_at_centre.axes[2]))
    beyond = 0.0 if wells[0].floor else max(0.0, wall - wells[0].levels[-1].depth_mm) + proud
    return _block(wells, laid, proud, beyond, faceted)


def _block(wells: Sequence[Well], laid: Laid, before_mm: float, beyond_mm: float, faceted: bool) -> Manifold:
    """What lies between loops, from so far before their first level to so far beyond their last."""
    depths = [level.depth_mm for level in wells[0].levels]
    columns = [list(well.loops) for well in wells]
    if before_mm and any(loops[0] != loops[1] for loops in columns):  # a flare begins at the face
        depths.insert(0, depths[0] - before_mm)
        columns = [[loops[0], *loops] for loops in columns]
    else:
        depths[0] -= before_mm
    if beyond_mm:
        depths.append(depths[-1] + beyond_mm)
        columns = [[*loops, loops[-1]] for loops in columns]
    origin = depths[0]
    levels = tuple(Level(d - origin, False) for d in depths)

    def place(uv: Array, depth_mm: float | Array) -> Array:
        return laid.at_depth(uv, depth_mm + origin)

    rims = [Well(tuple(loop.reversed() for loop in loops), levels) for loops in columns]
    return manifold_of(triangulate(rims, levels[-1].depth_mm, place, flat=faceted))


def _straight_tool(
    loops: Sequence[Loop], laid: Projected, front: Array, wall_mm: Array, margin: float
) -> Manifold:
    """A prism along the projection's axis from above the highest front to below the lowest back."""
    height = laid.frame_at_centre.to_frame(front)[:, 2]
    top, bottom = float(np.nanmax(height)) + margin, float(np.nanmin(height - wall_mm)) - margin

    def place(uv: Array, depth_mm: float | Array) -> Array:
        return laid.frame_at_centre.to_space(np.column_stack([uv, np.full(len(uv), top - depth_mm)]))

    levels = (Level(0.0, False), Level(top - bottom, False))
    rims = [Well((loop.reversed(), loop.reversed()), levels) for loop in loops]
    return manifold_of(triangulate(rims, top - bottom, place, flat=True))


def _bars(body: Body, solid: Manifold, motif: Motif, laid: Laid, walls: Walls) -> list[Manifold]:
    """The body behind the tops of the bars, let into what the bars join."""
    thickness = laid.thickness_mm
    top = motif.top_depth_mm(thickness)
    loops = motif.bar_loops(walls.flare_mm(thickness) + BITE_MM)
    lines, frames = laid.line(np.vstack([loop.flatten() for loop in loops]))
    met = probe(body, lines, frames[:, 2])
    beyond = CLEARANCE * thickness + float(np.nanmax(met.wall_mm - met.offset_mm)) - thickness
    levels = (Level(top, False), Level(thickness, False))
    # A tool is what lies to the right of its loops' travel: bars are given as holes are.
    wells = [Well((loop.reversed(), loop.reversed()), levels) for loop in loops]
    return [solid ^ _block([well], laid, 0.0, max(0.0, beyond), body.faceted) for well in wells]


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
