"""What files say of what they do not hold."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from perfqr_cad import export
from perfqr_cad.errors import DesignError
from perfqr_cad.export import cutting
from perfqr_cad.export.omissions import leaves_out, notes
from perfqr_cad.pattern import Bridge

BAR = Bridge((-6, -1.5), (-6, 1.5), 0.8, "function", 1.0, height_mm=0.5)


def with_volume(design, volume_mm3):
    return replace(design, solid=replace(design.solid, volume_mm3=volume_mm3))


def recessed(plate):
    """The circular hole crossed by a bar of 2.4 mm² that fills the last 0.5 of 2 mm."""
    pattern = replace(plate.pattern, bridges=(BAR,))
    return with_volume(replace(plate, pattern=pattern), plate.solid.volume_mm3 + 3.0 * 0.8 * 0.5)


@pytest.mark.parametrize("module", ["dxf", "svg", "stl"])
def test_one_body_leaves_the_backing_out(plate, module):
    assert leaves_out(plate, module) == ()
    assert leaves_out(plate.with_backing(), module) == ("the backing",)


@pytest.mark.parametrize("module", ["step", "threemf", "glb", "scad", "png", "report"])
def test_other_formats_hold_all(plate, module):
    assert leaves_out(plate.with_backing(), module) == ()
    assert notes(recessed(plate), module) == ()


def test_flat_formats_leave_out_what_the_code_was_carved_into(plate):
    carved = replace(plate, solid=replace(plate.solid, is_carved=True, volume_mm3=9e3))
    assert leaves_out(carved, "svg") == ("the body around the code",)
    assert leaves_out(carved, "stl") == ()
    assert cutting.notes(carved) == ()


def test_a_plain_plate_is_what_is_cut(plate):
    assert cutting.is_extrusion(plate)
    assert notes(plate, "svg") == ()
    assert notes(plate, "dxf") == ("curves are arcs within 0.002 mm",)


def test_flares_and_pockets_are_named(plate):
    flared = with_volume(plate, plate.solid.volume_mm3 * 0.99)
    assert not cutting.is_extrusion(flared)
    assert cutting.notes(flared) == ("holes go straight through",)


def test_recessed_bars_are_named(plate):
    assert cutting.notes(recessed(plate)) == ("recessed bars are as thick as the sheet",)


def test_a_bent_part_is_named(wrapped):
    assert cutting.notes(wrapped) == ("drawn flat",)


@pytest.mark.parametrize("relief_mm", [0.4, -0.4])
def test_letters_do_not_make_another_plate(plate, relief_mm):
    assert cutting.notes(plate.with_letter(relief_mm)) == ("letters are outlines to engrave",)


def test_certificate_and_summary_say_it(plate, tmp_path):
    design = recessed(plate).with_backing()
    records = export.write_outputs(design, [tmp_path / "part.svg", tmp_path / "part.json"])
    (listed,) = json.loads((tmp_path / "part.json").read_text())["files"]
    assert listed["leaves_out"] == ["the backing"]
    assert listed["notes"] == ["recessed bars are as thick as the sheet"]
    assert records[0].remarks == "leaves out the backing; recessed bars are as thick as the sheet"
    assert records[1].remarks == ""


def test_variants_reach_their_format(plate, tmp_path):
    options = export.Options(dxf="r12", dxf_bridges=True, svg="cut")
    export.write_outputs(plate, [tmp_path / "part.dxf", tmp_path / "part.svg"], options)
    assert "AC1009" in (tmp_path / "part.dxf").read_text()
    assert "BRIDGES" in (tmp_path / "part.dxf").read_text()
    assert 'stroke="#ff0000"' in (tmp_path / "part.svg").read_text()
    export.write_outputs(plate, [tmp_path / "part.dxf", tmp_path / "part.svg"])
    assert "AC1015" in (tmp_path / "part.dxf").read_text()
    assert "BRIDGES" not in (tmp_path / "part.dxf").read_text()
    assert "stroke" not in (tmp_path / "part.svg").read_text()


@pytest.mark.parametrize("wrong", [{"dxf": "r14"}, {"svg": "outline"}])
def test_unknown_variants_are_refused(wrong):
    with pytest.raises(DesignError, match=r"is no variant of that format: use \w+ or \w+$"):
        export.Options(**wrong)
