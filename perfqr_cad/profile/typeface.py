# pyright: reportAttributeAccessIssue=false
# HarfBuzz's stubs name nothing of what the module exports.
"""Fonts: found by name or by file, text shaped by HarfBuzz, glyphs as outlines. Lengths in font units."""

from __future__ import annotations

import difflib
import os
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from pathlib import Path
from typing import NamedTuple

import pathops
import uharfbuzz as hb

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry.outline import Loop
from perfqr_cad.geometry.winding import loops_of
from perfqr_cad.remedy import Remedy

FONT = "DejaVu Sans"  # comes with matplotlib: the same outlines on every machine
FILE = "fonts/ttf/DejaVuSans.ttf"  # in matplotlib's data folder
CAPITAL = "H"  # flat at both ends, so that its outline is as high as capitals are
LANGUAGE = "und"  # undetermined: the machine's own must not choose letter forms
REGULAR = 400  # weight of a plain face
PLACEHOLDERS = "Last Resort"  # its boxes stand for every letter there is


class Glyph(NamedTuple):
    """One glyph of a shaped run: its number in the font, where its origin lies, and the letter of the run
    that it begins with."""

    number: int
    x: float
    y: float
    letter: int


@dataclass(frozen=True, eq=False)
class Typeface:
    """A font that is open. Outlines are closed contours which may cross (`winding.united`)."""

    name: str
    font: hb.Font
    _outlines: dict[int, tuple[Loop, ...]] = field(default_factory=dict[int, tuple[Loop, ...]], repr=False)

    @cached_property
    def capital(self) -> float:
        """Height of a capital letter; of a font without any, what it says of them, or 2/3 of an em."""
        if not self.has(CAPITAL):
            return self.font.get_metric_position_with_fallback(hb.OTMetricsTag.CAP_HEIGHT)
        glyph = self.font.get_nominal_glyph(ord(CAPITAL)) or 0
        return max(y for loop in self.outline(glyph) for _, y in loop.flatten())

    @property
    def pitch(self) -> float:
        """From one line to the next."""
        extents = self.font.get_font_extents("ltr")
        return extents.ascender - extents.descender + extents.line_gap

    def has(self, letter: str) -> bool:
        """Whether there is a glyph for a letter."""
        return self.font.get_nominal_glyph(ord(letter)) is not None

    def draws(self, letter: str) -> bool:
        """Whether that glyph has an outline."""
        return self.has(letter) and bool(self.outline(self.font.get_nominal_glyph(ord(letter)) or 0))

    def outline(self, glyph: int) -> tuple[Loop, ...]:
        """Contours of a glyph."""
        if glyph not in self._outlines:
            path = pathops.Path()
            self.font.draw_glyph_with_pen(glyph, path.getPen())
            self._outlines[glyph] = loops_of(path)
        return self._outlines[glyph]

    def shaped(self, text: str, script: str, leftward: bool) -> tuple[list[Glyph], float]:
        """The glyphs of a text of one script and one direction, left to right, and the length of the run."""
        buffer = hb.Buffer()
        buffer.add_str(text)
        buffer.direction, buffer.script = ("rtl" if leftward else "ltr"), script
        buffer.language = LANGUAGE
        hb.shape(self.font, buffer)
        glyphs: list[Glyph] = []
        x = 0.0
        for info, position in zip(buffer.glyph_infos, buffer.glyph_positions or (), strict=True):
            glyphs.append(Glyph(info.codepoint, x + position.x_offset, position.y_offset, info.cluster))
            x += position.x_advance
        return glyphs, x


@lru_cache(maxsize=64)
def typeface(font: str | None = None) -> Typeface:
    """The font of a name that is installed, of a file, or the one that comes with this program.

    Raises `DesignError` for names and files that are none.
    """
    if font is None:
        import matplotlib

        return _opened(FONT, Path(matplotlib.get_data_path(), FILE), 0)
    if os.path.isfile(font):  # False for names that no file can have, which `Path` raises for
        return _opened(Path(font).name, Path(font), 0)
    known = {name.casefold(): name for name in _installed()}
    if font.casefold() not in known:
        close = difflib.get_close_matches(font.casefold(), known, n=1)
        like = [Remedy(font=known[close[0]])] if close else []
        raise DesignError(f"font {font!r} is not installed", *like, "the path of a font file")
    name = known[font.casefold()]
    return _opened(name, *_installed()[name])


def with_letters(letters: set[str]) -> Iterator[str]:
    """Names of the installed fonts that have shapes for all these letters."""
    for name in _installed():
        if not name.startswith(PLACEHOLDERS) and all(map(typeface(name).draws, letters)):
            yield name


@lru_cache(maxsize=1)
def _installed() -> dict[str, tuple[Path, int]]:
    """File, and place in it, of the plain face of each installed font, in order of names."""
    from matplotlib.font_manager import FontEntry, fontManager, weight_dict

    def plainness(entry: FontEntry) -> tuple[bool, bool, float, str]:
        weight = weight_dict.get(str(entry.weight), entry.weight)
        return entry.style != "normal", entry.stretch != "normal", abs(float(weight) - REGULAR), entry.fname

    found: dict[str, tuple[Path, int]] = {}
    for entry in sorted(fontManager.ttflist, key=plainness):
        found.setdefault(entry.name, (Path(entry.fname), entry.index))
    return dict(sorted(found.items()))


def _opened(name: str, path: Path, index: int) -> Typeface:
    try:
        face = hb.Face(hb.Blob.from_file_path(str(path)), index)
    except hb.HarfBuzzError as error:
        raise DesignError(f"cannot read the font {path}: {error}") from error
    if not face.glyph_count:
        raise DesignError(f"{path} is no font: give a .ttf, .otf or .ttc file, or a font's name")
    return Typeface(name, hb.Font(face))
