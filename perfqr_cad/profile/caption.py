"""A line of text on the frame below the code, raised or engraved: letters are loops like any others.

Outlines come from the font as they are, lines and Béziers; no boolean is made.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING

import numpy as np
import shapely

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry.outline import LEAST_MM, Bezier, Line, Loop, Point, Region, Segment
from perfqr_cad.profile.loft import Level, Loft
from perfqr_cad.profile.sections import Sections

if TYPE_CHECKING:
    from matplotlib.font_manager import FontProperties

    from perfqr_cad.pattern import Pattern

FONT = "DejaVu Sans"  # comes with matplotlib: the same outlines on every machine
LEAST_FLOOR_MM = 0.4  # behind an engraved letter: two printed layers
MOVE, LINE, QUADRATIC, CUBIC, CLOSE = 1, 2, 3, 4, 79  # matplotlib's path codes


@dataclass(frozen=True)
class Caption:
    """Text on the frame.

    height_mm  of a capital letter
    relief_mm  how far letters stand out of the face; below 0: how deep they are engraved
    font       a family that is installed, or the path of a font file; None: a plain sans serif
    """

    text: str
    height_mm: float
    relief_mm: float = 0.4
    font: str | None = None

    def __post_init__(self) -> None:
        if not self.text.strip() or "\n" in self.text:
            raise DesignError(f"caption {self.text!r} is no line of text: give one with letters")
        if not (math.isfinite(self.height_mm) and self.height_mm > 0):
            raise DesignError(f"letters of {self.height_mm:g} mm: give a height above 0")
        if not (math.isfinite(self.relief_mm) and self.relief_mm):
            raise DesignError(
                f"a relief of {self.relief_mm:g} mm: above 0 letters are raised, below engraved"
            )

    def letters(self) -> tuple[Region, ...]:
        """Outlines of the letters, mm, the line centred on the origin."""
        contours = _contours(self.text, self.height_mm, self.font)
        corners = np.vstack([loop.flatten() for loop in contours])
        middle = (corners[:, 0].min() + corners[:, 0].max()) / 2
        return _regions([_moved(loop, -middle, -self.height_mm / 2) for loop in contours])

    def below(self, pattern: Pattern, thickness_mm: float) -> tuple[Region, ...]:
        """The letters in the middle of the frame below the code. Raises `DesignError` where they do not
        fit."""
        surround = pattern.spec.surround
        web = pattern.spec.web_mm
        letters = self.letters()
        low, high = (f(axis=0) for f in (_corners(letters).min, _corners(letters).max))
        strip = surround.frame_mm - web
        if high[1] - low[1] > strip:
            raise DesignError(
                f"letters {high[1] - low[1]:.3g} mm high do not fit a frame of {surround.frame_mm:g} mm with "
                f"{web:g} mm beside them: take --frame {high[1] - low[1] + web:.3g} or smaller letters"
            )
        if thickness_mm + min(self.relief_mm, 0.0) < LEAST_FLOOR_MM:
            raise DesignError(
                f"letters engraved by {-self.relief_mm:g} mm leave less than {LEAST_FLOOR_MM:g} mm of a wall "
                f"of {thickness_mm:g} mm: engrave {max(thickness_mm - LEAST_FLOOR_MM, 0):g} mm at most"
            )
        # Descenders share the strip: the line is centred by its outlines, not by its capitals.
        centre = -(pattern.size_mm + strip) / 2 - (high[1] + low[1]) / 2
        placed = tuple(_shifted(letter, 0.0, centre) for letter in letters)
        _check(placed, pattern, web)
        return placed


def lettered(sections: Sections, letters: Sequence[Region], relief_mm: float) -> Sections:
    """The part with letters on the first piece of its front."""
    known = [loft.floor for loft in sections.lofts]
    number, piece = max(known, default=0), sections.pieces
    lofts: list[Loft] = []
    for letter in letters:
        number += 1
        for k, loop in enumerate(letter.loops):
            # A letter's own outline ends on the whole front; what it encloses is a piece of its own.
            at = 0 if k == 0 else piece
            piece += k > 0
            if relief_mm > 0:
                levels = Level(-relief_mm, True), Level(0.0, True)
                lofts.append(Loft((loop, loop), levels, boss=number, piece=at))
            else:
                levels = Level(0.0, True), Level(-relief_mm, True)
                hole = loop.reversed()
                lofts.append(Loft((hole, hole), levels, floor=number, piece=at))
    return replace(sections, lofts=(*sections.lofts, *lofts), pieces=piece)


def _check(letters: Sequence[Region], pattern: Pattern, web_mm: float) -> None:
    """Letters lie on the frame, a web away from its edge and from mounting holes."""
    text = shapely.MultiPoint(_corners(letters))
    body = pattern.front[0]
    rim = shapely.Polygon(body.outer.flatten())
    gap = rim.exterior.distance(text) if rim.covers(text) else 0.0
    for hole in pattern.spec.surround.all_holes(pattern.size_mm):
        at = shapely.Point(hole.x_mm, hole.y_mm)
        gap = min(gap, text.convex_hull.distance(at) - hole.diameter_mm / 2)
    if gap < web_mm * (1 - 1e-6) / 2:
        width = float(np.ptp(_corners(letters)[:, 0]))
        raise DesignError(
            f"a caption {width:.3g} mm wide comes within {max(gap, 0):.3g} mm of the edge or a mounting hole "
            f"(limit {web_mm / 2:g} mm): take a shorter text, smaller letters or a wider --frame"
        )


def _contours(text: str, height_mm: float, font: str | None) -> list[Loop]:
    """Closed outlines of a text whose capitals are so high; baseline at y = 0."""
    from matplotlib.textpath import TextPath

    face = _font(font)
    capital = TextPath((0, 0), "H", size=100, prop=face).vertices[:, 1].max()
    path = TextPath((0, 0), text, size=100 * height_mm / capital, prop=face)
    loops: list[Loop] = []
    segments: list[Segment] = []
    here = start = (0.0, 0.0)
    for points, code in path.iter_segments(curves=True, simplify=False):
        p: list[Point] = [(float(x), float(y)) for x, y in np.asarray(points).reshape(-1, 2)]
        if code == MOVE:
            here = start = p[0]
            continue
        drawn = _segment(here, [start] if code == CLOSE else p, int(code))
        if math.dist(drawn.start, drawn.end) > LEAST_MM:
            segments.append(drawn)
            here = drawn.end
        if code == CLOSE and segments:
            loops.append(Loop((*segments[:-1], _ending(segments[-1], start))))
            segments = []
    return loops


def _segment(start: Point, p: list[Point], code: int) -> Segment:
    """A line, or a curve as a cubic."""
    if code in (LINE, CLOSE):
        return Line(start, p[-1])
    if code == CUBIC:
        return Bezier(start, p[0], p[1], p[2])

    def lifted(a: Point, b: Point) -> Point:
        return a[0] + 2 / 3 * (b[0] - a[0]), a[1] + 2 / 3 * (b[1] - a[1])

    return Bezier(start, lifted(start, p[0]), lifted(p[1], p[0]), p[1])


def _ending(segment: Segment, end: Point) -> Segment:
    """The segment, its end moved by rounding onto a point."""
    return replace(segment, end=end)  # pyright: ignore[reportCallIssue] - the last of a contour is no circle


def _font(font: str | None) -> FontProperties:
    from matplotlib.font_manager import FontProperties, fontManager

    if font is None:
        return FontProperties(family=FONT)
    if FilePath(font).is_file():
        return FontProperties(fname=font)
    if font not in {entry.name for entry in fontManager.ttflist}:
        raise DesignError(f"font {font!r} is not installed: name another, or give the path of a font file")
    return FontProperties(family=font)


def _regions(contours: Sequence[Loop]) -> tuple[Region, ...]:
    """Letters from their contours: what lies at odd depth is open. Contours that cross are united."""
    polygons = [shapely.Polygon(loop.flatten()) for loop in contours]
    if any(not p.is_valid for p in polygons) or any(
        a.boundary.crosses(b.boundary) for i, a in enumerate(polygons) for b in polygons[:i]
    ):
        united = shapely.union_all([p.buffer(0) for p in polygons])
        return tuple(Region.from_polygon(p) for p in shapely.get_parts(united))
    inside = [[k for k, q in enumerate(polygons) if k != i and q.contains(p)] for i, p in enumerate(polygons)]
    found: list[Region] = []
    for i, around in enumerate(inside):
        if len(around) % 2:
            continue
        counters = [k for k, rows in enumerate(inside) if i in rows and len(rows) == len(around) + 1]
        found.append(
            Region(contours[i].oriented(ccw=True), tuple(contours[k].oriented(ccw=False) for k in counters))
        )
    return tuple(found)


def _corners(letters: Sequence[Region]) -> np.ndarray:
    return np.vstack([letter.outer.flatten() for letter in letters])


def _shifted(region: Region, dx: float, dy: float) -> Region:
    return Region(_moved(region.outer, dx, dy), tuple(_moved(hole, dx, dy) for hole in region.holes))


def _moved(loop: Loop, dx: float, dy: float) -> Loop:
    """The loop, of lines and Béziers, shifted."""

    def at(p: Point) -> Point:
        return p[0] + dx, p[1] + dy

    def moved(segment: Segment) -> Segment:
        if isinstance(segment, Bezier):
            return Bezier(*(at(p) for p in segment.controls))
        return Line(at(segment.start), at(segment.end))

    return Loop(tuple(moved(segment) for segment in loop.segments))
