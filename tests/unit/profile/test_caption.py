# pyright: reportAttributeAccessIssue=false
"""Text on the frame: raised and engraved, exact on plates and on curved walls; remedies that hold."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from OCP.BRepCheck import BRepCheck_Analyzer

from perfqr_cad.errors import DesignError
from perfqr_cad.pattern import Hole, Pattern, PatternSpec, Surround
from perfqr_cad.pattern import build as build_pattern
from perfqr_cad.profile import Caption, Walls
from perfqr_cad.profile.caption import fitting_height_mm
from perfqr_cad.remedy import Remedy
from perfqr_cad.solid import build
from perfqr_cad.surface import Cylinder, Placement, Plane
from perfqr_cad.symbol import encode

PLACEMENTS: dict[str, Placement] = {"plane": Plane(2.0), "cylinder": Cylinder(40.0, 2.0)}
SPEC = PatternSpec(surround=Surround(6.0, 3.0, corner_hole_mm=2.0), finder="recessed")


@pytest.fixture(scope="module")
def pattern() -> Pattern:
    return build_pattern(encode("HELLO", version=1), SPEC)


@pytest.mark.parametrize("relief", [0.5, -0.5])
@pytest.mark.parametrize("name", PLACEMENTS)
@pytest.mark.parametrize("text", ["B8 @iä", "ę® ợ", "مرحبا"])
def test_letters_are_exact(pattern: Pattern, name: str, relief: float, text: str) -> None:
    """Counters, dots over letters, letters within letters, and letters whose contours cross."""
    caption = Caption(text, 3.0, relief)
    solid = build(pattern, PLACEMENTS[name], caption=caption)
    assert solid.problems == ()
    assert solid.solids == 1
    assert solid.triangles.closed
    assert BRepCheck_Analyzer(solid.shape, True).IsValid()
    if name == "plane":
        plain = build(pattern, PLACEMENTS[name])
        ink = sum(letter.area for letter in caption.letters())
        assert solid.volume_mm3 - plain.volume_mm3 == pytest.approx(ink * relief, rel=1e-9)
        assert solid.bbox_mm[1][2] == pytest.approx(2.0 + max(relief, 0.0))


@pytest.mark.parametrize(("place", "side"), [("bottom", -1), ("top", 1)])
@pytest.mark.parametrize("text", ["gap", "SSID: lab\nPass: 12"])
def test_letters_lie_in_the_middle_of_their_strip(place: str, side: int, text: str) -> None:
    spec = PatternSpec(surround=Surround(8.0), size_mm=40.0)
    pattern = build_pattern(encode("HELLO", version=1), spec)
    caption = Caption(text, 2.5, -0.3, place=place)  # pyright: ignore[reportArgumentType]
    letters = caption.placed(pattern, 2.0)
    corners = np.vstack([letter.outer.flatten() for letter in letters])
    inner, outer = sorted(np.abs([corners[:, 1].min(), corners[:, 1].max()]))
    assert np.all(side * corners[:, 1] > 0)
    # As far from the code as from the web along the edge.
    assert inner - pattern.size_mm / 2 == pytest.approx(pattern.extent_mm / 2 - spec.web_mm - outer, abs=1e-3)
    assert inner > pattern.size_mm / 2


def test_a_part_knows_its_letters(pattern: Pattern) -> None:
    """For formats that draw them."""
    caption = Caption("A", 3.0, -0.3)
    solid = build(pattern, Plane(2.0), caption=caption)
    assert (solid.letters, solid.relief_mm) == (caption.placed(pattern, 2.0), -0.3)
    assert build(pattern, Plane(2.0)).letters == ()


def test_capitals_have_the_height_that_is_asked_for() -> None:
    (letter,) = Caption("H", 5.0).letters()
    y = letter.outer.flatten()[:, 1]
    assert y.max() - y.min() == pytest.approx(5.0)


def test_lines_get_the_height_that_fits_unless_one_is_asked_for() -> None:
    assert fitting_height_mm("SN 42", None, 8.0, 0.8) == 4.0
    lower = fitting_height_mm("SN 42\nLot 7", None, 8.0, 0.8)
    assert 2.0 < lower < 3.0
    tall = PatternSpec(surround=Surround(8.0), size_mm=60.0)
    pattern = build_pattern(encode("HELLO", version=1), tall)
    assert len(Caption("SN 42\nLot 7", lower).placed(pattern, 2.0)) == 8
    with pytest.raises(DesignError, match="do not fit a frame"):
        Caption("SN 42\nLot 7", lower + 0.01).placed(pattern, 2.0)


def test_pockets_do_not_close_mounting_holes(pattern: Pattern) -> None:
    solid = build(pattern, Plane(2.0), Walls(depth_mm=1.0), caption=Caption("O", 3.0, -0.5))
    assert solid.problems == ()  # among them the count of through-holes: the four in the corners
    assert solid.triangles.closed


WIDE = Caption("far too much text for it", 3.0)
REFUSALS = {
    "too wide": (WIDE, SPEC, 2.0, "use --caption-height .*, --size .* or a shorter text"),
    "far too wide": (replace(WIDE, text=20 * "long "), SPEC, 2.0, "use --size .* or a shorter text"),
    "too high": (
        Caption("Tall", 12.0),
        SPEC,
        2.0,
        "do not fit a frame .* use --frame .* or --caption-height ",
    ),
    "too high by little": (
        Caption("gjpqy", 8.0),
        replace(SPEC, surround=Surround(4.0)),
        2.0,
        "use --frame 11.43",
    ),
    "lines too high": (Caption("a\nb\nc", 3.0), SPEC, 2.0, "use --frame"),
    "no strip": (Caption("a", 3.0), replace(SPEC, surround=Surround(0.5)), 2.0, "use --frame"),
    "too deep": (Caption("Deep", 3.0, -1.8), SPEC, 2.0, r"use --caption-relief -1\.6 or --thickness 2\.2"),
    "engraved in a foil": (Caption("Hi", 3.0, -0.4), SPEC, 0.3, r"0\.3 mm: use --thickness 0\.8"),
    "too fine": (
        Caption("Hi", 1.0),
        SPEC,
        2.0,
        "narrower than half a nozzle line .* use --caption-height ",
    ),
    "counters too fine": (
        Caption("8", 0.9, -0.4, "STIXGeneral"),
        SPEC,
        2.0,
        "narrower than half a nozzle line",
    ),
    "too fine for the frame": (
        Caption("gjpqy", 1.2),
        replace(SPEC, nozzle_mm=0.6, surround=Surround(3.0)),
        2.0,
        "use --caption-height .* --frame",
    ),
    "on a hole": (
        Caption("centred", 3.0),
        PatternSpec(size_mm=40.0, surround=Surround(6.0, holes=(Hole(0.0, -22.8, 2.0),))),
        2.0,
        "use --caption-place top or a shorter text",
    ),
}


@pytest.mark.parametrize("case", REFUSALS)
def test_each_remedy_of_a_refusal_holds(case: str) -> None:
    """Afterwards nothing is in the way."""
    caption, spec, thickness_mm, reason = REFUSALS[case]
    symbol = encode("HELLO", version=1)
    with pytest.raises(DesignError, match=reason) as refusal:
        caption.placed(build_pattern(symbol, spec), thickness_mm)
    assert len(str(refusal.value).splitlines()) == 1
    assert refusal.value.remedies
    for remedy in refusal.value.remedies:
        after, spec_after, thickness_after_mm = remedied(caption, spec, thickness_mm, remedy)
        assert after.placed(build_pattern(symbol, spec_after), thickness_after_mm)


def remedied(caption: Caption, spec: PatternSpec, thickness_mm: float, remedy: Remedy):
    """All three as they are with a remedy's changes."""
    for name, value in remedy.changes.items():
        match name:
            case "frame_mm":
                spec = replace(spec, surround=replace(spec.surround, frame_mm=value))
            case "size_mm":
                spec = replace(spec, size_mm=value)
            case "thickness_mm":
                thickness_mm = value
            case "caption_height_mm" | "caption_place" | "caption_relief_mm":
                caption = replace(caption, **{name.removeprefix("caption_"): value})
            case _:
                raise AssertionError(remedy)
    return caption, spec, thickness_mm


def test_raised_letters_need_no_floor(pattern: Pattern) -> None:
    assert Caption("Hi", 3.0).placed(pattern, 0.3)


@pytest.mark.parametrize(
    ("wrong", "reason"),
    [
        (("", 3.0, 0.5), "draws nothing"),
        (("a", 0.0, 0.5), "height above 0"),
        (("a", 3.0, 0.0), "above 0 letters are raised"),
        (("a", float("nan"), 0.5), "height above 0"),
        (("a", 3.0, 0.5, "No Such Font"), "not installed"),
        (("日", 3.0), "no shape for '日'"),
        (("a", 3.0, 0.5, None, "left"), "'left' is not one of bottom, top"),
        (("x" * 20_000, 3.0), r"segments in all \(limit 100000\): take a plainer font or a shorter text"),
    ],
)
def test_absurd_captions_are_refused_at_once(wrong: tuple[str, float], reason: str) -> None:
    with pytest.raises(DesignError, match=reason):
        Caption(*wrong)
