"""The volume of a solid from its own faces, in time linear in their edges.

3 V = ∮ p · dA. Through a plane that is its height over the origin times the area of the face, which is half
of ∮ p × dp along its edges. On other surfaces dA = p_u × p_v du dv and ∫∫ f du dv = −∮ H du along the images
of the edges, with ∂H/∂v = f = p · (p_u × p_v): on cylinders and cones H is a polynomial of v, on the
modeller's surfaces a fine table. Spline patches that fill their surface take Gauss nodes across it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache, partial
from typing import TYPE_CHECKING, cast

import numpy as np

from perfqr_cad.geometry.arrays import Array, Indices, Mask
from perfqr_cad.geometry.cycles import numbering
from perfqr_cad.geometry.segments import quarters
from perfqr_cad.solid.proof.expected import gauss
from perfqr_cad.solid.tables.batches import (
    Arcs,
    Cones,
    Curves,
    Lines,
    Planes,
    Splines,
    SplineSurfaces,
    Surfaces,
)
from perfqr_cad.solid.tables.brep import Batch, Brep

if TYPE_CHECKING:
    from perfqr_cad.solid.kernel.modelled import ModelledSurfaces

NODES = 8  # of the Gauss rule along an edge or its piece, exact to degree 15
MODELLED_PANELS = 8  # of a curve of the modeller, whose spans are not known here
BOX_PANELS = 2  # each way across a spline patch
BOX_SLACK = 1e-9  # share of its parameters by which an outline may miss a border
SIDES = 4  # of a spline patch
TABLE = 161  # grid lines of H over the outlines: a quarter of a module, or less
RUN = 1 / 32  # of the outlines' extent, which a panel of an image on a table may run across

QUARTER = np.array([math.pi / 2, math.inf])  # of a turn, which a panel of an image on a cone may run across

# H at parameters (m, q, 2) on m of the surfaces, (m, q).
Moment = Callable[[Indices, Array], Array]


def volume_mm3(brep: Brep) -> float:
    """Volume of a closed solid; negative when it is inside out, NaN where a spline patch is not filled."""
    origin = brep.points[0]  # near by: rounding stays small
    return (_by_edges(brep, origin) + sum(_through(brep, faces, origin) for faces in brep.surfaces)) / 3


def _through(brep: Brep, faces: Batch[Surfaces], origin: Array) -> float:
    """The flux of p − origin out of some faces; planes are left to `_by_edges`."""
    match faces.of:
        case Planes():
            return 0.0
        case Cones() as cones:
            return _by_images(brep, faces.rows, partial(_cone_moment, cones, origin), QUARTER)
        case SplineSurfaces() as patches:
            return _by_patches(brep, faces.rows, patches, origin)
        case surfaces:
            return _by_tables(brep, faces.rows, cast("ModelledSurfaces", surfaces), origin)


def _by_edges(brep: Brep, origin: Array) -> float:
    """Through planes: height times area."""
    height, normal = np.zeros(brep.face_count), np.zeros((brep.face_count, 3))
    for faces in brep.surfaces:
        if isinstance(faces.of, Planes):
            normal[faces.rows] = faces.of.normal
            height[faces.rows] = np.einsum("ki,ki->k", faces.of.origin - origin, faces.of.normal)
    swept = np.zeros((len(brep.ends), 3))  # ½ ∫ (p − origin) × dp along each edge
    for batch in brep.curves:
        node, weight = _rule(*_breaks(batch.of))
        point, slope = batch.of.at(node)
        swept[batch.rows] = np.einsum("q,kqi->ki", weight, _cross(point - origin, slope)) / 2
    face = brep.face_of_use
    area = np.einsum("ki,ki->k", swept[brep.edges], normal[face])
    return float(np.sum(_ways(brep.ahead) * height[face] * area))


def _by_images(brep: Brep, faces: Indices, moment: Moment, run: Array) -> float:
    """−∮ H du around some faces; `run`: the extent (2,) that a panel may run across."""
    surface = numbering(brep.face_count, faces)[brep.face_of_use]
    total = 0.0
    for batch in brep.images:
        rows = np.flatnonzero(surface[batch.rows] >= 0)
        if not len(rows):
            continue
        images, uses = batch.of[rows], batch.rows[rows]
        breaks, least = _breaks(images)
        panels = least * _panels(images, run)
        for count in np.flatnonzero(np.bincount(panels)).tolist():
            chosen = np.flatnonzero(panels == count)
            node, weight = _rule(breaks, count)
            uv, slope = images[chosen].at(node)
            falls = (moment(surface[uses[chosen]], uv) * slope[..., 0]) @ weight
            total -= float(falls @ _ways(brep.ahead[uses[chosen]]))
    return total


def _cone_moment(cones: Cones, origin: Array, which: Indices, uv: Array) -> Array:
    """H on cylinders and cones: f = (r + v sin a) (cos a (q · ray + r) − sin a q · axis), q the origin's."""
    off = cones.origin - origin
    along_x, along_y, along_axis = (
        np.einsum("ki,ki->k", off, d)[which][:, None] for d in (cones.x, cones.y, cones.axis)
    )
    radius, sin, cos = (a[which][:, None] for a in (cones.radius, np.sin(cones.angle), np.cos(cones.angle)))
    u, v = uv[..., 0], uv[..., 1]
    outwards = cos * (along_x * np.cos(u) + along_y * np.sin(u) + radius) - sin * along_axis
    return (radius + v * sin / 2) * v * outwards


