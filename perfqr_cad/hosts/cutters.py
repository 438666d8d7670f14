"""Cutters: closed meshes that manifold3d takes away from a body, and the bars that it puts back."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import shapely

from perfqr_cad.errors import KernelError
from perfqr_cad.geometry import Triangles
from perfqr_cad.geometry.arrays import Array
from perfqr_cad.geometry.outline import Loop
from perfqr_cad.hosts.body import Body
from perfqr_cad.hosts.host_placement import HostPlacement, Projected
from perfqr_cad.hosts.host_profile import bar_loops
from perfqr_cad.hosts.manifold import manifold_of, triangles_of
from perfqr_cad.hosts.probe import probe
from perfqr_cad.hosts.removed_volume import quadrature
from perfqr_cad.profile import Profile, Walls
from perfqr_cad.profile.loft import Level, Loft
from perfqr_cad.profile.recess import top_depth_mm
from perfqr_cad.solid.mesh import triangulate

if TYPE_CHECKING:
    from manifold3d import Manifold

SAMPLE_MM = 0.02  # chord error of the outline along which the wall is probed
BITE_MM = 0.1  # how far a bar is let into what it joins: an eighth of the usual web
CLEARANCE = 0.2  # of the wall: how far cutters stand out before and behind it


def carved_mesh(body: Body, profile: Profile, placement: HostPlacement, walls: Walls) -> Triangles:
    """The body less all holes of a profile, its bars at the back of through-holes; closed and in as many
    bodies as before.

    Raises `KernelError` when manifold3d objects or something falls off, `NoRecess` where the wall is too thin
    for bars behind its face.
    """
    import manifold3d

    solid = manifold_of(body.triangles)
    lofts = profile.without_bars().sections(placement.thickness_mm, walls, rim=False).lofts
    result = solid - manifold3d.Manifold.compose(_cutters(body, _drilled(lofts), placement))
    if profile.bars and walls.depth_mm is None:
        result = manifold3d.Manifold.batch_boolean(
            [result, *_bars(body, solid, profile, placement, walls)], manifold3d.OpType.Add
        )
    if result.status() != manifold3d.Error.NoError:
        raise KernelError(f"carving the mesh failed in manifold3d ({result.status().name}): move the code")
    before, after = len(solid.decompose()), len(result.decompose())
    if after > before:
        raise KernelError(
            f"carving left {after - before} loose pieces: choose a thicker place or a larger code"
        )
    return triangles_of(result)


def _drilled(lofts: Sequence[Loft]) -> list[list[Loft]]:
    """Each hole with the outlines of the pieces that stand in it and in no hole nearer to them."""
    holes = [loft for loft in lofts if loft.loops[0].area < 0]
    areas = [shapely.Polygon(hole.loops[0].flatten()) for hole in holes]
    drilled = [[hole] for hole in holes]
    for island in lofts:
        if island.loops[0].area < 0:
            continue
        at = shapely.Point(island.loops[0].segments[0].start)
        around = [k for k, area in enumerate(areas) if area.contains(at)]
        drilled[min(around, key=lambda k: areas[k].area)].append(island)
    return drilled


def _cutters(body: Body, drilled: Sequence[Sequence[Loft]], placement: HostPlacement) -> list[Manifold]:
    """Each hole as a closed mesh that stands out of the wall on both sides (a pocket: only in front)."""
    holes = [hole.loops[0] for hole, *_ in drilled]
    probed = [np.vstack([hole.flatten(SAMPLE_MM), quadrature([hole])[0]]) for hole in holes]
    lines, frames = placement.line(np.vstack(probed))
    met = probe(body, lines, frames[:, 2])
    front = lines + met.offset_mm[:, None] * frames[:, 2]
    splits = np.cumsum([len(uv) for uv in probed])[:-1]
    by_hole = zip(
        *(np.split(met_there, splits) for met_there in (front, met.offset_mm, met.wall_mm)), strict=True
    )
    return [
        _cutter(lofts, placement, front, offset, wall, body.faceted)
        for lofts, (front, offset, wall) in zip(drilled, by_hole, strict=True)
    ]


def _cutter(
    lofts: Sequence[Loft],
    placement: HostPlacement,
    front: Array,
    offset_mm: Array,
    wall_mm: Array,
    faceted: bool,
) -> Manifold:
    """One hole, from what was met under it: front points (k, 3), their offset from the map, and the wall."""
    wall = float(np.nanmax(wall_mm))
    margin = CLEARANCE * wall
    straight = all(len(loft.loops) == 2 and loft.loops[0] == loft.loops[1] for loft in lofts)
    if isinstance(placement, Projected) and straight and not lofts[0].floor:
        return _straight_cutter([loft.loops[0] for loft in lofts], placement, front, wall_mm, margin)
    # A flared through-hole goes on straight from the nominal back to the far end of an uneven wall.
    before = margin + float(np.nanmax(np.abs(offset_mm)))
    if faceted:  # the lid is as flat as its rim allows: it clears what bulges in the middle
        before += float(np.ptp(front @ placement.frame_at_centre.axes[2]))
    beyond = 0.0 if lofts[0].floor else max(0.0, wall - lofts[0].levels[-1].depth_mm) + before
    return _block(lofts, placement, before, beyond, faceted)


def _block(
    lofts: Sequence[Loft], placement: HostPlacement, before_mm: float, beyond_mm: float, faceted: bool
) -> Manifold:
    """What lies between loops, from so far before their first level to so far beyond their last."""
    depths = [level.depth_mm for level in lofts[0].levels]
    columns = [list(loft.loops) for loft in lofts]
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
        return placement.at_depth(uv, depth_mm + origin)

    rims = [Loft(tuple(loop.reversed() for loop in loops), levels) for loops in columns]
    return manifold_of(triangulate(rims, levels[-1].depth_mm, place, flat=faceted))


def _straight_cutter(
    loops: Sequence[Loop], placement: Projected, front: Array, wall_mm: Array, margin: float
) -> Manifold:
    """A prism along the projection's axis from above the highest front to below the lowest back."""
    height = placement.frame_at_centre.to_frame(front)[:, 2]
    top, bottom = float(np.nanmax(height)) + margin, float(np.nanmin(height - wall_mm)) - margin

    def place(uv: Array, depth_mm: float | Array) -> Array:
        return placement.frame_at_centre.to_space(np.column_stack([uv, np.full(len(uv), top - depth_mm)]))

    levels = (Level(0.0, False), Level(top - bottom, False))
    rims = [Loft((loop.reversed(), loop.reversed()), levels) for loop in loops]
    return manifold_of(triangulate(rims, top - bottom, place, flat=True))


def _bars(
    body: Body, solid: Manifold, profile: Profile, placement: HostPlacement, walls: Walls
) -> list[Manifold]:
    """The body behind the tops of the bars, let into what the bars join."""
    thickness = placement.thickness_mm
    top = top_depth_mm(profile.bars, thickness)
    loops = bar_loops(profile.bars, walls.flare_mm(thickness) + BITE_MM)
    lines, frames = placement.line(np.vstack([loop.flatten() for loop in loops]))
    met = probe(body, lines, frames[:, 2])
    beyond = CLEARANCE * thickness + float(np.nanmax(met.wall_mm - met.offset_mm)) - thickness
    levels = (Level(top, False), Level(thickness, False))
    # A cutter is what lies to the right of its loops' travel: bars are given as holes are.
    lofts = [Loft((loop.reversed(), loop.reversed()), levels) for loop in loops]
    return [solid ^ _block([loft], placement, 0.0, max(0.0, beyond), body.faceted) for loft in lofts]
