# pyright: reportAttributeAccessIssue=false
# The modeller's stubs are incomplete.
"""Perforating an imported wall: each hole is punched between exact faces; only those over an edge are cut."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
import shapely
from numpy.typing import NDArray

from perfqr_cad.errors import DesignError, KernelError
from perfqr_cad.geometry.outline import Loop
from perfqr_cad.hosts.body import Array
from perfqr_cad.hosts.lay import Laid, Projected
from perfqr_cad.hosts.motif import Motif
from perfqr_cad.hosts.probe import probe
from perfqr_cad.hosts.removed import removed_mm3
from perfqr_cad.hosts.step.face_chart import chart_between
from perfqr_cad.hosts.step.host import Host
from perfqr_cad.hosts.tool import carved_mesh, prism
from perfqr_cad.profile.recess import NoRecess
from perfqr_cad.profile.sections import Sections
from perfqr_cad.profile.walls import Walls
from perfqr_cad.profile.well import Well
from perfqr_cad.solid.charts.fitted import FIT_MM
from perfqr_cad.solid.kernel import booleans as kernel
from perfqr_cad.solid.kernel import occ
from perfqr_cad.solid.kernel.from_shape import brep_of
from perfqr_cad.solid.kernel.to_shape import KernelShape, solid_of, with_wires
from perfqr_cad.solid.proof.check import check
from perfqr_cad.solid.shape import Solid
from perfqr_cad.solid.stitch import panel

if TYPE_CHECKING:
    from OCP.TopoDS import TopoDS_Face, TopoDS_Solid, TopoDS_Wire

# Removed volume of the exact solid against the integral of the wall over the holes; both are good to 1e-5.
VOLUME_TOLERANCE = 1e-3
VOLUME_PRECISION = 1e-5  # of the changed faces, where the kernel's quick volume disagrees
MESH_VOLUME_TOLERANCE = 0.01  # the mesh strays by its chord error on both sides of the wall
SAMPLE_MM = 0.5  # along a loop, when asking which faces it lies on


def carve(host: Host, motif: Motif, laid: Laid, walls: Walls) -> Solid:
    """The host with the motif's holes in its wall; its bars are flush where they cannot lie behind the face
    (`Solid.notes`).

    Raises `DesignError` for walls that cannot be made here, `KernelError` when the result is not one
    sound solid.
    """
    host = _smooth(host, motif, laid, walls)
    try:
        if walls.depth_mm is None:
            motif = motif.fitted(host.body, laid)
        shape, notes = _barred(host, motif, laid, walls), ()
    except NoRecess as reason:
        motif = motif.flushed()
        shape, notes = _holed(host, motif, laid, walls), (str(reason),)
    kernel.reconcile(shape, host.shape, FIT_MM)
    triangles = carved_mesh(host.body, motif, laid, walls)
    lost = kernel.volume_lost(host.shape, shape)
    if walls.draft_deg == 0:
        removed, tolerance = _removed_mm3(host, motif, laid, walls), VOLUME_TOLERANCE
    else:  # flared holes are wider behind: the triangles, made without the modeller, tell
        removed, tolerance = host.body.triangles.volume_mm3 - triangles.volume_mm3, MESH_VOLUME_TOLERANCE
    if abs(lost - removed) > tolerance * removed:
        lost = kernel.volume_lost(host.shape, shape, VOLUME_PRECISION)
    problems: list[str] = []
    if abs(lost - removed) > tolerance * removed:
        problems.append(f"it lost {lost:.6g} mm³ instead of {removed:.6g} mm³")
    volume = host.volume_mm3 - lost
    if check(brep_of(shape), volume_mm3=volume) and not kernel.is_valid(shape):
        problems.append("the kernel's check fails")
    if problems:
        raise KernelError(
            f"the perforated solid is not sound ({'; '.join(problems)}): move the code a little"
        )
    return Solid(
        exact=shape,
        triangles=triangles,
        valid=True,
        solids=occ.count(shape, occ.SOLID),
        faces=occ.count(shape, occ.FACE),
        edges=occ.count(shape, occ.EDGE),
        volume_mm3=volume,
        bbox_mm=kernel.bounding_box(host.shape),
        # By the changed faces alone: see `kernel.volume_lost` for why not from the volume of the host.
        expected_volume_mm3=volume + lost - removed,
        notes=notes,
        name=host.name,
    )


def _smooth(host: Host, motif: Motif, laid: Laid, walls: Walls) -> Host:
    """The host with no seam or joint under the holes, where it can be had."""
    from perfqr_cad.hosts.step.pane import paned

    wells = motif.sections(laid.thickness_mm, walls, barred=False).wells
    if not any(_over_edges(host, wells, laid)):
        return host
    reach = max(float(np.abs(well.loops[-1].flatten()).max()) for well in wells)
    half = (reach + laid.reach_mm()) / 2  # half-way through the quiet zone
    return paned(host, laid, half, through=walls.depth_mm is None) or host


def _barred(host: Host, motif: Motif, laid: Laid, walls: Walls) -> TopoDS_Solid:
    """All holes punched between one face and another, with recessed bars. Raises `NoRecess` where there are
    more faces.
    """
    if not motif.bars:
        return _holed(host, motif, laid, walls)
    made = motif.sections(laid.thickness_mm, walls, barred=True)
    faces = set(_faces_under(host, made.wells, laid))
    if len(faces) > 1 or any(_over_edges(host, made.wells, laid)):
        raise NoRecess("the bars are flush with the face: the code runs over an edge of it")
    return _punched(host, {faces.pop(): made}, laid)


def _holed(host: Host, motif: Motif, laid: Laid, walls: Walls) -> TopoDS_Solid:
    """The holes punched between the faces they lie on; those over an edge cut before."""
    wells = motif.sections(laid.thickness_mm, walls, barred=False).wells
    over = _over_edges(host, wells, laid)
    base = host
    if any(over):
        crossing = [hole for hole, crosses in zip(motif.flush.holes, over, strict=True) if crosses]
        base = Host(host.name, _cut(host, crossing, laid, walls))
    inside = [well for well, crosses in zip(wells, over, strict=True) if not crosses]
    groups: dict[tuple[int, int], list[Well]] = defaultdict(list)
    for well, faces in zip(inside, _faces_under(base, inside, laid), strict=True):
        groups[faces].append(well)
    return _punched(base, {faces: Sections(tuple(wells)) for faces, wells in groups.items()}, laid)


def _removed_mm3(host: Host, motif: Motif, laid: Laid, walls: Walls) -> float:
    """Volume of straight holes, and of the slots before recessed bars; over pockets there are no bars."""
    holes = removed_mm3(host, motif.flush.holes, laid, walls.depth_mm)
    if not motif.bars:
        return holes
    # Rings in pockets stand on the floor: there is no bar before which to stop.
    slot_mm = motif.top_depth_mm(laid.thickness_mm) if walls.depth_mm is None else walls.depth_mm
    return holes + removed_mm3(host, motif.bar_loops(0.0), laid, slot_mm)


def _punched(host: Host, groups: Mapping[tuple[int, int], Sections], laid: Laid) -> TopoDS_Solid:
    """Sections sunk between a front and a back face (−1: floors of their own), all stitched to one shell."""
    wires: dict[int, list[tuple[TopoDS_Wire, bool]]] = defaultdict(list)
    added: list[TopoDS_Face] = []
    for (front, back), sunk in groups.items():
        reach = max(well.levels[-1].depth_mm for well in sunk.wells)
        chart = chart_between(laid, host.skins[front], host.skins[back] if back >= 0 else None, reach)
        brep = panel(sunk, chart)
        made = KernelShape(brep)
        # The first piece of the front and the back have no outline: they are holes in the host's faces.
        holes = {0: front} | {i: back for i, cap in enumerate(sunk.caps) if not cap.up}
        for number, face in holes.items():
            wires[face] += [(wire, bool(brep.outward[number])) for wire in made.wires(number)]
        added += [made.face(i) for i in range(brep.face_count) if i not in holes]
    faces = list(host.faces)
    for i, found in wires.items():
        for seen in (True, False):  # the front and the back may be one face, such as a sheet's folded round
            here = [wire for wire, outward in found if outward == seen]
            faces[i] = with_wires(faces[i], here, seen) if here else faces[i]
    return _rejoined(host, faces, added)


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
    kept = (kernel.explore(s, "FACE") for k, s in enumerate(shells) if k not in touched)
    return solid_of([*joined, *walls], *kept)


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


def _over_edges(host: Host, wells: Sequence[Well], laid: Laid) -> list[bool]:
    """Which holes have an edge of the front or (for through-holes) of the back running under them."""
    origins, frames = laid.line(np.vstack([_along(well.loops[0]) for well in wells]))
    met = probe(host.body, origins, frames[:, 2])
    numbers = [(met.front, 0.0)]
    if not any(well.floor for well in wells):
        numbers.append((met.back, laid.thickness_mm))
    lines: list[shapely.LineString] = []
    for faces, depth in numbers:
        for i in np.unique(faces[faces >= 0]):
            lines += _edges_under(host, int(i), laid, depth)
    if not lines:
        return [False] * len(wells)
    tree = shapely.STRtree(lines)
    # A flared hole is widest at its far end: the widest loop is what must be clear of edges.
    widest = [shapely.Polygon(well.loops[-1].flatten()) for well in wells]
    hit = set(tree.query(widest, predicate="intersects")[0].tolist())
    return [k in hit for k in range(len(wells))]


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
    """The places of true entries, parted where they are not consecutive."""
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
