"""Text as outlines, with FreeType's own rasteriser as the witness of every shape."""

from __future__ import annotations

from itertools import combinations, pairwise
from pathlib import Path

import freetype
import matplotlib
import numpy as np
import pytest
import shapely
from bidi.algorithm import get_display
from fontTools.fontBuilder import FontBuilder
from fontTools.pens.ttGlyphPen import TTGlyphPen

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry import Bezier, Line, Region
from perfqr_cad.geometry.winding import CHORD_MM, GAP_MM, united
from perfqr_cad.profile import lettering
from perfqr_cad.profile.lettering import MOST_SEGMENTS, drawn, extent, moved
from perfqr_cad.profile.typeface import FILE, typeface

HEIGHT_MM = 4.0
PIXELS = 160  # of an em
# Letters whose contours cross, nest, touch or overlap, and plain ones, of every script that the font has.
SHAPES = "ęơǫȩỆỘựǺţŁAB8@&%©®℗№¥€$ﬃΩΨφЖЩѭאשّ ﻼبꙮ☸✪❂➉♞⊛▦"


@pytest.fixture(scope="module")
def rasteriser() -> freetype.Face:
    face = freetype.Face(str(Path(matplotlib.get_data_path(), FILE)))
    face.set_pixel_sizes(0, PIXELS)
    return face


def middle(region: Region) -> tuple[float, float]:
    x, y = np.mean([region.outer.flatten().min(axis=0), region.outer.flatten().max(axis=0)], axis=0).tolist()
    return x, y


@pytest.mark.parametrize("letter", SHAPES.replace(" ", ""))
def test_every_pixel_of_a_letter_is_where_freetype_has_it(letter: str, rasteriser: freetype.Face) -> None:
    """Pixels that are wholly inside are inked, and those wholly outside are not: counters stay open."""
    face = typeface()
    glyph = rasteriser.get_char_index(letter)
    rasteriser.load_glyph(glyph, freetype.FT_LOAD_NO_HINTING | freetype.FT_LOAD_RENDER)
    slot = rasteriser.glyph
    bitmap = np.array(slot.bitmap.buffer, np.uint8).reshape(slot.bitmap.rows, -1)[:, : slot.bitmap.width]
    scale = HEIGHT_MM / face.capital
    pixel = face.font.face.upem * scale / PIXELS
    rows, columns = np.indices(bitmap.shape)
    x = (slot.bitmap_left + columns + 0.5) * pixel
    y = (slot.bitmap_top - rows - 0.5) * pixel
    regions = united([moved(loop, scale, 0.0, 0.0) for loop in face.outline(glyph)])
    ink = shapely.union_all([region.polygon(0.001) for region in regions])
    shapely.prepare(ink)
    inside = shapely.contains_xy(ink, x, y)
    wrong = ((bitmap == 255) & ~inside) | ((bitmap == 0) & inside)
    off = shapely.distance(ink.boundary, shapely.points(x[wrong], y[wrong]))
    assert np.all(off < GAP_MM + pixel / 4)  # a gap that is closed
    assert ink.area == pytest.approx(bitmap.sum() / 255 * pixel**2, rel=0.01)


@pytest.mark.parametrize(
    ("text", "letters", "counters"),
    [
        ("Łódź ręka 800", 13, 8),
        ("Abo 8 ę", 5, 6),
        ("©", 2, 1),  # a c in a ring
        ("®", 2, 2),  # an R, with its counter, in a ring
        ("$5 or $6", 6, 6),
        (r"a_b^{c} \alpha", 13, 5),
        ("ﬁ", 2, 0),
        ("%", 3, 2),
        ("i̇ Å", 3, 2),
    ],
)
def test_counters_stay_open(text: str, letters: int, counters: int) -> None:
    regions = drawn(text, HEIGHT_MM)
    assert (len(regions), sum(len(region.holes) for region in regions)) == (letters, counters)


def test_a_line_is_its_letters() -> None:
    """No letter changes another: areas add up."""
    for text in ("Łódź ręka 800", "© lab ®", "Việt Nam", "$5 or $6"):
        alone = sum(region.area for letter in text.replace(" ", "") for region in drawn(letter, HEIGHT_MM))
        assert sum(region.area for region in drawn(text, HEIGHT_MM)) == pytest.approx(alone, rel=1e-6)