def _by_patches(brep: Brep, faces: Indices, patches: SplineSurfaces, origin: Array) -> float:
    """Through whole spline patches: Gauss nodes across their parameters."""
    if not filled(brep, faces, patches).all():
        return math.nan
    (u0, v0), (u1, v1) = patches.domain
    node, weight = gauss(NODES, BOX_PANELS)
    point, along_u, along_v = patches.grid(u0 + node * (u1 - u0), v0 + node * (v1 - v0))
    density = np.einsum("kuvi,kuvi->kuv", point - origin, _cross(along_u, along_v))
    flux = np.einsum("kuv,u,v->k", density, weight, weight) * (u1 - u0) * (v1 - v0)
    return float(flux @ np.where(brep.outward[faces], 1.0, -1.0))


def filled(brep: Brep, faces: Indices, patches: SplineSurfaces) -> Array:
    """Whether the outline of each face is the four borders of its spline, as of walls ruled between edges."""
    low, high = patches.domain
    slack = BOX_SLACK * (high - low)
    face = brep.face_of_use
    borders = np.zeros(brep.face_count, np.int64)
    for batch in brep.images:
        uv, _ = batch.of.at(np.array([0.0, 0.5, 1.0]))
        off = np.minimum(np.abs(uv - low), np.abs(uv - high)).max(axis=1)
        np.add.at(borders, face[batch.rows], np.any(off <= slack, axis=1))
    uses = np.bincount(face, minlength=brep.face_count)
    return ((borders == SIDES) & (uses == SIDES))[faces]


def _by_tables(brep: Brep, faces: Indices, surfaces: ModelledSurfaces, origin: Array) -> float:
    """Through the modeller's surfaces: a table of H for each, over the outlines of all its faces."""
    from scipy.interpolate import RectBivariateSpline, make_interp_spline

    total = 0.0
    for surface, on in surfaces.distinct():
        low, high = _extent(brep, faces[on])
        u, v = np.linspace(low[0], high[0], TABLE), np.linspace(low[1], high[1], TABLE)
        grid = np.stack(np.meshgrid(u, v, indexing="ij"), axis=-1).reshape(-1, 2)
        point, along_u, along_v = surface(grid, 3)
        density = np.einsum("ki,ki->k", point - origin, _cross(along_u, along_v)).reshape(TABLE, TABLE)
        rising = make_interp_spline(v, density, axis=1).antiderivative()(v)
        table = RectBivariateSpline(u, v, rising, s=0)

        def moment(_: Indices, uv: Array, table: RectBivariateSpline = table) -> Array:
            return table.ev(uv[..., 0], uv[..., 1])

        total += _by_images(brep, faces[on], moment, (high - low) * RUN)
    return total


def _extent(brep: Brep, faces: Indices) -> tuple[Array, Array]:
    """Least and greatest parameters (2,) of the outlines of some faces, and a little more."""
    chosen = np.isin(brep.face_of_use, faces)
    seen = [
        batch.of[np.flatnonzero(chosen[batch.rows])].at(np.linspace(0, 1, NODES))[0].reshape(-1, 2)
        for batch in brep.images
    ]
    points = np.concatenate(seen)
    low, high = points.min(axis=0), points.max(axis=0)
    return low - RUN * (high - low), high + RUN * (high - low)  # edges bulge between their samples


def _panels(images: Curves, run: Array) -> Indices:
    """In how many panels each smooth piece of an image is to be integrated, (k,)."""
    ends, _ = images.at(np.array([0.0, 1.0]))
    return np.ceil((np.abs(ends[:, 1] - ends[:, 0]) / run).max(axis=1, initial=1.0)).astype(np.int64)


def _breaks(curves: Curves) -> tuple[tuple[float, ...], int]:
    """Fractions between which curves of a kind are smooth, and panels that each piece takes."""
    if isinstance(curves, Splines):
        return tuple(sorted(set(curves.knots))), 1
    if isinstance(curves, Arcs):
        return (0.0, 1.0), int(quarters(curves.sweep).max(initial=1))
    return (0.0, 1.0), 1 if isinstance(curves, Lines) else MODELLED_PANELS


@lru_cache(maxsize=256)
def _rule(breaks: tuple[float, ...], panels: int) -> tuple[Array, Array]:
    """Nodes and weights from 0 to 1, so many panels between one break and the next."""
    node, weight = gauss(NODES, panels)
    start, size = np.array(breaks[:-1])[:, None], np.diff(breaks)[:, None]
    return (start + node * size).ravel(), (weight * size).ravel()


def _ways(ahead: Mask) -> Array:
    """1 for uses along their edge, −1 for others."""
    return np.where(ahead, 1.0, -1.0)


def _cross(a: Array, b: Array) -> Array:
    """As `numpy.cross` of (…, 3), in a third of the time."""
    (x, y, z), (u, v, w) = (np.moveaxis(p, -1, 0) for p in (a, b))
    return np.stack([y * w - z * v, z * u - x * w, x * v - y * u], axis=-1)
