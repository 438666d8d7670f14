"""Plain codes become one piece with the least web throughout, and still read."""

import numpy as np
import pytest
from shapely import box, union_all

from perfqr_cad.capture import Art
from perfqr_cad.errors import DesignError
from perfqr_cad.pattern import Bridge, PatternSpec, build
from perfqr_cad.pattern.drawing.contours import web_pieces
from perfqr_cad.symbol import encode

TEXT = "https://example.org/p/1234567"


@pytest.mark.parametrize("version", [2, 7])
def test_one_polygon_before_and_after_erosion(version):
    pattern = build(encode(TEXT, version=version, level="L"), PatternSpec())
    assert pattern.islands_before > 1
    assert pattern.polygon.is_valid
    assert pattern.polygon.geom_type == "Polygon"
    eroded = pattern.polygon.buffer(-0.99 * pattern.spec.web_mm / 2, quad_segs=16)
    assert eroded.geom_type == "Polygon"
    assert pattern.readability.errors == (0,) * len(pattern.readability.errors)
    assert pattern.region.area == pytest.approx(pattern.polygon.area, rel=1e-3)  # chords of the fillets


def test_a_size_too_small_names_the_least_that_works():
    symbol = encode(TEXT, version=3, level="L")
    with pytest.raises(DesignError, match=r"use --size (\d+\.?\d*) or a finer") as error:
        build(symbol, PatternSpec(size_mm=20))
    least = float(str(error.value).split("--size ")[1].split()[0])
    assert build(symbol, PatternSpec(size_mm=least)).size_mm == pytest.approx(least)
    with pytest.raises(DesignError):
        build(symbol, PatternSpec(size_mm=least - 0.2))


def test_the_least_module_times_the_modules_is_enough():
    symbol = encode(TEXT, version=7, level="M")  # 1.2 · 53 falls short of 63.6 by one binary digit
    assert build(symbol, PatternSpec(size_mm=1.2 * (symbol.size + 8))).module_mm == pytest.approx(1.2)


def test_one_more_bridge_adds_its_area_and_keeps_the_old_pattern():
    pattern = build(encode(TEXT, version=2, level="L"), PatternSpec(fillet_mm=0))
    m = pattern.module_mm
    half = pattern.symbol.size / 2 * m
    core = Bridge((-half + 2 * m, half - 3.5 * m), (-half + 5 * m, half - 3.5 * m), 0.9, "structural", 0.0)
    more = pattern.with_bridge(core)
    assert more.bridges[-1] == core
    assert len(pattern.bridges) == len(more.bridges) - 1
    assert more.region.area == pytest.approx(pattern.region.area + 3 * m * 0.9, rel=1e-6)
    assert np.count_nonzero(more.observed.dark != pattern.observed.dark) == 3


def test_a_thin_web_that_alone_holds_a_piece_is_found():
    def dumbbell(neck_mm):
        return union_all([box(0, 0, 4, 4), box(4, 2 - neck_mm / 2, 6, 2 + neck_mm / 2), box(6, 0, 10, 4)])

    assert len(web_pieces(dumbbell(0.8), 0.8)) == 1
    assert len(web_pieces(dumbbell(0.78), 0.8)) == 2


@pytest.mark.parametrize(
    "settings",
    [{"nozzle_mm": -1}, {"size_mm": 1e9}, {"style": "cubist"}, {"quiet_modules": -1}, {"fillet_mm": -0.1}],
)
def test_absurd_settings_are_refused(settings):
    with pytest.raises(DesignError):
        PatternSpec(**settings)


@pytest.mark.parametrize("finder", ["panel", "recessed", "diagonal"])
def test_fillets_of_any_radius_leave_simple_outlines(finder):
    for fillet_mm in (0.6, 2.0, 5.0):
        try:
            pattern = build(encode("héllo"), PatternSpec(size_mm=40, fillet_mm=fillet_mm, finder=finder))
        except DesignError as refusal:
            assert refusal.remedies[0].changes == {"finder": "panel"}  # noqa: PT017  bars need straight edges
        else:
            assert all(region.polygon().is_valid for region in (pattern.region, *pattern.front))


@pytest.mark.parametrize("kind", ["plain", "halftone", "freeform"])
def test_a_style_draws_plain_modules_anew(kind):
    symbol = encode("style", version=1)
    art = Art(kind, 1, symbol.matrix.dark)
    spec = PatternSpec(style="dots")
    if kind == "plain":
        assert build(symbol, spec, art).region == build(symbol, spec).region
        return
    with pytest.raises(DesignError, match=f"style dots draws plain modules, and the picture has {kind} art"):
        build(symbol, spec, art)
