"""A request is checked once, and reads the short notations of the command line."""

import pytest

from perfqr_cad.errors import DesignError
from perfqr_cad.pipeline import resolve as terms
from perfqr_cad.pipeline.request import Request, read_holes
from perfqr_cad.scan import FULL, QUICK


def test_holes_are_read_as_written() -> None:
    assert read_holes("") == {"holes_mm": (), "corner_hole_mm": None}
    assert read_holes("3.2") == {"holes_mm": (), "corner_hole_mm": 3.2}
    assert read_holes("0,35,4; 0,-35,4;3") == {
        "holes_mm": ((0.0, 35.0, 4.0), (0.0, -35.0, 4.0)),
        "corner_hole_mm": 3.0,
    }


@pytest.mark.parametrize("text", ["1,2", "big", "1,2,3,4", "3mm"])
def test_a_hole_that_is_none(text: str) -> None:
    with pytest.raises(DesignError, match="is no diameter"):
        read_holes(text)


def test_the_frame_reaches_the_pattern() -> None:
    surround = terms.spec(Request("HELLO", frame_mm=8, corner_radius_mm=3, **read_holes("0,21,2"))).surround
    assert (surround.frame_mm, surround.corner_radius_mm, len(surround.holes)) == (8, 3, 1)


@pytest.mark.parametrize(("name", "value"), [("frame_mm", -1.0), ("thickness_mm", float("nan")), ("mask", 9)])
def test_values_that_cannot_be_meant(name: str, value: float) -> None:
    with pytest.raises(DesignError, match=name):
        Request("HELLO", **{name: value})


def test_a_caption_takes_half_of_its_frame() -> None:
    caption = terms.caption(Request("HELLO", frame_mm=8, caption="SN 42"))
    assert caption is not None
    assert (caption.text, caption.height_mm, caption.relief_mm) == ("SN 42", 4, 0.4)
    assert terms.caption(Request("HELLO")) is None


def test_a_caption_without_a_frame_is_refused() -> None:
    with pytest.raises(DesignError, match="needs a frame"):
        terms.caption(Request("HELLO", caption="SN 42"))


def test_the_backing_has_the_tone_of_the_holes() -> None:
    dark = terms.backing(Request("HELLO", backing_mm=1))
    light = terms.backing(Request("HELLO", backing_mm=1, backing_gap_mm=2, tone="inverted"))
    assert dark is not None
    assert light is not None
    assert max(dark.colour) < 0.1 < 0.9 <= min(light.colour)
    assert (light.thickness_mm, light.gap_mm) == (1, 2)
    assert terms.look(Request("HELLO", backing_mm=1, backing_gap_mm=2)).gap_mm == 2


def test_a_tilt_that_is_asked_for_is_filmed_from_as_many_sides_as_in_the_full_certificate() -> None:
    asked = terms.plan(Request("HELLO", scan_tilt_deg=40.0))
    assert asked.tilts_deg == (0.0, 20.0, 30.0, 40.0)
    assert (asked.azimuths_deg, asked.frames) == (FULL.azimuths_deg, FULL.frames)
    assert terms.plan(Request("HELLO")) == QUICK


def test_colours_by_name_and_by_number() -> None:
    plain, asked = Request("HELLO"), Request("HELLO", colour="#ffffff", ground="red")
    assert min(terms.part_colour(plain)) >= 0.9
    assert max(terms.part_colour(Request("HELLO", tone="inverted"))) < 0.1
    assert terms.look(asked).material == pytest.approx((1, 1, 1))
    assert terms.look(asked).ground[0] > 0.5 > terms.look(asked).ground[1]
    assert terms.part_colour(asked) == pytest.approx((1, 1, 1))


def test_a_colour_that_is_none() -> None:
    with pytest.raises(DesignError, match="colour 'pinkish' is unknown"):
        terms.look(Request("HELLO", colour="pinkish"))


@pytest.mark.parametrize(
    ("asked", "plate", "draft_deg", "lip_mm"),
    [
        ({}, True, terms.DRAFT_DEG, terms.LIP_MM),
        ({}, False, 0, 0),
        ({"depth_mm": 1}, True, 0, 0),
        ({"thickness_mm": 0.5}, True, 0, 0),
        ({"draft_deg": 0}, True, 0, 0),
        ({"draft_deg": 8}, True, 8, 0),
        ({"draft_deg": 8, "lip_mm": 0.4}, False, 8, 0.4),
    ],
)
def test_walls_flare_where_it_helps_and_nothing_else_is_asked(
    asked: dict[str, float], plate: bool, draft_deg: float, lip_mm: float
) -> None:
    settled = terms.settled(Request("HELLO", **asked), plate=plate)
    assert (settled.draft_deg, settled.lip_mm) == (draft_deg, lip_mm)
