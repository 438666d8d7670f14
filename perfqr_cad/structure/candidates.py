"""Where a structural bridge could go: straight bars across one hole, from light to light."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry import Polygon

from perfqr_cad.pattern import Bridge
from perfqr_cad.structure.t6 import Floats, Ints
from perfqr_cad.symbol import ReadabilityTracker, layout
from perfqr_cad.symbol.layout import Role

if TYPE_CHECKING:
    from perfqr_cad.pattern import Pattern

LINES_PER_MODULE = 2  # bars run along module edges and module centres
LONGEST_MODULES = 4.0
DIAGONAL_STEP_MODULES = 1.0
AT_WALL_MM = 1e-6
CENTRE_SAMPLES = 5  # a side, over the centre third of a module: where decoders look (§4.2)
LIGHTENED = 0.5  # share of a module's centre that a bar must cover to turn it light
# Bars across their rings blind most decoders, whatever Eqs. (1)-(3) say of them (they count data only).
KEPT_CLEAR = (Role.FINDER, Role.ALIGNMENT)


@dataclass(frozen=True)
class Candidates:
    """Bars by rows: `start`, `end` (k, 2) on the light boundary, `width_mm` (k,).

    `loss` (k,) is the rise of L(Q), `covered` (k,) how many dark module centres a bar lightens, as a sum of
    shares.
    """

    start: Floats
    end: Floats
    width_mm: Floats
    loss: Floats
    covered: Floats

    def __len__(self) -> int:
        return len(self.start)

    @property
    def length_mm(self) -> Floats:
        """Lengths (k,)."""
        return np.linalg.norm(self.end - self.start, axis=1)

    def take(self, which: NDArray[np.int64] | NDArray[np.bool_]) -> Candidates:
        """The rows chosen."""
        return Candidates(
            self.start[which], self.end[which], self.width_mm[which], self.loss[which], self.covered[which]
        )

    def bridge(self, row: int, cost: float) -> Bridge:
        """One row as a structural bridge."""
        (x0, y0), (x1, y1) = self.start[row].tolist(), self.end[row].tolist()
        return Bridge((x0, y0), (x1, y1), float(self.width_mm[row]), "structural", cost)


def lattice_candidates(pattern: Pattern, widths_mm: tuple[float, ...]) -> Candidates:
    """Upright and diagonal bars along the lattice that keep the least gap to both sides, all affordable."""
    holes = holes_of(pattern.polygon)
    found = [_across(pattern, holes, width) for width in widths_mm]
    start, end, width = (np.concatenate([part[k] for part in found]) for k in range(3))
    return affordable(pattern, start, end, width)


def holes_of(polygon: Polygon) -> NDArray[np.object_]:
    """The holes of a region as polygons."""
    return np.array([Polygon(ring) for ring in polygon.interiors], dtype=object)


def affordable(pattern: Pattern, start: Floats, end: Floats, width: Floats) -> Candidates:
    """The bars that leave L(Q) finite and touch no finder or alignment ring, with their losses."""
    if not len(start):
        return Candidates(start, end, width, width, width)
    tracker = ReadabilityTracker(pattern.symbol, pattern.observed)
    today = tracker.total
    dark = pattern.observed.dark
    roles = layout(pattern.symbol.version, pattern.symbol.level).roles
    forbidden = np.isin(roles, KEPT_CLEAR) & pattern.symbol.matrix.dark
    modules, share, touched = coverage(pattern, start, end, width)
    rows, columns = modules[..., 0], modules[..., 1]
    barred = (forbidden[rows, columns] & touched).any(axis=1)
    flips = (share >= LIGHTENED) & dark[rows, columns]
    loss = np.where(barred, np.inf, 0.0)
    for k in np.flatnonzero(flips.any(axis=1) & ~barred):
        loss[k] = tracker.preview(map(tuple, modules[k, flips[k]].tolist())) - today
    kept = np.isfinite(loss)
    covered = (share * dark[rows, columns]).sum(axis=1)
    return Candidates(start[kept], end[kept], width[kept], loss[kept], covered[kept])


def coverage(
    pattern: Pattern, start: Floats, end: Floats, width: Floats
) -> tuple[Ints, Floats, NDArray[np.bool_]]:
    """What k bars cover of the modules near them.

    Returns rows and columns of the modules (k, w, 2), the share of each one's centre that the bar covers
    (k, w), and whether it enters the module at all (k, w).
    """
    n, m = pattern.symbol.size, pattern.module_mm
    low = (np.minimum(start, end) - width[:, None] / 2) / m + n / 2
    high = (np.maximum(start, end) + width[:, None] / 2) / m + n / 2
    first = np.floor(low).astype(np.int64)
    window = np.arange(int((np.floor(high) - first).max(initial=0)) + 1)
    x = first[:, 0, None, None] + window[None, None, :]
    y = first[:, 1, None, None] + window[None, :, None]
    modules = np.stack(np.broadcast_arrays(n - 1 - y, x), axis=-1).reshape(len(start), -1, 2)
    outside = ((modules < 0) | (modules >= n)).any(axis=2)
    centres = np.stack([modules[..., 1] + 0.5 - n / 2, n / 2 - modules[..., 0] - 0.5], axis=-1) * m
    share = _inside(centres, m / 3, start, end, width).mean(axis=2)
    touched = _inside(centres, m, start, end, width).any(axis=2)
    return np.clip(modules, 0, n - 1), np.where(outside, 0.0, share), np.asarray(touched & ~outside)


def _inside(centres: Floats, edge: float, start: Floats, end: Floats, width: Floats) -> NDArray[np.bool_]:
    """Which samples of squares about the centres (k, w, 2) each bar covers: (k, w, samples)."""
    steps = ((np.arange(CENTRE_SAMPLES) + 0.5) / CENTRE_SAMPLES - 0.5) * edge
    grid = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    length = np.linalg.norm(end - start, axis=1)[:, None, None]
    along = (end - start) / length[:, 0]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    offset = centres - start[:, None]
    # Position along and across the bar: that of the centre plus that of the sample.
    s = np.einsum("kwc,kc->kw", offset, along)[..., None] + (along @ grid.T)[:, None]
    t = np.einsum("kwc,kc->kw", offset, across)[..., None] + (across @ grid.T)[:, None]
    return (s >= 0) & (s <= length) & (np.abs(t) <= width[:, None, None] / 2)


def _across(pattern: Pattern, holes: NDArray[np.object_], width: float) -> tuple[Floats, Floats, Floats]:
    """Bars of one width along lattice lines, each across one hole."""
    clear = width / 2 + pattern.spec.gap_mm
    # A centre line inside the shrunken hole keeps the bar clear of the walls beside it.
    shrunk = shapely.buffer(holes, -clear, join_style="mitre")
    lines = _lattice_lines(pattern)
    tree = shapely.STRtree(lines)
    of_hole, of_line = tree.query(shrunk, predicate="intersects")
    pieces = shapely.get_parts(shapely.intersection(lines[of_line], shrunk[of_hole]), return_index=True)
    segments, source = pieces
    is_line = shapely.get_type_id(segments) == shapely.GeometryType.LINESTRING
    segments, hole = segments[is_line], holes[of_hole[source[is_line]]]
    if not len(segments):
        return np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0)
    ends = shapely.get_coordinates(shapely.get_point(segments, [[0], [-1]])).reshape(2, -1, 2)
    return _reaching_walls(ends[0], ends[1], hole, width, LONGEST_MODULES * pattern.module_mm)


def _lattice_lines(pattern: Pattern) -> NDArray[np.object_]:
    m, n = pattern.module_mm, pattern.symbol.size
    half = n * m / 2
    at = (np.arange(n * LINES_PER_MODULE + 1) / LINES_PER_MODULE - n / 2) * m
    upright = [[(x, -half), (x, half)] for x in at] + [[(-half, y), (half, y)] for y in at]
    shift = np.arange(-n, n + DIAGONAL_STEP_MODULES, DIAGONAL_STEP_MODULES) * m
    rising = [[(-half, -half + s), (half, half + s)] for s in shift]
    falling = [[(-half, half + s), (half, -half + s)] for s in shift]
    return np.asarray(shapely.linestrings(np.array(upright + rising + falling)), dtype=object)


def _reaching_walls(
    a: Floats, b: Floats, hole: NDArray[np.object_], width: float, longest: float
) -> tuple[Floats, Floats, Floats]:
    """Centre lines drawn out at both ends until they meet the wall of their hole; long ones are dropped."""
    length = np.linalg.norm(b - a, axis=1)
    worth = (length > 1e-6) & (length < longest)
    a, b, hole, length = a[worth], b[worth], hole[worth], length[worth]
    along = (b - a) / length[:, None]
    reach = longest - length[:, None]  # a wall may lie well beyond the clearance in a rounded corner
    drawn = shapely.linestrings(np.stack([a - reach * along, b + reach * along], axis=1))
    inside = shapely.intersection(drawn, hole)
    single = shapely.get_type_id(inside) == shapely.GeometryType.LINESTRING
    ends = shapely.get_coordinates(shapely.get_point(inside[single], [[0], [-1]])).reshape(2, -1, 2)
    # A line that still ends inside its hole has met no wall.
    short = np.linalg.norm(ends[1] - ends[0], axis=1) < longest
    for end in ends:
        short &= (
            np.asarray(shapely.distance(shapely.points(end), shapely.boundary(hole[single]))) < AT_WALL_MM
        )
    return ends[0][short], ends[1][short], np.full(int(short.sum()), width)
