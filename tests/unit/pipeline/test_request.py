"""A request is checked once, and reads the short notations of the command line."""

import inspect
from typing import get_args

import pytest

from perfqr_cad.errors import DesignError
from perfqr_cad.export.dxf import DxfVersion
from perfqr_cad.export.svg import SvgVariant
from perfqr_cad.pattern.spec import CHOICES as SPEC_CHOICES
from perfqr_cad.pipeline.chain import make
from perfqr_cad.pipeline.parameter import Parameter
from perfqr_cad.pipeline.request import CUT, SETTINGS, Request
from perfqr_cad.pipeline.resolve import DRAFT_DEG, LIP_MM, Terms, resolve
from perfqr_cad.pipeline.setting import GROUPS
from perfqr_cad.profile.sheets import CUTTING
from perfqr_cad.remedy import UNITS
from perfqr_cad.scan import FULL, QUICK
from perfqr_cad.scan.colours import BACKGROUNDS, FILAMENTS
from perfqr_cad.scan.grade import LETTERS
from perfqr_cad.structure.loads import Hold
from perfqr_cad.structure.material_table import MATERIALS
from perfqr_cad.symbol import Level

HOLE = next(declared for declared in SETTINGS if declared.name == "hole")


def test_holes_are_read_as_written() -> None:
    assert HOLE.read("") == ()
    assert HOLE.read("3.2") == ((3.2,),)
    assert HOLE.read("0,35,4; 0,-35,4;3") == ((0, 35, 4), (0, -35, 4), (3,))
    assert Request("HELLO", hole_mm=[(0, 35, 4), 3]).hole_mm == ((0, 35, 4), (3,))


@pytest.mark.parametrize("text", ["1,2", "big", "1,2,3,4", "3mm"])
def test_a_hole_that_is_none(text: str) -> None:
    with pytest.raises(DesignError, match="give a diameter for one hole in each corner, or x,y,diameter"):
        HOLE.read(text)


def test_corner_holes_have_one_diameter() -> None:
    with pytest.raises(DesignError, match="two diameters"):
        Request("HELLO", frame_mm=8, hole_mm=((4,), (5,)))


def terms(*, plate: bool = True, **settings: object) -> Terms:
    return resolve(Request("HELLO", **settings), plate=plate)


def test_the_frame_reaches_the_pattern() -> None:
    holes = ((0, 21, 2), (3,))
    surround = terms(frame_mm=8, corner_radius_mm=3, hole_mm=holes).drawing.surround
    assert (surround.frame_mm, surround.corner_radius_mm, len(surround.holes)) == (8, 3, 1)
    assert surround.corner_hole_mm == 3


@pytest.mark.parametrize("declared", SETTINGS, ids=lambda declared: declared.name)
def test_names_differ_by_the_unit_alone(declared: Parameter) -> None:
    suffix = declared.field.removeprefix(declared.name)
    assert suffix in {"", *(f"_{unit}" for unit in UNITS)}
    assert declared.option == "--" + declared.name.replace("_", "-")
    assert declared.description
    assert declared.group in GROUPS


@pytest.mark.parametrize("declared", SETTINGS, ids=lambda declared: declared.name)
def test_defaults_are_within_what_is_declared(declared: Parameter) -> None:
    assert declared.check(declared.default) == declared.default
    if declared.left_open is not None:
        assert declared.read(f"{declared.left_open:g}") is None
        with pytest.raises(DesignError):
            declared.check(declared.left_open)


def test_the_choices_are_those_that_the_layers_know() -> None:
    by_name = {s.name: [value for value, _ in s.choices] for s in SETTINGS if s.choices}
    for name, kind in SPEC_CHOICES.items():
        assert set(by_name.pop(name)) == set(get_args(kind)), name
    assert set(by_name.pop("level")) == set(get_args(Level))
    assert by_name.pop("material") == list(MATERIALS)
    assert set(by_name.pop("support")) == {hold.value for hold in Hold}
    assert by_name.pop("dxf") == list(get_args(DxfVersion))
    assert by_name.pop("svg") == list(get_args(SvgVariant))
    assert by_name.pop("caption_place") == ["bottom", "top"]
    assert by_name.pop("grade") == list(LETTERS)[:-1]
    assert tuple(CUTTING) == CUT
    assert by_name.pop("process") == ["fdm", "resin", *CUTTING]
    assert by_name == {"method": ["optimal", "paper"]}


def test_colours_of_the_help_are_those_that_are_known() -> None:
    help = {declared.name: declared.description for declared in SETTINGS}
    assert all(name in help["colour"] for name in FILAMENTS)
    assert all(name in help["ground"] for name in {"white", *BACKGROUNDS})


