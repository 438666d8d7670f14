"""Text as outlines: lines in the order in which they are read, shaped by the font, drawn as regions."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import groupby

import numpy as np
from bidi import get_display
from fontTools.unicodedata import script as script_of

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry.graph import components
from perfqr_cad.geometry.outline import Bezier, Line, Loop, Point, Points, Region, Segment
from perfqr_cad.geometry.winding import near, united
from perfqr_cad.profile.typeface import Glyph, Typeface, typeface, with_letters
from perfqr_cad.remedy import Remedy

MOST_SEGMENTS = 100_000  # of all letters: what a solid of some minutes has
# Characters that are not seen but choose letter forms or directions: zero width non-joiner and joiner,
# left-to-right, right-to-left and Arabic letter mark. Others have no place on a part.
ALLOWED = "\u200c\u200d\u200e\u200f\u061c"
# A nonspacing mark that is not seen. By rule W1 of the bidirectional algorithm it goes with the letter
# before it.
MARK = "\U000e01ef"
SEPARATORS = ("ES", "CS")  # a mark behind them would part the number that they stand in (rule W4)
NO_SCRIPT = ("Zyyy", "Zinh", "Zzzz")  # common to several, inherited, unknown

Placed = tuple[int, float, float]  # number of a glyph in its font, and where its origin lies, font units


@dataclass(frozen=True)
class Extent:
    """Ink of a text about its middle, in heights of its capitals."""

    width: float
    low: float
    high: float

    @property
    def height(self) -> float:
        return self.high - self.low

    @property
    def middle(self) -> float:
        return (self.low + self.high) / 2


@lru_cache(maxsize=32)
def drawn(text: str, height_mm: float, font: str | None = None) -> tuple[Region, ...]:
    """Letters of a text whose capitals are `height_mm` high, mm; its lines are centred about the origin.

    font  the name of an installed font, or a font's file; None: the one that comes with this program

    Regions are apart: letters that overlap or touch are one. Raises `DesignError` for a text that is too
    long, has control characters, draws nothing, or has letters that the font lacks.
    """
    face = typeface(font)
    scale = height_mm / face.capital
    outlines: dict[int, tuple[Region, ...]] = {}
    letters: list[Region] = []
    for number, x, y in _set(text, font):
        if number not in outlines:
            loops = [moved(loop, scale, 0.0, 0.0) for loop in face.outline(number)]
            outlines[number] = united(loops)
        letters += [moved_region(region, 1.0, scale * x, scale * y) for region in outlines[number]]
    return _apart(letters)


@lru_cache(maxsize=32)
def extent(text: str, font: str | None = None) -> Extent:
    """How much room a text takes; otherwise as `drawn`."""
    face = typeface(font)
    corners = _corners(face, _set(text, font)) / face.capital
    (left, low), (right, high) = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
    return Extent(right - left, low, high)


def moved(loop: Loop, scale: float, dx: float, dy: float) -> Loop:
    """A loop of lines and Béziers, scaled about the origin and then shifted."""

    def at(p: Point) -> Point:
        return scale * p[0] + dx, scale * p[1] + dy

    def one(segment: Segment) -> Segment:
        if isinstance(segment, Bezier):
            return Bezier(*(at(p) for p in segment.controls))
        return Line(at(segment.start), at(segment.end))

    return Loop(tuple(one(segment) for segment in loop.segments))


def moved_region(region: Region, scale: float, dx: float, dy: float) -> Region:
    """The same for a region."""
    outer, *holes = (moved(loop, scale, dx, dy) for loop in region.loops)
    return Region(outer, tuple(holes))


@lru_cache(maxsize=32)
def _set(text: str, font: str | None) -> tuple[Placed, ...]:
    """Glyphs with ink and their origins, font units, the lines centred about the origin."""
    lines = _lines(text)
    face = typeface(font)
    placed: list[Placed] = []
    segments = 0
    for row, line in enumerate(lines):
        glyphs = _line(line, face)
        if not glyphs:
            continue
        ends = _corners(face, glyphs)[:, 0]
        middle = float(ends.min() + ends.max()) / 2
        baseline = ((len(lines) - 1) / 2 - row) * face.pitch - face.capital / 2
        placed += [(number, x - middle, y + baseline) for number, x, y in glyphs]
        segments += sum(len(loop.segments) for number, _, _ in glyphs for loop in face.outline(number))
    if not placed:
        raise DesignError(f"caption {text!r} draws nothing: give one with letters")
    if segments > MOST_SEGMENTS:
        raise DesignError(
            f"letters of {face.name} with {segments} segments in all (limit {MOST_SEGMENTS}): "
            "take a plainer font or a shorter text"
        )
    return tuple(placed)


def _lines(text: str) -> list[str]:
    """The lines of a text that can be set."""
    lines = [line.strip(" ") for line in text.replace("\r\n", "\n").split("\n")]
    for letter in "".join(lines):
        if unicodedata.category(letter) in ("Cc", "Cf", "Cs", "Zl", "Zp") and letter not in ALLOWED:
            name = unicodedata.name(letter, "without a name").lower()
            raise DesignError(
                f"a caption with the control character U+{ord(letter):04X}, {name}: leave it out"
            )
    return lines


def _line(line: str, face: Typeface) -> list[Placed]:
    """Glyphs with ink of a line and their origins; its baseline begins at the origin."""
    placed: list[Placed] = []
    pen = 0.0
    for text, leftward in _directed(line):
        runs = list(_of_one_script(text))
        for script, run in reversed(runs) if leftward else runs:
            glyphs, length = face.shaped(run, script, leftward)
            _require_shapes(run, glyphs, line, face)
            placed += [(g.number, pen + g.x, g.y) for g in glyphs if face.outline(g.number)]
            pen += length
    return placed


def _directed(line: str) -> Iterator[tuple[str, bool]]:
    """The runs of a line from left to right: each as it is spelt, and whether it is read leftward.

    The bidirectional algorithm (Unicode Annex 9) comes from a library that gives the letters as they stand,
    but not which of them were reversed. A mark after each letter tells: it comes to stand before the letter
    where the line runs leftward.
    """
    line = line.replace(MARK, "")
    marked = "".join(c if unicodedata.bidirectional(c) in SEPARATORS else c + MARK for c in line)
    steps: list[tuple[str, bool]] = []
    shown = iter(str(get_display(marked)))
    for letter in shown:
        if letter == MARK:
            steps.append((next(shown), True))
        elif unicodedata.bidirectional(letter) in SEPARATORS:
            steps.append((letter, False))
        else:
            next(shown)
            steps.append((letter, False))
    for leftward, run in groupby(steps, key=lambda step: step[1]):
        text = "".join(letter for letter, _ in run)
        yield text[::-1] if leftward else text, leftward


def _of_one_script(text: str) -> Iterator[tuple[str, str]]:
    """The parts of a run that are of one script (ISO 15924), after it; what has none joins its neighbour."""
    scripts = [script_of(letter) for letter in text]
    last = next((script for script in scripts if script not in NO_SCRIPT), "Zyyy")
    for i, script in enumerate(scripts):
        last = scripts[i] = last if script in NO_SCRIPT else script
    for script, letters in groupby(zip(scripts, text, strict=True), key=lambda pair: pair[0]):
        yield script, "".join(letter for _, letter in letters)


def _require_shapes(run: str, glyphs: Sequence[Glyph], line: str, face: Typeface) -> None:
    """Every letter that is seen has a glyph, and that has an outline, which those of coloured emoji lack."""
    inked = {glyph.letter for glyph in glyphs if face.outline(glyph.number)}
    for glyph in glyphs:
        letter = run[glyph.letter]
        if not glyph.number:  # which of the letters that go together is missing
            letter = next((c for c in run[glyph.letter :] if not face.has(c)), letter)
        elif glyph.letter in inked or not _is_seen(letter):
            continue
        other = next(with_letters({c for c in line if _is_seen(c)}), None)
        remedy = Remedy(font=other) if other else "a font that has one, by its name or file"
        raise DesignError(f"the font {face.name} has no shape for {letter!r} (U+{ord(letter):04X})", remedy)


def _is_seen(letter: str) -> bool:
    """Whether a letter leaves ink by itself: letters, figures, punctuation and symbols do."""
    return unicodedata.category(letter)[0] in "LNPS"


def _corners(face: Typeface, placed: Sequence[Placed]) -> Points:
    """Of the outlines (k, 2) of glyphs."""
    return np.vstack(
        [loop.flatten() + np.array([x, y]) for number, x, y in placed for loop in face.outline(number)]
    )


def _apart(letters: Sequence[Region]) -> tuple[Region, ...]:
    """Letters, those that overlap or all but touch made one."""
    group = components(near(letters), len(letters))
    found: list[Region] = []
    for number in range(group.max() + 1):
        members = [letters[i] for i in np.flatnonzero(group == number).tolist()]
        found += members if len(members) == 1 else united([loop for one in members for loop in one.loops])
    return tuple(found)
