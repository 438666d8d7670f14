"""DXF as another reader sees it: closed entities of lines and arcs, one piece of the right area."""

from __future__ import annotations

import shutil
import subprocess
from dataclasses import replace

import ezdxf
import pytest
import shapely
import trimesh
from ezdxf import path as paths

from perfqr_cad.export import dxf
from perfqr_cad.geometry import Arc, Bezier, Line, Loop, Region
from perfqr_cad.pattern import Bridge

VERSIONS = pytest.mark.parametrize("version", ["r2000", "r12"])
OPENSCAD = pytest.mark.skipif(not shutil.which("openscad"), reason="openscad is not installed")
CORNERS = [(0, 0), (2, 0), (2, 2), (0, 2), (-2, 2), (-2, 0), (0, 0)]


def written(design, folder, **options):
    dxf.write(design, folder / "part.dxf", **options)
    return ezdxf.readfile(folder / "part.dxf")


def read_piece(document, *, without=()):
    """Everything in the drawing as one even-odd shape; raises ValueError for what is not closed or no arc."""
    piece = shapely.Polygon()
    for entity in document.modelspace():
        if entity.dxf.layer in without:
            continue
        if entity.dxftype() not in {"LWPOLYLINE", "POLYLINE", "CIRCLE"}:
            raise ValueError(f"{entity.dxftype()} is not of lines and arcs")
        if entity.dxftype() != "CIRCLE" and not entity.is_closed:
            raise ValueError("an open polyline")
        points = [(round(v.x, 9), round(v.y, 9)) for v in paths.make_path(entity).flattening(1e-4)]
        piece = piece.symmetric_difference(shapely.Polygon(points))
    return piece


@VERSIONS
def test_audit_finds_nothing(plate, tmp_path, version, caplog):
    auditor = written(plate, tmp_path, version=version).audit()
    assert not auditor.errors
    assert not auditor.fixes
    assert not caplog.records


@VERSIONS
def test_one_loop_is_one_closed_entity(plate, tmp_path, version):
    document = written(plate, tmp_path, version=version)
    polyline = "POLYLINE" if version == "r12" else "LWPOLYLINE"
    found = [(e.dxftype(), e.dxf.layer) for e in document.modelspace()]
    assert found == [("CIRCLE", "HOLES"), (polyline, "HOLES"), (polyline, "HOLES"), (polyline, "OUTLINE")]
    assert document.dxfversion == {"r12": "AC1009", "r2000": "AC1015"}[version]
    assert version == "r12" or document.header["$INSUNITS"] == 4
    extents = document.header["$EXTMIN"][:2], document.header["$EXTMAX"][:2]
    assert extents == ((-10, -5), (10, 5))


@VERSIONS
def test_the_whole_file_is_one_piece_of_the_right_area(plate, tmp_path, version):
    piece = read_piece(written(plate, tmp_path, version=version))
    assert piece.geom_type == "Polygon"
    assert piece.area == pytest.approx(plate.pattern.region.area, rel=1e-4)


def test_the_check_sees_a_spline_an_open_line_and_a_second_piece(plate, tmp_path):
    document = written(plate, tmp_path)
    space = document.modelspace()
    spline = space.add_open_spline(CORNERS)
    with pytest.raises(ValueError, match="SPLINE is not of lines and arcs"):
        read_piece(document)
    space.delete_entity(spline)
    line = space.add_lwpolyline(CORNERS[:4])
    with pytest.raises(ValueError, match="an open polyline"):
        read_piece(document)
    line.close(True)
    space.add_lwpolyline([(30, 0), (31, 0), (31, 1)], close=True)
    assert read_piece(document).geom_type == "MultiPolygon"


def test_beziers_become_arcs_within_the_tolerance(plate, tmp_path):
    drop = next(loop for loop in plate.pattern.region.holes if len(loop.segments) == 2)
    document = written(replace(plate, pattern=replace(plate.pattern, region=Region(drop))), tmp_path)
    (entity,) = document.modelspace()
    drawn = shapely.LinearRing([(v.x, v.y) for v in paths.make_path(entity).flattening(1e-5)])
    exact = shapely.LinearRing(drop.flatten(1e-5))
    assert drawn.hausdorff_distance(exact) < dxf.ARC_TOL_MM + 1e-4


