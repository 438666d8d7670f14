from __future__ import annotations

import math
import re
from xml.etree import ElementTree

import numpy as np
import pytest

from perfqr_cad.export.report import markup


@pytest.mark.parametrize(
    ("key", "value", "text"),
    [
        ("volume_mm3", 3940.77, "3941 mm³"),
        ("max_stress_mpa", None, "not measured"),
        ("safety_factor", math.inf, "∞"),
        ("valid", True, "yes"),
        ("max_tilt_deg", 30.0, "30°"),
        ("size_mm", [60.0, 60.0, 1.6], "60 × 60 × 1.6 mm"),
        ("solids", 1, "1"),
        ("status", "strong", "strong"),
    ],
)
def test_values_read_with_their_unit(key, value, text):
    assert markup.cell(key, value) == text


def test_label_drops_unit_and_underscores():
    assert markup.key_text("max_stress_mpa") == "max stress"
    assert markup.key_text("islands_before") == "islands before"


def test_facts_leave_out_lists_and_sections():
    html = markup.facts({"loss": 0.25, "blocks": [{"errors": 1}], "inner": {"a": 1}, "bridges": []})
    assert re.findall(r"<th>(.*?)</th>", html) == ["loss"]


def test_text_is_escaped():
    assert "<script>" not in markup.facts({"payload": "<script>"}) + markup.figure("", "<script>")


def test_chart_keeps_the_values_and_the_limit():
    svg = ElementTree.fromstring(markup.line_chart([0.0, 0.1, 0.4], x_label="n", y_label="L", limit=0.3))
    lines = {e.get("class"): e.get("points", "") for e in svg.iter("polyline")}
    heights = [float(point.split(",")[1]) for point in lines["line"].split()]
    low, middle, high = heights
    assert (low - middle) / (low - high) == pytest.approx(0.25, abs=0.01)
    limit = float(lines["limit"].split()[0].split(",")[1])
    assert (low - limit) / (low - high) == pytest.approx(0.75, abs=0.01)


def test_chart_of_infinite_loss_draws_what_is_finite():
    svg = ElementTree.fromstring(markup.line_chart([0.0, math.inf], x_label="n", y_label="L"))
    line = next(e for e in svg.iter("polyline") if e.get("class") == "line")
    assert len(line.get("points", "").split()) == 1


def test_heat_map_goes_from_red_to_green():
    html = markup.heat_map(["0°", "30°"], [("zbar", [1.0, 0.0], "to 0°")])
    green, red = re.findall(r"rgb\((\d+),(\d+),(\d+)\)", html)
    assert int(green[1]) > int(green[0])
    assert int(red[0]) > int(red[1])
    assert "100%" in html


def test_picture_is_inside_the_page():
    html = markup.image(np.full((4, 6), 128, np.uint8), 'a "view"')
    assert html.startswith('<img alt="a &quot;view&quot;" src="data:image/png;base64,')