def test_letters_keep_their_curves() -> None:
    for letter in "oę":
        for region in drawn(letter, HEIGHT_MM):
            for loop in region.loops:
                curves = [segment for segment in loop.segments if isinstance(segment, Bezier)]
                assert 4 <= len(curves) <= len(loop.segments) < 40


def test_letters_that_overlap_are_one() -> None:
    (letter,) = drawn("o\u0338", HEIGHT_MM)  # a long solidus over it
    assert len(letter.holes) == 2
    assert len(drawn("o/", HEIGHT_MM)) == 2


def test_lines_stand_below_one_another_at_the_pitch_of_the_font() -> None:
    face = typeface()
    pitch = face.pitch * HEIGHT_MM / face.capital
    regions = drawn("H\nHH\r\n\nH", HEIGHT_MM)
    heights = sorted({round(middle(region)[1], 6) for region in regions}, reverse=True)
    assert [a - b for a, b in pairwise(heights)] == pytest.approx([pitch, 2 * pitch])
    assert sum(heights) == pytest.approx(pitch / 2)  # the empty line counts
    assert [middle(region)[0] for region in regions if abs(middle(region)[1] - heights[0]) < 1] == [
        pytest.approx(0.0)
    ]
    room = extent("H\nHH\n\nH")
    assert room.height == pytest.approx(3 * face.pitch / face.capital + 1)


def test_capitals_are_as_high_as_they_are_asked_to_be() -> None:
    for font in (None, "DejaVu Serif", "STIXGeneral"):
        (letter,) = drawn("H", 5.0, font)
        y = letter.outer.flatten()[:, 1]
        assert (y.min(), y.max()) == pytest.approx((-2.5, 2.5))


def test_arabic_letters_are_joined() -> None:
    """One body with three dots below; with non-joiners between, three of each."""
    joined, parted = drawn("ببب", HEIGHT_MM), drawn("ب\u200cب\u200cب", HEIGHT_MM)
    assert (len(joined), len(parted)) == (4, 6)
    widths = [np.ptp(region.outer.flatten()[:, 0]) for region in joined]
    assert max(widths) > 3 * sorted(widths)[-2]


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("abc", "abc"),
        ("שלום", "םולש"),
        ("שלום abc", "abc םולש"),
        ("abc שלום 12:30", "abc 12:30 םולש"),
        ("(שלום)", "(םולש)"),
        ("Lab שלום (אבג)", "Lab (גבא) םולש"),
        ("אבג abc(def) דהו", "והד abc(def) גבא"),
        ("مرحبا 123", "123 ابحرم"),
        ("", ""),
    ],
)
def test_lines_are_read_in_their_order(text: str, shown: str) -> None:
    """Brackets are drawn as they are seen: the shaper mirrors those of runs that are read leftward."""
    mirrored = str.maketrans("()", ")(")
    runs = [run[::-1].translate(mirrored) if leftward else run for run, leftward in lettering._directed(text)]
    assert "".join(runs) == shown


@pytest.mark.parametrize("text", ["a-1 ב 2,5%", "ا1/2 b ٣٤ ג-5", "+1 אב #7 (no) ٪٥", "אַ בּ x́ 3.14"])
def test_the_order_is_that_of_a_second_implementation(text: str) -> None:
    """Without brackets, of which that one knows less."""
    plain = text.replace("(", "").replace(")", "")
    runs = [run[::-1] if leftward else run for run, leftward in lettering._directed(plain)]
    assert "".join(runs) == get_display(plain)


def test_hebrew_stands_from_right_to_left() -> None:
    """Of three letters the first, which alone is in two pieces, stands on the right."""
    regions = drawn("הגו", HEIGHT_MM)
    alone = [sum(region.area for region in drawn(letter, HEIGHT_MM)) for letter in "הגו"]
    right = sorted(regions, key=lambda region: middle(region)[0])
    assert right[0].area == pytest.approx(alone[2])
    assert right[-1].area + right[-2].area == pytest.approx(alone[0])


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("lab 日本", r"no shape for '日' \(U\+65E5\): use --font|a font that has one"),
        ("Ⓑ", r"no shape for 'Ⓑ' \(U\+24B7\): use --font STIXGeneral"),
        ("नमस्ते", r"no shape for 'न' \(U\+0928\)"),
        ("a\u20e3", r"no shape for '⃣' \(U\+20E3\)"),
        ("", "draws nothing"),
        (" \n ", "draws nothing"),
        ("\u200d", "draws nothing"),
        ("\u00a0\u2003", "draws nothing"),
        ("a\u200bb", r"U\+200B, zero width space: leave it out"),
        ("a\tb", r"U\+0009, without a name: leave it out"),
        ("a\x00", r"U\+0000"),
        ("a\u2028b", r"U\+2028, line separator"),
        ("\u202eabc", r"U\+202E, right-to-left override"),
        ("\ud800", r"U\+D800"),
        ("x" * 20_000, f"segments in all \\(limit {MOST_SEGMENTS}\\): .* a shorter text"),
    ],
)
def test_what_cannot_be_drawn_is_refused_in_one_line(text: str, reason: str) -> None:
    with pytest.raises(DesignError, match=reason) as refusal:
        drawn(text, HEIGHT_MM)
    assert len(str(refusal.value).splitlines()) == 1