def test_a_loop_of_lines_arcs_and_beziers_stays_whole(plate, tmp_path):
    loop = Loop(
        (
            Line((0, 0), (4, 0)),
            Bezier((4, 0), (5, 1), (5, 3), (4, 4)),
            Arc((4, 4), (0, 4), (2, 4), True),
            Line((0, 4), (0, 0)),
        )
    )
    design = replace(plate, pattern=replace(plate.pattern, region=Region(loop), bridges=()))
    document = written(design, tmp_path)
    assert len(document.modelspace()) == 1
    assert read_piece(document).area == pytest.approx(loop.area, rel=1e-4)


def test_readers_that_drop_bulges_are_not_far_off(plate, tmp_path):
    """The slot's ends are half circles of radius 1: as two chords they would lose all of it."""
    for entity in written(plate, tmp_path).modelspace().query("LWPOLYLINE"):
        chords = shapely.LinearRing(entity.get_points("xy"))
        exact = shapely.LinearRing([(v.x, v.y) for v in paths.make_path(entity).flattening(1e-4)])
        assert chords.hausdorff_distance(exact) <= dxf.RISE_MM + 1e-6


@VERSIONS
def test_bridges_are_left_out_unless_asked_for(plate, tmp_path, version):
    assert "BRIDGES" not in written(plate, tmp_path, version=version).layers
    document = written(plate, tmp_path, version=version, bridges=True)
    assert document.layers.get("BRIDGES").is_frozen()
    bars = document.modelspace().query('*[layer=="BRIDGES"]')
    assert len(bars) == len(plate.pattern.bridges)
    assert not any(bar.is_closed for bar in bars)
    if version == "r2000":
        assert not document.layers.get("BRIDGES").dxf.plot
        assert bars[0].get_points("xyse") == [(-6, -1.5, 0.8, 0.8), (-6, 1.5, 0.8, 0.8)]
    assert read_piece(document, without={"BRIDGES"}).area == pytest.approx(
        plate.pattern.region.area, rel=1e-4
    )


@VERSIONS
def test_letters_are_engraved_first(plate, tmp_path, version):
    document = written(plate.with_letter(-0.4), tmp_path, version=version)
    layers = [entity.dxf.layer for entity in document.modelspace()]
    assert layers[:2] == ["ENGRAVE"] * 2
    assert layers[-1] == "OUTLINE"
    letters = read_piece(document, without={"HOLES", "OUTLINE"})
    assert letters.area == pytest.approx(0.64)
    assert read_piece(document, without={"ENGRAVE"}).area == pytest.approx(
        plate.pattern.region.area, rel=1e-4
    )


@OPENSCAD
@pytest.mark.parametrize("bridges", [False, True])
def test_openscad_makes_one_closed_body(plate, tmp_path, bridges):
    """A reader that drops bulges and layers; bridges do not cut the part even there."""
    dxf.write(plate, tmp_path / "part.dxf", bridges=bridges)
    (tmp_path / "part.scad").write_text('linear_extrude(1, convexity = 10) import("part.dxf", $fn = 200);')
    command = ["openscad", "-q", "-o", "part.stl", "part.scad"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    mesh = trimesh.load_mesh(tmp_path / "part.stl")
    assert mesh.is_watertight
    assert mesh.body_count == 1
    assert mesh.volume == pytest.approx(plate.pattern.region.area, rel=5e-3)


@VERSIONS
def test_same_bytes_again(plate, tmp_path, version):
    for name in ("a.dxf", "b.dxf"):
        dxf.write(plate, tmp_path / name, version=version)
    assert (tmp_path / "a.dxf").read_bytes() == (tmp_path / "b.dxf").read_bytes()
    assert not ezdxf.options.write_fixed_meta_data_for_testing


def test_recessed_bars_are_cut_like_all_material(plate, tmp_path):
    """The loops are those of the region, in which they lie flush."""
    bar = Bridge((-6, -1.5), (-6, 1.5), 0.8, "function", 1.0, height_mm=0.6)
    design = replace(plate, pattern=replace(plate.pattern, bridges=(bar,)))
    assert read_piece(written(design, tmp_path)).equals(read_piece(written(plate, tmp_path)))
