"""From triangles as they come to one closed body: what can be mended is, the rest is counted and refused."""

from __future__ import annotations

import numpy as np

from perfqr_cad.errors import DesignError, KernelError
from perfqr_cad.geometry import Triangles
from perfqr_cad.geometry.arrays import Array, Indices, Mask
from perfqr_cad.geometry.graph import components
from perfqr_cad.geometry.triangles import directed_edges
from perfqr_cad.hosts.body import weld
from perfqr_cad.hosts.manifold import manifold_of, triangles_of

WELD_SHARE = 1e-6  # of the diagonal: single-precision files round corners by about this
# A gap round which the rim is shorter than this share of the diagonal is filled flat; a longer one is an
# opening.
FILL_SHARE = 0.15
DUST_SHARE = 1e-6  # of the greatest body's volume: pieces below are rubbish from modelling
SHORTEST = 1e-9
PROBES = 16  # vertices that tell whether one surface lies inside another
PATCH_EDGES = 4  # rims of so few edges are a lost triangle or two
INNER = 1e-7  # of a segment or triangle: touching at ends and rims is no crossing
FLAT = 1e-12  # of the sizes involved: a segment in the plane of a triangle does not cross it
BEYOND = 1e-3  # of an edge: how far behind a hit the caster looks on


def mend(mesh: Triangles, part: int | None = None) -> Triangles:
    """One closed body: welded, without degenerate and doubled triangles, small gaps filled, faces turned
    outward, overlapping bodies united.

    `part` picks one of several separate bodies, 1 the greatest. Raises `KernelError` with counts for what
    cannot be mended (open rims, edges of three or more triangles, triangles through each other) and
    `DesignError` for several bodies of which none is chosen.
    """
    diagonal = float(np.linalg.norm(np.ptp(mesh.vertices, axis=0)))
    welded, _ = weld(mesh.vertices, mesh.faces, WELD_SHARE * diagonal)
    faces = _without_doubles(welded)
    _require_triangles(faces)
    _refuse_branches(faces)
    vertices, faces = _filled(welded.vertices, faces, FILL_SHARE * diagonal)
    _refuse_branches(faces)
    bodies = _bodies(Triangles(vertices, _consistent(faces)))
    crossing = sum(self_crossings(body) for body in bodies)
    if crossing:
        raise KernelError(
            f"the mesh cuts through itself at {crossing} edges: rebuild it as one outer surface (a "
            f"boolean union in the program it comes from) and export again"
        )
    return _one(bodies, part)


def _without_doubles(mesh: Triangles) -> Indices:
    """Triangles with distinct corner sets."""
    _, first = np.unique(np.sort(mesh.faces, axis=1), axis=0, return_index=True)
    return mesh.faces[np.sort(first)]


def _require_triangles(faces: Indices) -> None:
    """Raises `KernelError` where none are left."""
    if not len(faces):
        raise KernelError("the mesh encloses no volume: export a body, not flat sheets")


def _rims(faces: Indices) -> Indices:
    """Directed edges (k, 2) that have no partner."""
    edges = directed_edges(faces)
    _, index, counts = np.unique(np.sort(edges, axis=1), axis=0, return_index=True, return_counts=True)
    return edges[index[counts == 1]]


def _filled(vertices: Array, faces: Indices, longest_mm: float) -> tuple[Array, Indices]:
    """Small gaps closed by a fan about their middle. Raises `KernelError` listing the openings that are
    left."""
    rims = _rims(faces)
    if not len(rims):
        return vertices, faces
    loops, tangled = _loops(rims)
    lengths = [
        float(np.linalg.norm(np.diff(vertices[[*loop, loop[0]]], axis=0), axis=1).sum()) for loop in loops
    ]
    open_rims = [
        length
        for length, loop in zip(lengths, loops, strict=True)
        if length > longest_mm and len(loop) > PATCH_EDGES
    ]
    if open_rims or tangled:
        longest = max(open_rims, default=0.0)
        raise KernelError(
            f"the mesh is open: {len(rims)} edges have one triangle only, in {len(loops) + tangled} "
            f"rims, the longest "
            f"{longest:.4g} mm round (up to {longest_mm:.3g} mm or {PATCH_EDGES} edges is filled): "
            f"close it in the program it comes from"
        )
    fans = []
    for k, loop in enumerate(loops):
        ring = np.array(loop)
        fans.append(np.column_stack([np.roll(ring, -1), ring, np.full(len(ring), len(vertices) + k)]))
    middles = [vertices[loop].mean(axis=0) for loop in loops]
    return np.vstack([vertices, middles]), np.vstack([faces, *fans])


