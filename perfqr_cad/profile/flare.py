"""How far each edge of a hole may be set back towards the back of a drafted wall, so that no web gets too
thin."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import NDArray

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry.arrays import Array, Indices, Mask
from perfqr_cad.geometry.cycles import following, owners, starts_of
from perfqr_cad.geometry.offset import widened
from perfqr_cad.geometry.outline import Arc, Loop, Region, Segment
from perfqr_cad.geometry.segments import corners, pieces
from perfqr_cad.geometry.vectors import left, unit

WEB_CHORD_MM = 0.002  # curves are measured by chords this close

LEAST_WEB_MM = 1e-3  # at the back, where no minimum is asked for: holes must not touch
ROUNDS = 6  # of giving way: flares beside a web that comes out too thin are halved, in the last two dropped
# Corners of two holes that meet diagonally give way along their mitres, a little more than edges.
WEB_SLACK = 0.02
ALONG = 0.3  # sine (17°) below which a tie runs along a segment rather than away from it


class NoFlare(DesignError):
    """No edge of any hole can give way: the walls must be straight."""


@dataclass(frozen=True)
class Flared:
    """A loop at the back, and by how much its segments were to be set back for that, (k,) mm; where one would
    vanish, `widened` sets it back less."""

    loop: Loop
    set_back_mm: Array


def flared_loops(front: Sequence[Region], flare_mm: float, min_web_mm: float) -> list[Flared]:
    """Each loop but the first outline at the back, tried out: its segments set back by `flare_mm`, or by what
    the webs and short edges bear. Both sides of a web give way alike.

    Raises `NoFlare` where no edge can give way at all.
    """
    least = max(min_web_mm, LEAST_WEB_MM)
    outlines = Outlines.of(front)
    inner = outlines.loops[1:]
    # A web that is thinner at the front already cannot be asked to be wider at the back.
    webs = outlines.webs(2 * flare_mm + least)
    limits = (1 - WEB_SLACK) * np.minimum(least, webs)
    back = np.clip((webs - least) / 2, 0.0, flare_mm)
    own = [slice(a, b) for a, b in pairwise(outlines.starts[1:].tolist())]
    doubtful = np.arange(outlines.starts[1], outlines.starts[-1])
    wide = widened(inner, back[doubtful])
    for attempt in range(ROUNDS):
        found = Outlines.of(_replaced(front, wide)).webs(least, doubtful)
        thin = doubtful[found < limits[doubtful]]
        if not len(thin):
            break
        back[thin] *= 0.5 if attempt < ROUNDS - 2 else 0.0
        changed = np.unique(outlines.loop_of_segment[thin]) - 1
        doubtful = np.flatnonzero(np.isin(outlines.loop_of_segment - 1, changed))
        again = widened([inner[k] for k in changed.tolist()], back[doubtful])
        for k, loop in zip(changed.tolist(), again, strict=True):
            wide[k] = loop
    if wide == list(inner) or not Outlines.of(_replaced(front, wide)).sound:
        raise NoFlare(
            f"no hole can be flared by up to {flare_mm:.3g} mm with webs of {least:.3g} mm at the back: "
            "take a smaller draft, a longer lip, a thinner plate or larger modules"
        )
    return [Flared(loop, back[part]) for loop, part in zip(wide, own, strict=True)]


def _replaced(front: Sequence[Region], inner: Sequence[Loop]) -> list[Region]:
    """The pieces with other loops but for the first outline."""
    loops = iter((front[0].outer, *inner))
    return [Region(next(loops), tuple(next(loops) for _ in region.holes)) for region in front]


@dataclass(frozen=True, eq=False)
class Outlines:
    """The loops of a front, each outline before its holes, and chords along them.

    starts    (L + 1,) first segment of each loop, and the end
    segments  of all loops
    piece     (L,) of each loop
    """

    loops: tuple[Loop, ...]
    starts: Indices
    segments: tuple[Segment, ...]
    piece: Indices

    @staticmethod
    def of(front: Sequence[Region]) -> Outlines:
        loops = tuple(loop for region in front for loop in region.loops)
        return Outlines(
            loops,
            starts_of(len(loop.segments) for loop in loops),
            tuple(segment for loop in loops for segment in loop.segments),
            owners(starts_of(len(region.loops) for region in front)),
        )

    @property
    def loop_of_segment(self) -> Indices:
        """(k,)."""
        return owners(self.starts)

    @property
    def sound(self) -> bool:
        """Whether the loops are simple and apart."""
        return bool(shapely.is_valid(self._polygons).all())

    def webs(self, up_to_mm: float, of: Indices | None = None) -> Array:
        """Width of the material behind each of some segments (of all), at most `up_to_mm`.

        A web runs between boundaries that are no neighbours along a straight tie through the material.
        """
        chosen = np.arange(len(self.segments)) if of is None else of
        asked = np.zeros(len(self.segments), np.bool_)
        asked[chosen] = True
        tree, lines = self._tree, self._lines
        first, second = tree.query(lines[chosen], predicate="dwithin", distance=up_to_mm)
        first = chosen[first]
        once = ((first < second) | ~asked[second]) & (first != second) & ~self._neighbours(first, second)
        first, second = first[once], second[once]
        ties = shapely.get_coordinates(shapely.shortest_line(lines[first], lines[second])).reshape(-1, 2, 2)
        solid = np.zeros(len(ties), dtype=np.bool_)
        for polygon in self._polygons:
            solid |= shapely.contains_xy(polygon, *ties.mean(axis=1).T)
        tie = ties[:, 1] - ties[:, 0]
        width = np.hypot(*tie.T)
        found = np.full(len(self.segments), up_to_mm)
        for side, way in ((first, tie), (second, -tie)):
            # A tie that runs along a segment does not shrink when the segment is set back.
            across = np.einsum("ki,ki->k", way, self._left[side])
            counts = solid & (across >= ALONG * width)
            np.minimum.at(found, side[counts], width[counts])
        return found[chosen]

    @cached_property
    def _corners(self) -> tuple[Array, Indices]:
        """Corners (n, 2) of all loops, and the first of each segment, (k + 1,)."""
        counts = pieces(self.segments, WEB_CHORD_MM)
        return corners(self.segments, counts), starts_of(counts)

    @cached_property
    def _lines(self) -> NDArray[np.object_]:
        """(k,) line strings along the segments."""
        points, first = self._corners
        counts = np.diff(first) + 1
        use = owners(starts_of(counts))
        step = np.arange(len(use)) - starts_of(counts)[use]
        at = np.where(step < counts[use] - 1, first[use] + step, first[self._after[use]])
        return np.asarray(shapely.linestrings(points[at], indices=use))

    @cached_property
    def _tree(self) -> shapely.STRtree:
        return shapely.STRtree(self._lines)

    @cached_property
    def _polygons(self) -> NDArray[np.object_]:
        points, first = self._corners
        rings = shapely.linearrings(points, indices=owners(first[self.starts]))
        polygons = np.asarray(shapely.polygons(np.asarray(rings), indices=self.piece))
        shapely.prepare(polygons)
        return polygons

    @cached_property
    def _left(self) -> Array:
        """(k, 2) unit normals of the chords, into the material."""
        ends = np.array([(s.start, s.end) for s in self.segments])
        return left(unit(ends[:, 1] - ends[:, 0]))

    @cached_property
    def _after(self) -> Indices:
        """(k,) the next segment of the same loop."""
        return following(self.starts)

    def _neighbours(self, first: Indices, second: Indices) -> Mask:
        """Pairs that meet at a corner, sharp or rounded: no web lies between them."""
        after = self._after
        rounded = np.array([isinstance(s, Arc) for s in self.segments])
        beside = (after[first] == second) | (after[second] == first)
        for a, b in ((first, second), (second, first)):
            beside |= rounded[after[a]] & (after[after[a]] == b)
        return beside
