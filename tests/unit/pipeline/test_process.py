"""What a process cannot make is not designed: sheets are cut straight through, as they were filmed."""

from __future__ import annotations

import ezdxf
import pytest
import shapely
from ezdxf import path as paths

from perfqr_cad import make
from perfqr_cad.errors import DesignError
from perfqr_cad.export import cutting
from perfqr_cad.geometry import Loop, Region
from perfqr_cad.pipeline.request import Request
from perfqr_cad.pipeline.resolve import makeable, resolve
from perfqr_cad.pipeline.targets import Sheet
from perfqr_cad.profile import sheets
from perfqr_cad.profile.sheets import CUTTING
from perfqr_cad.surface import Cylinder

KERF_MM = 0.3
_bare = sheets.bare


@pytest.fixture(scope="module")
def cut_part():
    return make(
        "HELLO", size_mm=44, thickness_mm=1.0, process="laser", kerf_mm=KERF_MM, frame_mm=6, caption="lab 3",
        freedom="none",
    )  # fmt: skip


def drawn(file, layer):
    """The polygons of a layer, by another reader."""
    return [
        shapely.Polygon([(v.x, v.y) for v in paths.make_path(entity).flattening(1e-4)])
        for entity in ezdxf.readfile(file).modelspace()
        if entity.dxf.layer == layer
    ]


def swept(file, kerf_mm):
    """What is left of the sheet when a beam so wide has run along the paths."""
    [outline], holes = drawn(file, "OUTLINE"), drawn(file, "HOLES")
    return outline.buffer(-kerf_mm / 2).difference(
        shapely.unary_union([hole.buffer(kerf_mm / 2) for hole in holes])
    )


def test_what_is_filmed_is_the_plain_extrusion_of_what_is_cut(cut_part):
    assert cutting.is_extrusion(cut_part)
    assert cut_part.pattern.recessed == ()
    assert cutting.notes(cut_part) == ("letters are outlines to engrave",)
    printed = make("HELLO", size_mm=44, thickness_mm=1.0, freedom="none")
    assert not cutting.is_extrusion(printed)  # the check can fail


def test_the_beam_leaves_the_part_that_was_filmed(cut_part, tmp_path):
    cut_part.write(tmp_path / "a.dxf")
    part = cut_part.pattern.polygon
    left = swept(tmp_path / "a.dxf", KERF_MM)
    assert left.geom_type == "Polygon"
    assert left.symmetric_difference(part).area < 1e-3 * part.area
    assert len(left.interiors) == len(part.interiors)
    assert swept(tmp_path / "a.dxf", 0.0).symmetric_difference(part).area > 0.02 * part.area


def test_without_a_kerf_the_paths_are_the_part(cut_part, tmp_path):
    from perfqr_cad.export import Options, write

    record = write(cut_part, tmp_path / "a.dxf", Options())
    [outline], holes = drawn(tmp_path / "a.dxf", "OUTLINE"), drawn(tmp_path / "a.dxf", "HOLES")
    assert outline.area - sum(hole.area for hole in holes) == pytest.approx(
        cut_part.pattern.region.area, rel=1e-5
    )
    assert "kerf" not in record.remarks


def test_files_say_that_paths_keep_off(cut_part, tmp_path):
    assert "paths keep 0.15 mm off the part" in cut_part.write(tmp_path / "a.dxf").remarks
    assert "kerf" not in cut_part.write(tmp_path / "a.svg").remarks  # the filled picture is the part


def test_letters_are_engraved_and_holes_wider_than_the_kerf(cut_part):
    assert cut_part.solid.relief_mm == pytest.approx(-0.2)
    assert cut_part.pattern.spec.gap_mm == pytest.approx(1.25 * KERF_MM)
    assert cut_part.pattern.spec.fillet_radius_mm == pytest.approx(KERF_MM / 2)


def test_a_hole_narrower_than_the_kerf_is_refused(cut_part):
    with pytest.raises(DesignError, match=r"narrower than a kerf of 9 mm: use no --kerf"):
        cutting.cut(cut_part, 9.0)


