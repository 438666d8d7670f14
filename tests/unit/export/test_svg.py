from __future__ import annotations

import re
from dataclasses import replace
from xml.etree import ElementTree

import cv2
import numpy as np
import pytest
import resvg_py
from svgelements import SVG, Arc, CubicBezier, Move, Path

from perfqr_cad.export import svg
from perfqr_cad.geometry import Arc as PatternArc
from perfqr_cad.geometry import Line, Loop

NS = {"svg": "http://www.w3.org/2000/svg"}


@pytest.fixture
def text(plate, tmp_path):
    svg.write(plate, tmp_path / "part.svg")
    return (tmp_path / "part.svg").read_text("utf-8")


def test_page_is_as_large_as_the_part(text):
    root = ElementTree.fromstring(text)
    assert (root.get("width"), root.get("height")) == ("20mm", "10mm")
    assert root.get("viewBox") == "-10 -5 20 10"


def test_one_even_odd_path_with_arcs_and_curves(text):
    paths = ElementTree.fromstring(text).findall("svg:path", NS)
    assert len(paths) == 1
    assert paths[0].get("fill-rule") == "evenodd"
    data = paths[0].get("d") or ""
    assert [data.count(c) for c in "MACZ"] == [4, 5, 2, 4]  # corner, circle in two, slot in two; two Béziers


def test_another_reader_sees_the_same_area(text, plate, tmp_path):
    """The shoelace of points that svgelements finds gives the area of the region (y down: sign turned)."""
    (tmp_path / "a.svg").write_text(text)
    path = next(e for e in SVG.parse(tmp_path / "a.svg", ppi=25.4).elements() if isinstance(e, Path))
    area = 0.0
    for loop in path.as_subpaths():
        points = np.array([p for s in Path(loop) if not isinstance(s, Move) for p in _along(s)])
        x, y = points.T
        area -= (x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2
    assert area == pytest.approx(plate.pattern.region.area, rel=1e-4)


def _along(segment):
    steps = 200 if isinstance(segment, Arc | CubicBezier) else 1
    return [tuple(segment.point(i / steps)) for i in range(steps)]


def test_arc_beyond_half_a_turn_takes_the_long_way():
    loop = Loop((PatternArc((1, 0), (0, -1), (0, 0), True), Line((0, -1), (1, 0))))
    assert svg.path_data([loop]) == "M1 0A1 1 0 1 0 0 1Z"


def test_bridges_are_an_overlay_only_when_asked_for(text, plate):
    assert "bridge" not in text
    drawn = svg.drawing(plate, bridges=True)
    lines = ElementTree.fromstring(drawn).findall("svg:line", NS)
    assert [line.get("class") for line in lines] == ["bridge connectivity", "bridge structural"]
    assert lines[0].attrib.items() >= {"y1": "1.5", "y2": "-1.5", "stroke-width": "0.8"}.items()


@pytest.fixture
def cut(plate, tmp_path):
    svg.write(plate.with_letter(-0.4), tmp_path / "cut.svg", variant="cut")
    return (tmp_path / "cut.svg").read_text("utf-8")


def test_a_cutter_gets_hairlines_by_operation(cut):
    root = ElementTree.fromstring(cut)
    groups = {group.get("id"): group for group in root.findall("svg:g", NS)}
    assert {name: group.get("stroke") for name, group in groups.items()} == {
        "engrave": "#0000ff",
        "cut": "#ff0000",
    }
    assert {(g.get("fill"), g.get("stroke-width")) for g in groups.values()} == {("none", "0.01")}
    assert (root.get("width"), root.get("viewBox")) == ("20mm", "-10 -5 20 10")


def test_every_path_is_one_closed_loop_and_the_outline_comes_last(cut, tmp_path, plate):
    (tmp_path / "a.svg").write_text(cut)
    found = [e for e in SVG.parse(tmp_path / "a.svg", ppi=25.4).elements() if isinstance(e, Path)]
    assert [len(list(path.as_subpaths())) for path in found] == [1] * 6
    assert [path.d().count("M") for path in found] == [path.d().upper().count("Z") for path in found]
    widths = [box[2] - box[0] for box in (path.bbox(with_stroke=False) for path in found)]
    assert widths[0] < widths[1]  # the counter of the letter before its outline
    assert widths[-1] == pytest.approx(20)
    assert max(widths[:-1]) < 20


def test_a_cutter_gets_no_empty_group(plate):
    assert 'id="engrave"' not in svg.hairlines(plate)


def test_letters_lie_on_the_filled_part(plate):
    groups = ElementTree.fromstring(svg.drawing(plate.with_letter(0.4))).findall("svg:g", NS)
    assert [group.get("id") for group in groups] == ["engrave"]
    assert len(groups[0].findall("svg:path", NS)) == 1


def test_title_is_escaped(plate, tmp_path):
    svg.write(replace(plate, solid=replace(plate.solid, name="a<b & c")), tmp_path / "t.svg")
    assert ElementTree.parse(tmp_path / "t.svg").findtext("svg:title", namespaces=NS) == "a<b & c"


def test_resvg_fills_the_material_and_leaves_the_holes(text, plate):
    """An independent rasteriser covers the exact share of the page."""
    png = resvg_py.svg_to_bytes(svg_string=text, width=400, dpi=96)
    alpha = cv2.imdecode(np.frombuffer(bytes(png), np.uint8), cv2.IMREAD_UNCHANGED)[..., 3]
    page = alpha[alpha.any(axis=1)][:, alpha.any(axis=0)]
    assert page.mean() / 255 == pytest.approx(plate.pattern.region.area / (20 * 10), rel=2e-3)
    assert page[page.shape[0] // 2, page.shape[1] // 5] == 0  # centre of the circle


def test_numbers_are_plain(text):
    assert not re.search(r"-0[ \"LMACZ]|\de-\d", text)