def test_the_font_that_is_recommended_has_the_letter() -> None:
    assert len(drawn("Ⓑ", HEIGHT_MM, "STIXGeneral")) == 2


@pytest.mark.parametrize(
    ("font", "reason"),
    [
        ("No Such Font", "is not installed"),
        ("Dejavu Sanz", "use --font 'DejaVu Sans' or the path"),
        ("/dev/zero", "is not installed"),
        ("", "is not installed"),
        ("x" * 300, "is not installed"),
        ("\x00", "is not installed"),
        (__file__, "is no font: give a .ttf"),
    ],
)
def test_fonts_that_are_none(font: str, reason: str) -> None:
    with pytest.raises(DesignError, match=reason):
        drawn("a", HEIGHT_MM, font)


def test_a_font_is_found_whatever_the_case_of_its_name() -> None:
    assert drawn("H", HEIGHT_MM, "dejavu serif") == drawn("H", HEIGHT_MM, "DejaVu Serif")


def odd_font(folder: Path, cap_height: int = 600) -> str:
    """A font whose A has no outline, whose B is two squares corner to corner, and which has no capital H."""

    def glyph(*squares: int) -> object:
        pen = TTGlyphPen(None)
        for at in squares:
            pen.moveTo((at, at))
            for corner in ((at, at + 300), (at + 300, at + 300), (at + 300, at)):
                pen.lineTo(corner)
            pen.closePath()
        return pen.glyph()

    builder = FontBuilder(1000, isTTF=True)
    builder.setupGlyphOrder([".notdef", "A", "B"])
    builder.setupCharacterMap({ord("A"): "A", ord("B"): "B"})
    builder.setupGlyf({".notdef": glyph(0), "A": glyph(), "B": glyph(0, 300)})
    builder.setupHorizontalMetrics(dict.fromkeys((".notdef", "A", "B"), (700, 0)))
    builder.setupHorizontalHeader(ascent=800, descent=-200)
    builder.setupOS2(sCapHeight=cap_height)
    builder.setupPost()
    builder.save(folder / "odd.ttf")
    return str(folder / "odd.ttf")


def test_letters_without_an_outline_are_named(tmp_path: Path) -> None:
    with pytest.raises(DesignError, match=r"odd\.ttf has no shape for 'A' \(U\+0041\)"):
        drawn("BA", HEIGHT_MM, odd_font(tmp_path))


def test_a_font_that_knows_no_capitals_has_letters_of_a_common_size(tmp_path: Path) -> None:
    (letter,) = drawn("B", HEIGHT_MM, odd_font(tmp_path, cap_height=0))
    assert np.ptp(letter.outer.flatten(), axis=0) == pytest.approx(HEIGHT_MM * 600 / 667, rel=2e-3)


def test_a_letter_that_touches_itself_is_welded(tmp_path: Path) -> None:
    (letter,) = drawn("B", HEIGHT_MM, odd_font(tmp_path))
    assert letter.area == pytest.approx(2 * (HEIGHT_MM / 2) ** 2, rel=1e-3)
    assert letter.area > 2 * (HEIGHT_MM / 2) ** 2
    assert all(isinstance(segment, Line) for segment in letter.segments())


@pytest.mark.parametrize("text", ["Łódź ręka 800", "© ® @", "نستعليق لا", "Tiếng Việt\nᾧ ѭ ☸"])
def test_loops_are_simple_and_apart(text: str) -> None:
    loops = [loop for region in drawn(text, HEIGHT_MM) for loop in region.loops]
    rings = [shapely.LinearRing(loop.flatten(CHORD_MM)) for loop in loops]
    assert all(ring.is_simple for ring in rings)
    assert all(a.distance(b) >= GAP_MM for a, b in combinations(rings, 2))