@pytest.mark.parametrize("process", sorted(CUTTING))
def test_walls_are_straight_and_bars_go_through(process):
    terms = resolve(Request("A", process=process, thickness_mm=1.0), plate=True)
    assert (terms.walls.draft_deg, terms.walls.lip_mm, terms.drawing.finder) == (0.0, 0.0, "panel")
    assert terms.drawing.web_mm == CUTTING[process].web_mm
    assert resolve(Request("A"), plate=True).drawing.finder == "recessed"


@pytest.mark.parametrize(
    ("process", "thickness_mm", "material", "web_mm"),
    [("laser", 4.0, "steel", 2.0), ("laser", 4.0, "PLA", 0.8), ("waterjet", 1.0, "steel", 1.0)],
)
def test_webs_of_metal_are_half_the_thickness(process, thickness_mm, material, web_mm):
    asked = Request("A", process=process, thickness_mm=thickness_mm, material=material)
    assert resolve(asked, plate=True).drawing.web_mm == web_mm


@pytest.mark.parametrize(
    ("settings", "says"),
    [
        ({"depth_mm": 0.8}, "laser cuts straight through a sheet: use no --depth"),
        ({"draft_deg": 10.0, "lip_mm": 0.2}, "use no --draft and no --lip or --process fdm"),
        ({"bars": 2}, "use no --bars"),
        ({"handling_n": 5.0}, "use no --handling"),
        ({"colour_change": True, "backing_mm": 1.0}, "use no --colour-change"),
        ({"thickness_mm": 25.0}, "laser cuts sheets of up to 20 mm, not 25 mm: use --thickness 20"),
        ({"process": "knife", "material": "steel"}, "knife cuts no steel: use --process laser"),
        ({"process": "waterjet", "caption": "a", "frame_mm": 8.0}, "waterjet cannot engrave a caption"),
        ({"process": "fdm", "kerf_mm": 0.2}, "kerf=0.2 has no effect without process=laser"),
    ],
)
def test_what_cannot_be_cut_is_refused_in_one_line(settings, says):
    with pytest.raises(DesignError, match=says) as refused:
        resolve(Request("A", **{"process": "laser", **settings}), plate=True)
    assert "\n" not in str(refused.value)


def test_a_bent_wall_is_no_sheet():
    with pytest.raises(DesignError, match=r"laser cuts flat sheets"):
        make("A", target=Sheet(Cylinder(40.0, 2.0)), process="laser")


def test_printers_are_asked_for_nothing():
    request = Request("A", process="resin", depth_mm=0.8)
    assert makeable(request, plate=False) is request


def test_of_a_stencil_the_painted_picture_is_filmed(monkeypatch):
    """Paint creeps: where it covers all, nobody reads the wall, though the stencil itself is as it was."""
    made = make("HELLO", size_mm=46, thickness_mm=0.5, process="stencil", freedom="none")
    assert sheets.PAINTED in made.scan.warnings
    assert set(made.scan.readers) == {"zxing-cpp", "zbar", "wechat", "opencv"}
    assert cutting.is_extrusion(made)
    monkeypatch.setattr(sheets, "bare", lambda region: _bare(region, 0.75))
    covered = make(
        "HELLO", size_mm=46, thickness_mm=0.5, process="stencil", freedom="none", accept_unread=True
    )
    assert len(covered.scan.readers) < 2


def test_paint_makes_holes_wider_and_leaves_the_rim():
    hole = Loop.from_points([(1, 1), (1, 2), (2, 2), (2, 1)])
    sheet = Region(Loop.from_points([(0, 0), (4, 0), (4, 3), (0, 3)]), (hole,))
    [left] = sheets.bare(sheet, 0.25)
    assert left.polygon().bounds == (0, 0, 4, 3)
    assert len(sheets.bare(sheet, 1.0)) == 1  # the hole breaks through the rim on two sides
    assert sheets.bare(sheet, 1.0)[0].area == pytest.approx(12 - 9)
