"""Perforating an imported wall: each hole is punched between exact faces; only those over an edge are cut."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
import shapely
from numpy.typing import NDArray

from perfqr_cad.errors import DesignError, KernelError
from perfqr_cad.geometry.arrays import Array, Mask
from perfqr_cad.geometry.outline import Loop
from perfqr_cad.hosts.cutters import carved_mesh
from perfqr_cad.hosts.host_placement import HostPlacement, Projected
from perfqr_cad.hosts.host_profile import bar_loops, with_fitted_bars
from perfqr_cad.hosts.probe import probe
from perfqr_cad.hosts.removed_volume import removed_volume_mm3
from perfqr_cad.hosts.step.face_chart import chart_between
from perfqr_cad.hosts.step.host import Host
from perfqr_cad.hosts.step.prism import prism
from perfqr_cad.profile import Profile, Walls
from perfqr_cad.profile.loft import Loft
from perfqr_cad.profile.recess import NoRecess, top_depth_mm
from perfqr_cad.profile.sections import Sections
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


def carve(host: Host, profile: Profile, placement: HostPlacement, walls: Walls) -> Solid:
    """The host with the profile's holes in its wall; its bars are flush where they cannot lie behind the face
    (`Solid.notes`).

    Raises `DesignError` for walls that cannot be made here, `KernelError` when the result is not one
    sound solid.
    """
    host = _smooth(host, profile, placement, walls)
    try:
        if walls.depth_mm is None:
            profile = with_fitted_bars(profile, host.body, placement)
        shape, notes = _barred(host, profile, placement, walls), ()
    except NoRecess as reason:
        profile = profile.with_flush_bars()
        shape, notes = _holed(host, profile, placement, walls), (str(reason),)
    kernel.reconcile(shape, host.shape, FIT_MM)
    triangles = carved_mesh(host.body, profile, placement, walls)
    lost = kernel.volume_lost(host.shape, shape)
    if walls.draft_deg == 0:
        removed, tolerance = _removed_volume_mm3(host, profile, placement, walls), VOLUME_TOLERANCE
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


def _smooth(host: Host, profile: Profile, placement: HostPlacement, walls: Walls) -> Host:
    """The host with no seam or joint under the holes, where it can be had."""
    from perfqr_cad.hosts.step.unify import unified

    lofts = profile.without_bars().sections(placement.thickness_mm, walls, rim=False).lofts
    if not any(_over_edges(host, lofts, placement)):
        return host
    reach = max(float(np.abs(loft.loops[-1].flatten()).max()) for loft in lofts)
    half = (reach + placement.reach_mm()) / 2  # half-way through the quiet zone
    return unified(host, placement, half, through=walls.depth_mm is None) or host


def _barred(host: Host, profile: Profile, placement: HostPlacement, walls: Walls) -> TopoDS_Solid:
    """All holes punched between one face and another, with recessed bars. Raises `NoRecess` where there are
    more faces."""
    if not profile.bars:
        return _holed(host, profile, placement, walls)
    made = profile.sections(placement.thickness_mm, walls, rim=False)
    faces = set(_faces_under(host, made.lofts, placement))
    if len(faces) > 1 or any(_over_edges(host, made.lofts, placement)):
        raise NoRecess("the bars are flush with the face: the code runs over an edge of it")
    return _punched(host, {faces.pop(): made}, placement)


def _holed(host: Host, profile: Profile, placement: HostPlacement, walls: Walls) -> TopoDS_Solid:
    """The holes punched between the faces they lie on; those over an edge cut before."""
    lofts = profile.without_bars().sections(placement.thickness_mm, walls, rim=False).lofts
    over = _over_edges(host, lofts, placement)
    base = host
    if any(over):
        crossing = [
            hole
            for hole, crosses in zip(profile.with_flush_bars().front[0].holes, over, strict=True)
            if crosses
        ]
        base = Host(host.name, _cut(host, crossing, placement, walls))
    inside = [loft for loft, crosses in zip(lofts, over, strict=True) if not crosses]
    groups: dict[tuple[int, int], list[Loft]] = defaultdict(list)
    for loft, faces in zip(inside, _faces_under(base, inside, placement), strict=True):
        groups[faces].append(loft)
    return _punched(base, {faces: Sections(tuple(lofts)) for faces, lofts in groups.items()}, placement)


def _removed_volume_mm3(host: Host, profile: Profile, placement: HostPlacement, walls: Walls) -> float:
    """Volume of straight holes, and of the slots before recessed bars; over pockets there are no bars."""
    holes = removed_volume_mm3(host, profile.with_flush_bars().front[0].holes, placement, walls.depth_mm)
    if not profile.bars:
        return holes
    # Rings in pockets stand on the floor: there is no bar before which to stop.
    slot_mm = top_depth_mm(profile.bars, placement.thickness_mm) if walls.depth_mm is None else walls.depth_mm
    return holes + removed_volume_mm3(host, bar_loops(profile.bars), placement, slot_mm)


def _punched(
    host: Host, groups: Mapping[tuple[int, int], Sections], placement: HostPlacement
) -> TopoDS_Solid:
    """Sections sunk between a front and a back face (−1: floors of their own), all stitched to one shell."""
    wires: dict[int, list[tuple[TopoDS_Wire, bool]]] = defaultdict(list)
    added: list[TopoDS_Face] = []
    for (front, back), sunk in groups.items():
        reach = max(loft.levels[-1].depth_mm for loft in sunk.lofts)
        chart = chart_between(
            placement, host.exact_faces[front], host.exact_faces[back] if back >= 0 else None, reach
        )
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
    own."""
    shells = kernel.explore(host.shape, "SHELL")
    if len(shells) == 1:
        return solid_of([*faces, *walls])
    owner = {i: s for s, shell in enumerate(shells) for i in kernel.places_of(host.faces, shell)}
    touched = {owner[i] for i, face in enumerate(faces) if not face.IsSame(host.faces[i])}
    joined = [face for i, face in enumerate(faces) if owner[i] in touched]
    kept = (kernel.explore(s, "FACE") for k, s in enumerate(shells) if k not in touched)
    return solid_of([*joined, *walls], *kept)