def test_help_lists_every_setting_with_range_and_unit() -> None:
    for what in (make, Request):
        told = " ".join((inspect.getdoc(what) or "").split())
        for declared in SETTINGS:
            assert declared.field in told
            assert declared.wanted in told
    assert list(inspect.signature(make).parameters) == [
        "text",
        "image",
        "target",
        *(s.field for s in SETTINGS[2:]),
    ]


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ({"version": 2.5}, "version=2.5 is no whole number: give 1 to 40"),
        ({"quiet_modules": 2.5}, "is no whole number"),
        ({"seed": 0.5}, "is no whole number"),
        ({"size_mm": 10**400}, "is not a finite number"),
        ({"size_mm": 10**5000}, "is not a finite number"),
        ({"size_mm": "wide"}, "size_mm='wide' is no number: give 1 to 10000 mm"),
        ({"verify_solid": 3}, "is neither true nor false"),
        ({"style": "stars"}, "is not one of square, rounded"),
        ({"text": 3}, "text=3 is no text"),
        ({"text": ""}, "the text is empty"),
        ({"text": " \t\u00a0"}, "the text is of blanks alone"),
        ({"text": "x" * 20_000}, "text has 20000 characters, limit 7089"),
        ({"caption": "x" * 20_000}, "caption has 20000 characters, limit 500"),
        ({"caption": "\u200b"}, "of blanks alone"),
        ({"text": "\udcff"}, "is no text"),
    ],
)
def test_values_of_another_kind_are_one_line(wrong: dict[str, object], says: str) -> None:
    with pytest.raises(DesignError) as told:
        Request(**({"text": "HELLO"} | wrong))  # pyright: ignore[reportArgumentType]
    assert says in str(told.value)
    assert len(str(told.value)) < 250


@pytest.mark.parametrize(("name", "value"), [("frame_mm", -1.0), ("thickness_mm", float("nan")), ("mask", 9)])
def test_values_that_cannot_be_meant(name: str, value: float) -> None:
    with pytest.raises(DesignError, match=name):
        Request("HELLO", **{name: value})


def test_a_caption_takes_half_of_its_frame() -> None:
    caption = terms(frame_mm=8, caption="SN 42").caption
    assert caption is not None
    assert (caption.text, caption.height_mm, caption.relief_mm) == ("SN 42", 4, 0.4)
    assert terms().caption is None


def test_a_caption_of_several_lines_takes_what_fits() -> None:
    caption = terms(
        frame_mm=14, caption="SSID: lab\nPass: 12", caption_place="top", font="STIXGeneral"
    ).caption
    assert caption is not None
    assert (caption.place, caption.font) == ("top", "STIXGeneral")
    assert caption.height_mm * caption.extent.height == pytest.approx(14 - 0.8)  # a web of two nozzle lines


def test_a_caption_without_a_frame_is_refused() -> None:
    with pytest.raises(DesignError, match="needs a frame"):
        terms(caption="SN 42")


def test_the_backing_has_the_tone_of_the_holes() -> None:
    dark = terms(backing_mm=1).backing
    light = terms(backing_mm=1, gap_mm=2, tone="inverted").backing
    assert dark is not None
    assert light is not None
    assert max(dark.colour) < 0.1 < 0.9 <= min(light.colour)
    assert (light.thickness_mm, light.gap_mm) == (1, 2)
    assert terms(backing_mm=1, gap_mm=2).look.gap_mm == 2


def test_a_tilt_that_is_asked_for_is_filmed_from_as_many_sides_as_in_the_full_certificate() -> None:
    asked = terms(scan_tilt_deg=40.0).views
    assert asked.tilts_deg == (0.0, 20.0, 30.0, 40.0)
    assert (asked.azimuths_deg, asked.frames) == (FULL.azimuths_deg, FULL.frames)
    assert terms().views == QUICK


def test_colours_by_name_and_by_number() -> None:
    plain, asked = terms(), terms(colour="#ffffff", ground="red")
    assert min(plain.colour) >= 0.9
    assert max(terms(tone="inverted").colour) < 0.1
    assert asked.look.material == pytest.approx((1, 1, 1))
    assert asked.look.ground[0] > 0.5 > asked.look.ground[1]
    assert asked.colour == pytest.approx((1, 1, 1))


def test_a_colour_that_is_none() -> None:
    with pytest.raises(DesignError, match="colour 'pinkish' is unknown"):
        terms(colour="pinkish")


@pytest.mark.parametrize(
    ("asked", "plate", "draft_deg", "lip_mm"),
    [
        ({}, True, DRAFT_DEG, LIP_MM),
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
    walls = terms(plate=plate, **asked).walls
    assert (walls.draft_deg, walls.lip_mm) == (draft_deg, lip_mm)


def test_a_code_is_chosen_in_pictures_alone() -> None:
    assert Request(image="two.png", which=2).which == 2
    with pytest.raises(DesignError, match="which=1 has no effect without image"):
        Request(text="one", which=1)
    with pytest.raises(DesignError, match="which"):
        Request(image="two.png", which=0)
