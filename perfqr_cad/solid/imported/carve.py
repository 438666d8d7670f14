# pyright: reportAttributeAccessIssue=false
# The modeller's stubs are incomplete.
"""Perforating an imported wall: each hole is punched between exact faces; only those over an edge are cut."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import shapely
from numpy.typing import NDArray

from perfqr_cad.errors import DesignError, KernelError
from perfqr_cad.pattern.outline import Loop, Region
from perfqr_cad.solid import occ
from perfqr_cad.solid.fitted import FIT_MM
from perfqr_cad.solid.imported import kernel
from perfqr_cad.solid.imported.body import Array
from perfqr_cad.solid.imported.face_chart import chart_between
from perfqr_cad.solid.imported.host import Host
from perfqr_cad.solid.imported.lay import Laid, Projected
from perfqr_cad.solid.imported.probe import probe
from perfqr_cad.solid.imported.removed import removed_mm3
from perfqr_cad.solid.imported.tool import carved_mesh, prism
from perfqr_cad.solid.proof import check
from perfqr_cad.solid.punch import perforated, solid_of
from perfqr_cad.solid.sections import Well, hole_wells
from perfqr_cad.solid.shape import Solid
from perfqr_cad.solid.tube import Tube, tubes
from perfqr_cad.solid.walls import Walls

if TYPE_CHECKING:
    from OCP.TopoDS import TopoDS_Face, TopoDS_Solid

# Removed volume of the exact solid against the integral of the wall over the holes; both are good to 1e-5.
VOLUME_TOLERANCE = 1e-3
MESH_VOLUME_TOLERANCE = 0.03  # the mesh strays by its chord error on both sides of the wall
SAMPLE_MM = 0.5  # along a loop, when asking which faces it lies on


def carve(host: Host, region: Region, laid: Laid, walls: Walls, min_web_mm: float = 0.0) -> Solid:
    """The host with the region's holes in its wall.

    Raises `DesignError` for walls that cannot be made here, `KernelError` when the result is not one
    sound solid.
    """
    wells = hole_wells(region.holes, laid.thickness_mm, walls, False, min_web_mm=min_web_mm)
    sinking = list(zip(region.holes, wells, strict=True))
    crossing = [
        hole for (hole, _), over in zip(sinking, _over_edges(host, sinking, laid), strict=True) if over
    ]
    base = host
    if crossing:
        base = Host(host.name, _cut(host, crossing, laid, walls))
    shape = _punched(base, [well for hole, well in sinking if hole not in crossing], laid)
    triangles = carved_mesh(host.body, wells, laid)
    lost = kernel.volume_lost(host.shape, shape)
    if walls.draft_deg == 0:
        removed, tolerance = removed_mm3(host, region.holes, laid, walls.depth_mm), VOLUME_TOLERANCE
    else:  # flared holes are wider behind: the triangles, made without the modeller, tell
        removed, tolerance = host.body.triangles.volume_mm3 - triangles.volume_mm3, MESH_VOLUME_TOLERANCE
    problems: list[str] = []
    if abs(lost - removed) > tolerance * removed:
        problems.append(f"it lost {lost:.6g} mm³ instead of {removed:.6g} mm³")
    volume = kernel.volume(host.shape) - lost
    if not _is_valid(shape, host, volume):
        problems.append("the kernel's check fails")
    if problems:
        raise KernelError(
            f"the perforated solid is not sound ({'; '.join(problems)}): move the code a little"
        )
    return Solid(
        shape=shape,
        triangles=triangles,
        valid=True,
        solids=occ.count(shape, occ.SOLID),
        faces=occ.count(shape, occ.FACE),
        edges=occ.count(shape, occ.EDGE),
        volume_mm3=volume,
        bbox_mm=kernel.bounding_box(host.shape),
        # By the changed faces alone: see `kernel.volume_lost` for why not from the volume of the host.
        expected_volume_mm3=volume + lost - removed,
        name=host.name,
    )


def _is_valid(shape: TopoDS_Solid, host: Host, volume_mm3: float) -> bool:
    """The proof in linear time, where it can be given; else the kernel's check, with a second chance with
    edges brought in step."""
    if not check(shape, volume_mm3=volume_mm3) or kernel.is_valid(shape):
        return True
    kernel.reconcile(shape, host.shape, FIT_MM)
    return kernel.is_valid(shape)


def _punched(host: Host, wells: Sequence[Well], laid: Laid) -> TopoDS_Solid:
    """Wells sunk between the faces they lie on, all faces stitched to one shell."""
    groups: dict[tuple[int, int], list[Well]] = defaultdict(list)
    for well, faces in zip(wells, _faces_under(host, wells, laid), strict=True):
        groups[faces].append(well)
    mouths: dict[int, list[tuple[Tube, bool]]] = defaultdict(list)
    feet: dict[int, list[tuple[Tube, bool]]] = defaultdict(list)
    walls: list[TopoDS_Face] = []
    for (front, back), members in groups.items():
        reach = members[0].levels[-1].depth_mm
        chart = chart_between(laid, host.skins[front], host.skins[back] if back >= 0 else None, reach)
        for made in tubes(tuple(members), chart):
            mouths[front].append((made, chart.towards_reader(0.0)))
            if back >= 0:
                feet[back].append((made, chart.towards_reader(reach)))
            walls += made.faces
    faces = []
    for i, face in enumerate(host.faces):
        for wires, end in ((mouths[i], "mouth"), (feet[i], "foot")):
            if wires:
                face = perforated(face, [getattr(tube, end) for tube, _ in wires], wires[0][1])
        faces.append(face)
    return _rejoined(host, faces, walls)


def _rejoined(host: Host, faces: list[TopoDS_Face], walls: list[TopoDS_Face]) -> TopoDS_Solid:
    """The solid of the given faces: shells that the holes join become one, other voids stay shells of their
    own.
    """
    shells = kernel.explore(host.shape, "SHELL")
    if len(shells) == 1:
        return solid_of([*faces, *walls])
    owner = {i: s for s, shell in enumerate(shells) for i in kernel.places_of(host.faces, shell)}
    touched = {owner[i] for i, face in enumerate(faces) if not face.IsSame(host.faces[i])}
    joined = [face for i, face in enumerate(faces) if owner[i] in touched]
    return kernel.solid_with_voids([*joined, *walls], [s for k, s in enumerate(shells) if k not in touched])


def _faces_under(host: Host, wells: Sequence[Well], laid: Laid) -> list[tuple[int, int]]:
    """Numbers of the front and back face (−1 for a pocket) that each well runs between."""
    samples = [_along(well.loops[0]) for well in wells]
    origins, frames = laid.line(np.vstack(samples))
    met = probe(host.body, origins, frames[:, 2])
    splits = np.cumsum([len(s) for s in samples])[:-1]
    found: list[tuple[int, int]] = []
    for well, front, back in zip(wells, np.split(met.front, splits), np.split(met.back, splits), strict=True):
        found.append((_commonest(front), -1 if well.floor else _commonest(back)))
    return found


def _commonest(numbers: NDArray[np.int64]) -> int:
    """The face most samples lie on; others are rounding next to an edge, as edges are kept clear of."""
    values, counts = np.unique(numbers[numbers >= 0], return_counts=True)
    if not len(values):
        raise KernelError("no wall was found under a hole: move the code")
    return int(values[counts.argmax()])


def _over_edges(host: Host, sinking: Sequence[tuple[Loop, Well]], laid: Laid) -> list[bool]:
    """Which holes have an edge of the front or (for through-holes) of the back running under them."""
    origins, frames = laid.line(np.vstack([_along(hole) for hole, _ in sinking]))
    met = probe(host.body, origins, frames[:, 2])
    numbers = [(met.front, 0.0)]
    if not sinking[0][1].floor:
        numbers.append((met.back, laid.thickness_mm))
    lines: list[shapely.LineString] = []
    for faces, depth in numbers:
        for i in np.unique(faces[faces >= 0]):
            lines += _edges_under(host, int(i), laid, depth)
    if not lines:
        return [False] * len(sinking)
    tree = shapely.STRtree(lines)
    # A flared hole is widest at its far end: the widest loop is what must be clear of edges.
    widest = [shapely.Polygon(well.loops[-1].flatten()) for _, well in sinking]
    hit = set(tree.query(widest, predicate="intersects")[0].tolist())
    return [k in hit for k in range(len(sinking))]


def _edges_under(host: Host, face: int, laid: Laid, depth_mm: float) -> list[shapely.LineString]:
    """The face's edges in pattern coordinates, as far as they lie on the wall under the code."""
    found: list[shapely.LineString] = []
    for points in kernel.edge_points(host.faces[face], SAMPLE_MM):
        uv = laid.unlaid(points)
        near = np.isfinite(uv[:, 0])
        expected = laid.at_depth(np.where(near[:, None], uv, 0.0), depth_mm)
        near &= np.linalg.norm(points - expected, axis=1) < laid.thickness_mm / 2
        near &= np.abs(uv).max(axis=1) < laid.reach_mm()
        found += [shapely.LineString(uv[run]) for run in _runs(near) if len(run) > 1]
    return found


def _runs(mask: NDArray[np.bool_]) -> list[NDArray[np.int64]]:
    """Index runs of consecutive true entries, each stretched by nothing."""
    index = np.flatnonzero(mask)
    return np.split(index, np.flatnonzero(np.diff(index) > 1) + 1) if len(index) else []


def _along(loop: Loop) -> Array:
    """Points (k, 2) along a loop, none farther than the sampling step apart."""
    corners = loop.flatten()
    ring = shapely.segmentize(shapely.LinearRing(corners), SAMPLE_MM)
    return shapely.get_coordinates(ring)[:-1]


def _cut(host: Host, holes: Sequence[Loop], laid: Laid, walls: Walls) -> TopoDS_Solid:
    """The few holes that lie over an edge, by one boolean."""
    if walls.draft_deg > 0:
        raise DesignError("flared walls over an edge of the face are not made: move the code or set draft 0")
    if not isinstance(laid, Projected):
        raise DesignError("a wrapped code may not run over an edge of the face: project it, or move it")
    tools = [prism(host.body, hole, laid, walls.depth_mm) for hole in holes]
    return kernel.cut(host.shape, tools)
