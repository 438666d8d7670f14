"""Any symbol and any art becomes one piece with the least web throughout, and L(Q) stays finite."""

import math

import cv2
import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from perfqr_cad.capture import Art
from perfqr_cad.pattern import PatternSpec, build
from perfqr_cad.scan.decoding import decoders
from perfqr_cad.symbol import Role, encode, layout

slow = settings(max_examples=5, deadline=None, suppress_health_check=[HealthCheck.too_slow])
TEXTS = st.text("abcdefghijklmnopqrstuvwxyz0123456789-/.", min_size=1, max_size=14)


def assert_sound(pattern):
    assert pattern.polygon.is_valid
    assert pattern.polygon.geom_type == "Polygon"
    eroded = pattern.polygon.buffer(-0.98 * pattern.spec.web_mm / 2, quad_segs=16)
    assert eroded.geom_type == "Polygon"
    assert math.isfinite(pattern.readability.total)
    # flattened arcs leave out at most their sagitta
    assert pattern.region.area == pytest.approx(pattern.polygon.area, rel=2e-3)


def picture(pattern, px=6):
    """Grey picture of a pattern's front face: material light; holes, and the recessed bars in them, dark."""
    scale, side = px / pattern.module_mm, round(px * pattern.size_mm / pattern.module_mm)
    loops = [
        np.round(side / 2 + scale * loop.flatten() * (1, -1)).astype(np.int32)
        for region in pattern.front
        for loop in region.loops
    ]
    return cv2.fillPoly(np.zeros((side, side), np.uint8), loops, 255)  # overlaps by the even-odd rule


@slow
@given(text=TEXTS, version=st.integers(1, 12), level=st.sampled_from("LMQH"), mask=st.integers(0, 7))
def test_plain_codes_of_any_kind_lose_nothing(text, version, level, mask):
    symbol = encode(text[: 7 if version == 1 else 14], version=version, level=level, mask=mask)
    pattern = build(symbol, PatternSpec())
    assert_sound(pattern)
    assert sum(pattern.readability.errors) == 0
    assert pattern.readability.total == 0
    assert any(
        text[: 7 if version == 1 else 14].encode() in decoders.load(name)(picture(pattern))
        for name in ("zxing-cpp", "zbar")
    )


@slow
@given(seed=st.integers(0, 2**32 - 1), light=st.floats(0.2, 0.8), version=st.integers(2, 4))
def test_random_halftones_lose_no_codeword(seed, light, version):
    symbol = encode("halftone", version=version, level="H")
    rng = np.random.default_rng(seed)
    art = rng.random((symbol.size * 3,) * 2) >= light
    art[1::3, 1::3] = symbol.matrix.dark
    roles = layout(version, "H").roles
    drawn = np.kron(np.isin(roles, (Role.DATA, Role.EC)), np.ones((3, 3), bool)) > 0
    art = np.where(drawn, art, np.kron(symbol.matrix.dark, np.ones((3, 3), bool)))
    pattern = build(symbol, PatternSpec(most_nodes=200), Art("halftone", 3, art))
    assert_sound(pattern)
    assert sum(pattern.readability.errors) == 0


@slow
@given(
    style=st.sampled_from(["square", "rounded", "dots", "diamond", "bars"]),
    tone=st.sampled_from(["normal", "inverted"]),
    finder=st.sampled_from(["panel", "diagonal", "recessed"]),
    nozzle_mm=st.sampled_from([0.2, 0.4, 0.8]),
)
def test_all_looks_are_sound(style, tone, finder, nozzle_mm):
    assume(tone == "normal" or style not in ("dots", "diamond", "bars"))
    symbol = encode("look", version=2, level="M")
    pattern = build(symbol, PatternSpec(style=style, tone=tone, finder=finder, nozzle_mm=nozzle_mm))
    assert_sound(pattern)
    assert sum(pattern.readability.errors) == 0
