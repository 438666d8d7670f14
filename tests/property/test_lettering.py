"""Random texts of many scripts: sound letters, the same whatever their height, or a refusal of one line."""

from __future__ import annotations

import math
from collections.abc import Callable

import hypothesis.strategies as st
import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry import Region
from perfqr_cad.geometry.winding import CHORD_MM, GAP_MM
from perfqr_cad.profile import Profile
from perfqr_cad.profile.lettering import drawn, extent
from perfqr_cad.profile.typeface import typeface
from perfqr_cad.solid import build_profile
from perfqr_cad.surface import Plane

HAD = [chr(code) for code in typeface().font.face.unicodes]  # by the font: of 20 scripts, and symbols
# Runs of one neighbourhood, as texts are; one in a while has a letter from anywhere.
runs = st.integers(0, len(HAD) - 60).flatmap(lambda i: st.text(HAD[i : i + 60], min_size=1, max_size=5))
texts = st.one_of(
    st.lists(runs, min_size=1, max_size=3).map(" ".join),
    st.lists(runs, min_size=2, max_size=3).map("\n".join),
    st.text(max_size=5),
)
many = settings(max_examples=60, deadline=None)
few = settings(max_examples=10, deadline=None)


def or_one_line(draw: Callable[[], tuple[Region, ...]]) -> tuple[Region, ...]:
    """The letters; none where they are refused in one line."""
    try:
        return draw()
    except DesignError as error:
        message = str(error)
    assert message.isprintable()
    assert message
    return ()


@many
@given(texts, st.sampled_from([1.0, 4.0, 30.0]))
def test_loops_are_simple_nested_and_apart(text: str, height_mm: float) -> None:
    regions = or_one_line(lambda: drawn(text, height_mm))
    assume(regions)
    for region in regions:
        assert region.area > 0 > max([hole.area for hole in region.holes], default=-1)
        assert shapely.is_valid(region.polygon(CHORD_MM))
    rings = np.array([shapely.LinearRing(loop.flatten(CHORD_MM)) for r in regions for loop in r.loops])
    one, other = shapely.STRtree(rings).query(rings, predicate="dwithin", distance=0.9 * GAP_MM)
    assert np.array_equal(one, other)
    assert np.all(shapely.is_simple(rings))
    room = extent(text)
    low, high = (f(shapely.get_coordinates(rings)[:, 1]) / height_mm for f in (np.min, np.max))
    assert (low, high) == pytest.approx((room.low, room.high), abs=2 * GAP_MM / height_mm)


@few
@given(texts)
def test_letters_of_another_height_are_those_letters(text: str) -> None:
    small, large = (or_one_line(lambda h=h: drawn(text, h)) for h in (10.0, 20.0))
    area = sum(region.area for region in small)
    assert 4 * area == pytest.approx(sum(region.area for region in large), rel=0.01, abs=0.1)


@few
@given(texts, st.sampled_from([0.5, -0.5]))
def test_letters_make_sound_solids(text: str, relief_mm: float) -> None:
    regions = or_one_line(lambda: drawn(text, 4.0))
    assume(regions)
    room = math.ceil(max(abs(region.outer.flatten()).max() for region in regions)) + 1.0
    plate = Region.from_polygon(shapely.box(-room, -room, room, room))
    solid = build_profile(Profile((plate,), letters=regions, relief_mm=relief_mm), Plane(2.0))
    ink = sum(region.area for region in regions)
    assert solid.problems == ()
    assert solid.triangles.closed
    assert solid.volume_mm3 == pytest.approx(2 * (2 * room) ** 2 + ink * relief_mm, rel=1e-9)
