from __future__ import annotations

import ezdxf
import numpy as np
import pytest
import shapely
from ezdxf import path as paths

from perfqr_cad.export import dxf


@pytest.fixture
def document(plate, tmp_path):
    dxf.write(plate, tmp_path / "part.dxf")
    return ezdxf.readfile(tmp_path / "part.dxf")


def test_audit_finds_nothing(document):
    auditor = document.audit()
    assert not auditor.errors
    assert not auditor.fixes


def test_kinds_and_layers(document):
    found = sorted((e.dxftype(), e.dxf.layer) for e in document.modelspace())
    assert found == [
        ("CIRCLE", "HOLES"),
        ("LWPOLYLINE", "BRIDGES"),
        ("LWPOLYLINE", "BRIDGES"),
        ("LWPOLYLINE", "HOLES"),
        ("LWPOLYLINE", "OUTLINE"),
        ("SPLINE", "HOLES"),
    ]
    assert document.header["$INSUNITS"] == 4
    assert not document.layers.get("BRIDGES").dxf.plot


def test_area_as_another_reader_flattens_it(document, plate):
    rings = {"OUTLINE": [], "HOLES": []}
    for entity in document.modelspace().query('*[layer!="BRIDGES"]'):
        points = [(v.x, v.y) for v in paths.make_path(entity).flattening(1e-4)]
        rings[entity.dxf.layer].append(shapely.Polygon(points).area)
    assert len(rings["OUTLINE"]) == 1
    assert rings["OUTLINE"][0] - sum(rings["HOLES"]) == pytest.approx(plate.pattern.region.area, rel=1e-4)


def test_spline_runs_through_the_beziers(document, plate):
    spline = document.modelspace().query("SPLINE").first.construction_tool()
    drop = next(loop for loop in plate.pattern.region.holes if len(loop.segments) == 2)
    for k, bezier in enumerate(drop.segments):
        for t in (0.0, 0.25, 0.5, 0.75):
            point = spline.point(k + t)
            assert (point.x, point.y) == pytest.approx(bezier.at(t))


def test_bridge_is_drawn_with_its_width(document):
    bars = [shapely.Polygon(e.get_points("xy")) for e in document.modelspace().query('*[layer=="BRIDGES"]')]
    assert [bar.area for bar in bars] == pytest.approx([3 * 0.8, 2 * 0.5])
    assert bars[0].bounds == pytest.approx((-6.4, -1.5, -5.6, 1.5))


def test_same_bytes_again(plate, tmp_path):
    for name in ("a.dxf", "b.dxf"):
        dxf.write(plate, tmp_path / name)
    assert (tmp_path / "a.dxf").read_bytes() == (tmp_path / "b.dxf").read_bytes()
    assert not ezdxf.options.write_fixed_meta_data_for_testing


def test_mixed_loop_is_a_closed_chain(plate, tmp_path):
    """Lines and Béziers in one loop: polylines and splines that meet end to end."""
    from dataclasses import replace

    from perfqr_cad.geometry import Bezier, Line, Loop, Region

    loop = Loop((Line((0, 0), (4, 0)), Bezier((4, 0), (5, 1), (5, 3), (4, 4)), Line((4, 4), (0, 0))))
    design = replace(plate, pattern=replace(plate.pattern, region=Region(loop), bridges=()))
    dxf.write(design, tmp_path / "mixed.dxf")
    entities = list(ezdxf.readfile(tmp_path / "mixed.dxf").modelspace())
    assert [e.dxftype() for e in entities] == ["LWPOLYLINE", "SPLINE", "LWPOLYLINE"]
    chain = [paths.make_path(e) for e in entities]
    ends = np.array([[p.start, p.end] for p in chain])[..., :2]
    assert ends[:, 1] == pytest.approx(np.roll(ends[:, 0], -1, axis=0))
