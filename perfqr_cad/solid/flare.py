"""How far each edge of a hole may be set back towards the back of a drafted wall, so that no web gets too
thin."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from perfqr_cad.errors import DesignError
from perfqr_cad.pattern.outline import Arc, Loop, Region, Segment

from .offset import widened
from .sampling import Array, Indices

WEB_CHORD_MM = 0.002  # curves are measured by chords this close

LEAST_WEB_MM = 1e-3  # at the back, where no minimum is asked for: holes must not touch
HALVINGS = 6  # of the flares beside a web that comes out too thin
# Corners of two holes that meet diagonally give way along their mitres, a little more than edges.
WEB_SLACK = 0.02
ALONG = 0.3  # sine (17°) below which a tie runs along a segment rather than away from it


def settled(pieces: Sequence[Region], flare_mm: float, min_web_mm: float) -> list[Array]:
    """For each loop but the first outline, the set-back of each of its segments at the back, tried out:
    `flare_mm`, or what the webs and short edges bear.

    Raises `DesignError` where no edge can give way at all.
    """
    least = max(min_web_mm, LEAST_WEB_MM)
    inner = [loop for region in pieces for loop in region.loops][1:]
    front = webs(pieces, least)
    back = flares(pieces, flare_mm, least)
    wide = [widened(loop, set_back) for loop, set_back in zip(inner, back, strict=True)]
    for attempt in range(HALVINGS):
        found = webs(_replaced(pieces, wide), least)
        # A web that is thinner at the front already cannot be asked to be wider at the back.
        thin = [f < (1 - WEB_SLACK) * np.minimum(least, g) for f, g in zip(found, front, strict=True)]
        if not any(t.any() for t in thin):
            break
        share = 0.5 if attempt < HALVINGS - 2 else 0.0
        for k in [k for k, t in enumerate(thin) if t.any()]:
            back[k] = np.where(thin[k], share * back[k], back[k])
            wide[k] = widened(inner[k], back[k])
    sound = all(region.polygon().is_valid for region in _replaced(pieces, wide))
    if wide == inner or not sound:
        raise DesignError(
            f"no hole can be flared by up to {flare_mm:.3g} mm with webs of {least:.3g} mm at the back: "
            "take a smaller draft, a longer lip, a thinner plate or larger modules"
        )
    return back


def _replaced(pieces: Sequence[Region], inner: Sequence[Loop]) -> list[Region]:
    """The pieces with other loops but for the first outline."""
    loops = iter((pieces[0].outer, *inner))
    return [Region(next(loops), tuple(next(loops) for _ in region.holes)) for region in pieces]


def flares(pieces: Sequence[Region], flare_mm: float, min_web_mm: float) -> list[Array]:
    """For each inner loop, the set-back of each of its segments: `flare_mm`, or less where a web would fall
    below `min_web_mm` at the back. Both sides of a web give way alike; one already that thin stays as it is.
    """
    behind = webs(pieces, 2 * flare_mm + min_web_mm)
    return [np.clip((web - min_web_mm) / 2, 0.0, flare_mm) for web in behind]


def webs(pieces: Sequence[Region], up_to_mm: float) -> list[Array]:
    """For each loop of a front but its first outline, the width of the material behind each of its segments,
    at most `up_to_mm`.

    A web runs between boundaries that are no neighbours along a straight tie through the material.
    """
    loops = [loop for region in pieces for loop in region.loops]
    widths = _webs(pieces, [s for loop in loops for s in loop.segments], up_to_mm)
    starts = np.cumsum([len(loop.segments) for loop in loops])
    return np.split(widths, starts[:-1])[1:]


def _webs(pieces: Sequence[Region], segments: Sequence[Segment], up_to_mm: float) -> Array:
    """Width of the material behind each segment, (k,), at most `up_to_mm`."""
    lines = np.array([shapely.LineString([*s.flatten(WEB_CHORD_MM), s.end]) for s in segments])
    first, second = shapely.STRtree(lines).query(lines, predicate="dwithin", distance=up_to_mm)
    once = (first < second) & ~_neighbours(pieces, segments, first, second)
    first, second = first[once], second[once]
    ties = shapely.get_coordinates(shapely.shortest_line(lines[first], lines[second])).reshape(-1, 2, 2)
    middle = ties.mean(axis=1)
    solid = np.zeros(len(middle), dtype=np.bool_)
    for region in pieces:
        polygon = region.polygon(WEB_CHORD_MM)
        shapely.prepare(polygon)
        solid |= shapely.contains_xy(polygon, middle[:, 0], middle[:, 1])
    tie = ties[:, 1] - ties[:, 0]
    width = np.linalg.norm(tie, axis=1)
    ahead = np.array([np.subtract(s.end, s.start) for s in segments])
    left = np.column_stack([-ahead[:, 1], ahead[:, 0]])
    found = np.full(len(segments), up_to_mm)
    for side, way in ((first, tie), (second, -tie)):
        # A tie that runs along a segment does not shrink when the segment is set back.
        across = np.einsum("ki,ki->k", way, left[side])
        counts = solid & (across >= ALONG * width * np.linalg.norm(left[side], axis=1))
        np.minimum.at(found, side[counts], width[counts])
    return found


def _neighbours(
    pieces: Sequence[Region], segments: Sequence[Segment], first: Indices, second: Indices
) -> NDArray[np.bool_]:
    """Pairs that meet at a corner, sharp or rounded: no web lies between them."""
    loops = [loop for region in pieces for loop in region.loops]
    after = np.concatenate([_successors(loop, start) for loop, start in _starts(loops)])
    rounded = np.array([isinstance(s, Arc) for s in segments])
    beside = (after[first] == second) | (after[second] == first)
    for a, b in ((first, second), (second, first)):
        beside |= rounded[after[a]] & (after[after[a]] == b)
    return beside


def _starts(loops: Sequence[Loop]) -> list[tuple[Loop, int]]:
    starts = np.concatenate([[0], np.cumsum([len(loop.segments) for loop in loops])])
    return list(zip(loops, starts.tolist(), strict=False))


def _successors(loop: Loop, start: int) -> Indices:
    return start + (np.arange(len(loop.segments)) + 1) % len(loop.segments)