def _faces_under(host: Host, lofts: Sequence[Loft], placement: HostPlacement) -> list[tuple[int, int]]:
    """Numbers of the front and back face (−1 for a pocket) that each loft runs between."""
    samples = [_along(loft.loops[0]) for loft in lofts]
    origins, frames = placement.line(np.vstack(samples))
    met = probe(host.body, origins, frames[:, 2])
    splits = np.cumsum([len(s) for s in samples])[:-1]
    found: list[tuple[int, int]] = []
    for loft, front, back in zip(lofts, np.split(met.front, splits), np.split(met.back, splits), strict=True):
        found.append((_commonest(front), -1 if loft.floor else _commonest(back)))
    return found


def _commonest(numbers: NDArray[np.int64]) -> int:
    """The face most samples lie on; others are rounding next to an edge, as edges are kept clear of."""
    values, counts = np.unique(numbers[numbers >= 0], return_counts=True)
    if not len(values):
        raise KernelError("no wall was found under a hole: move the code")
    return int(values[counts.argmax()])


def _over_edges(host: Host, lofts: Sequence[Loft], placement: HostPlacement) -> list[bool]:
    """Which holes have an edge of the front or (for through-holes) of the back running under them."""
    origins, frames = placement.line(np.vstack([_along(loft.loops[0]) for loft in lofts]))
    met = probe(host.body, origins, frames[:, 2])
    numbers = [(met.front, 0.0)]
    if not any(loft.floor for loft in lofts):
        numbers.append((met.back, placement.thickness_mm))
    lines: list[shapely.LineString] = []
    for faces, depth in numbers:
        for i in np.unique(faces[faces >= 0]):
            lines += _edges_under(host, int(i), placement, depth)
    if not lines:
        return [False] * len(lofts)
    tree = shapely.STRtree(lines)
    # A flared hole is widest at its far end: the widest loop is what must be clear of edges.
    widest = [shapely.Polygon(loft.loops[-1].flatten()) for loft in lofts]
    hit = set(tree.query(widest, predicate="intersects")[0].tolist())
    return [k in hit for k in range(len(lofts))]


def _edges_under(
    host: Host, face: int, placement: HostPlacement, depth_mm: float
) -> list[shapely.LineString]:
    """The face's edges in pattern coordinates, as far as they lie on the wall under the code."""
    found: list[shapely.LineString] = []
    for points in kernel.edge_points(host.faces[face], SAMPLE_MM):
        uv = placement.pattern_points(points)
        near = np.isfinite(uv[:, 0])
        expected = placement.at_depth(np.where(near[:, None], uv, 0.0), depth_mm)
        near &= np.linalg.norm(points - expected, axis=1) < placement.thickness_mm / 2
        near &= np.abs(uv).max(axis=1) < placement.reach_mm()
        found += [shapely.LineString(uv[run]) for run in _runs(near) if len(run) > 1]
    return found


def _runs(mask: Mask) -> list[NDArray[np.int64]]:
    """The places of true entries, parted where they are not consecutive."""
    index = np.flatnonzero(mask)
    return np.split(index, np.flatnonzero(np.diff(index) > 1) + 1) if len(index) else []


def _along(loop: Loop) -> Array:
    """Points (k, 2) along a loop, none farther than the sampling step apart."""
    corners = loop.flatten()
    ring = shapely.segmentize(shapely.LinearRing(corners), SAMPLE_MM)
    return shapely.get_coordinates(ring)[:-1]


def _cut(host: Host, holes: Sequence[Loop], placement: HostPlacement, walls: Walls) -> TopoDS_Solid:
    """The few holes that lie over an edge, by one boolean."""
    if walls.draft_deg > 0:
        raise DesignError("flared walls over an edge of the face are not made: move the code or set draft 0")
    if not isinstance(placement, Projected):
        raise DesignError("a wrapped code may not run over an edge of the face: project it, or move it")
    cutters = [prism(host.body, hole, placement, walls.depth_mm) for hole in holes]
    return kernel.cut(host.shape, cutters)