def _loops(rims: Indices) -> tuple[list[list[int]], int]:
    """Closed chains of rim edges, whichever way each edge runs; and the number of chains that branch."""
    neighbours: dict[int, list[int]] = {}
    for a, b in rims.tolist():
        neighbours.setdefault(a, []).append(b)
        neighbours.setdefault(b, []).append(a)
    tangled = sum(len(n) != 2 for n in neighbours.values())
    if tangled:
        return [], tangled
    following = dict(rims.tolist())
    loops: list[list[int]] = []
    left = set(neighbours)
    while left:
        start = min(left)
        chain, at = [start], following.get(start, neighbours[start][0])
        while at != start:
            chain.append(at)
            at = next((n for n in neighbours[at] if n != chain[-2]), start)
        left -= set(chain)
        loops.append(chain)
    return loops, 0


def _refuse_branches(faces: Indices) -> None:
    """Raises `KernelError` with the number of edges at which three triangles or more meet."""
    edges = np.sort(directed_edges(faces), axis=1)
    counts = np.unique(edges, axis=0, return_counts=True)[1]
    if (bad := int((counts > 2).sum())) > 0:
        raise KernelError(
            f"the mesh is not a surface of a body: {bad} edges have more than two triangles: remove inner "
            f"walls, fins and doubled sheets in the program it comes from"
        )


def _consistent(faces: Indices) -> Indices:
    """All triangles of each connected surface turned the same way."""
    import trimesh
    from trimesh import repair

    sheet = trimesh.Trimesh(np.zeros((int(faces.max()) + 1, 3)), faces, process=False, validate=False)
    repair.fix_winding(sheet)
    return np.asarray(sheet.faces, np.int64)


def _bodies(mesh: Triangles) -> list[Triangles]:
    """Closed bodies, greatest first, each with the cavities inside it, without dust."""
    _require_triangles(mesh.faces)
    edges = np.sort(directed_edges(mesh.faces), axis=1)
    # Every edge has two triangles by now. Surfaces that share a mere vertex stay apart.
    pairs = np.lexsort(edges.T).reshape(-1, 2) // 3
    label = components(pairs, len(mesh.faces))
    pieces = [_outward(_compact(mesh, label == k)) for k in range(int(label.max()) + 1)]
    pieces.sort(key=lambda m: -m.volume_mm3)
    solid = [p for p in pieces if p.volume_mm3 > DUST_SHARE * pieces[0].volume_mm3]
    if not solid:
        raise KernelError("the mesh encloses no volume: export a body, not a flat sheet")
    around = [[k for k, q in enumerate(solid) if q is not p and _inside(p, q)] for p in solid]
    cavities: dict[int, list[Triangles]] = {k: [] for k, outer in enumerate(around) if len(outer) % 2 == 0}
    for piece, outer in zip(solid, around, strict=True):
        if len(outer) % 2:  # greatest first: the last body around it is the tightest
            owner = max(k for k in outer if k in cavities)
            cavities[owner].append(Triangles(piece.vertices, piece.faces[:, ::-1]))
    return [solid[k].joined(*own) if own else solid[k] for k, own in cavities.items()]


def _compact(mesh: Triangles, chosen: Mask) -> Triangles:
    used, index = np.unique(mesh.faces[chosen], return_inverse=True)
    return Triangles(mesh.vertices[used], index.reshape(-1, 3))


def _outward(mesh: Triangles) -> Triangles:
    return mesh if mesh.volume_mm3 >= 0 else Triangles(mesh.vertices, mesh.faces[:, ::-1])


