"""Text on the frame: raised and engraved, exact on plates and on curved walls."""

from __future__ import annotations

import pytest
from OCP.BRepCheck import BRepCheck_Analyzer

from perfqr_cad.errors import DesignError
from perfqr_cad.pattern import Pattern, PatternSpec, Surround
from perfqr_cad.pattern import build as build_pattern
from perfqr_cad.profile import Caption, Walls
from perfqr_cad.solid import build
from perfqr_cad.surface import Cylinder, Placement, Plane
from perfqr_cad.symbol import encode

PLACEMENTS: dict[str, Placement] = {"plane": Plane(2.0), "cylinder": Cylinder(40.0, 2.0)}


@pytest.fixture(scope="module")
def pattern() -> Pattern:
    spec = PatternSpec(surround=Surround(6.0, 3.0, corner_hole_mm=2.0), finder="recessed")
    return build_pattern(encode("HELLO", version=1), spec)


@pytest.mark.parametrize("relief", [0.5, -0.5])
@pytest.mark.parametrize("name", PLACEMENTS)
def test_letters_are_exact(pattern: Pattern, name: str, relief: float) -> None:
    """Counters, dots over letters, and a letter within a letter."""
    caption = Caption("B8 @iä", 3.0, relief)
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


def test_letters_lie_on_the_frame_below_the_code(pattern: Pattern) -> None:
    letters = Caption("gap", 3.0).below(pattern, 2.0)
    low = min(letter.outer.flatten()[:, 1].min() for letter in letters)
    high = max(letter.outer.flatten()[:, 1].max() for letter in letters)
    assert -pattern.extent_mm / 2 < low < high < -pattern.size_mm / 2


def test_capitals_have_the_height_that_is_asked_for() -> None:
    (letter,) = Caption("H", 5.0).letters()
    y = letter.outer.flatten()[:, 1]
    assert y.max() - y.min() == pytest.approx(5.0)


def test_pockets_do_not_close_mounting_holes(pattern: Pattern) -> None:
    solid = build(pattern, Plane(2.0), Walls(depth_mm=1.0), caption=Caption("O", 3.0, -0.5))
    assert solid.problems == ()  # among them the count of through-holes: the four in the corners
    assert solid.triangles.closed


@pytest.mark.parametrize(
    ("caption", "reason"),
    [
        (Caption("far too much text for it", 3.0), "shorter text"),
        (Caption("Tall", 12.0), "do not fit a frame"),
        (Caption("Deep", 3.0, -1.8), "engrave 1.6 mm at most"),
        (Caption("Font", 3.0, font="No Such Font"), "not installed"),
    ],
)
def test_captions_that_do_not_fit_are_refused(pattern: Pattern, caption: Caption, reason: str) -> None:
    with pytest.raises(DesignError, match=reason):
        build(pattern, Plane(2.0), caption=caption)


@pytest.mark.parametrize(
    "wrong", [("", 3.0, 0.5), ("two\nlines", 3.0, 0.5), ("a", 0.0, 0.5), ("a", 3.0, 0.0)]
)
def test_absurd_captions_are_refused(wrong: tuple[str, float, float]) -> None:
    with pytest.raises(DesignError):
        Caption(*wrong)