def _inside(inner: Triangles, outer: Triangles) -> bool:
    """Whether one closed mesh lies wholly inside another; surfaces that cross lie in none."""
    if (inner.vertices.min(axis=0) < outer.vertices.min(axis=0)).any():
        return False
    if (inner.vertices.max(axis=0) > outer.vertices.max(axis=0)).any():
        return False
    step = max(1, len(inner.vertices) // PROBES)
    return all(_winds_round(point, outer) for point in inner.vertices[::step])


def _winds_round(point: Array, mesh: Triangles) -> bool:
    """Whether a point lies inside a closed mesh: its winding number by solid angles (van Oosterom and
    Strackee)."""
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces] - point, 1, 0)
    la, lb, lc = (np.linalg.norm(x, axis=1) for x in (a, b, c))
    volume = np.einsum("ki,ki->k", a, np.cross(b, c))
    dots = (
        np.einsum("ki,ki->k", a, b) * lc + np.einsum("ki,ki->k", b, c) * la + np.einsum("ki,ki->k", c, a) * lb
    )
    return bool(abs(2 * np.arctan2(volume, la * lb * lc + dots).sum()) > 2 * np.pi)


def self_crossings(mesh: Triangles) -> int:
    """Edges that pierce a triangle they do not touch: two triangles cross exactly when an edge of one
    does."""
    import trimesh
    from trimesh.ray.ray_pyembree import RayMeshIntersector

    edges = np.unique(np.sort(directed_edges(mesh.faces), axis=1), axis=0)
    start, span = mesh.vertices[edges[:, 0]], mesh.vertices[edges[:, 1]] - mesh.vertices[edges[:, 0]]
    length = np.linalg.norm(span, axis=1)
    long = length > SHORTEST
    edges, start, span, length = edges[long], start[long], span[long], length[long]
    caster = RayMeshIntersector(trimesh.Trimesh(mesh.vertices, mesh.faces, process=False, validate=False))
    pierced = np.zeros(len(edges), bool)
    active, offset = np.arange(len(edges)), np.zeros(len(edges))
    while len(active):
        unit = span[active] / length[active, None]
        at, ray, triangle = caster.intersects_location(
            start[active] + offset[active, None] * unit, unit, multiple_hits=False
        )
        edge = active[ray]
        touching = (mesh.faces[triangle][:, :, None] == edges[edge][:, None, :]).any(axis=(1, 2))
        pierced[edge[_pierces(mesh, triangle, start[edge], span[edge]) & ~touching]] = True
        # A neighbour's triangle may hide what lies behind it: look again from just beyond the hit.
        reached = np.linalg.norm(at - start[edge], axis=1)
        offset[edge] = np.maximum(offset[edge], reached) + BEYOND * length[edge]
        active = edge[~pierced[edge] & (offset[edge] < length[edge])]
    return int(pierced.sum())


def _pierces(mesh: Triangles, triangle: Indices, start: Array, span: Array) -> Mask:
    """Whether segments cross triangles, strictly inside both.

    Möller and Trumbore in double precision; the ray caster's single precision only proposes.
    """
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces[triangle]], 1, 0)
    side_b, side_c, to = b - a, c - a, start - a
    p = np.cross(span, side_c)
    det = np.einsum("ki,ki->k", side_b, p)
    scale = np.linalg.norm(span, axis=1) * np.linalg.norm(side_b, axis=1) * np.linalg.norm(side_c, axis=1)
    flat = np.abs(det) <= FLAT * scale
    det = np.where(flat, 1.0, det)
    q = np.cross(to, side_b)
    u, v = np.einsum("ki,ki->k", to, p) / det, np.einsum("ki,ki->k", span, q) / det
    share = np.einsum("ki,ki->k", side_c, q) / det
    inside = (u > INNER) & (v > INNER) & (u + v < 1 - INNER) & (share > INNER) & (share < 1 - INNER)
    return inside & ~flat


def _one(bodies: list[Triangles], part: int | None) -> Triangles:
    """The one body: overlapping ones united, separate ones chosen by number."""
    import manifold3d

    if len(bodies) > 1:
        united = manifold3d.Manifold.batch_boolean([manifold_of(b) for b in bodies], manifold3d.OpType.Add)
        bodies = _bodies(triangles_of(united))
    if len(bodies) == 1:
        return bodies[0]
    sizes = ", ".join(f"{b.volume_mm3:.4g}" for b in bodies[:5]) + (", …" if len(bodies) > 5 else "")
    if part is None:
        raise DesignError(
            f"the mesh has {len(bodies)} separate bodies ({sizes} mm³): choose part=1 to {len(bodies)}"
        )
    if not 1 <= part <= len(bodies):
        raise DesignError(f"no part {part}: the mesh has {len(bodies)} separate bodies, 1 the greatest")
    return bodies[part - 1]
