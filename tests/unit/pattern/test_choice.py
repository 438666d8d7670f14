"""The choice of a mask."""

from dataclasses import replace

import pytest

from perfqr_cad.pattern import PatternSpec, build
from perfqr_cad.pattern.choice import easiest_mask, joining_area
from perfqr_cad.symbol import encode, payload_of


@pytest.mark.parametrize("tone", ["normal", "inverted"])
def test_the_easiest_mask_changes_less_and_keeps_the_message(tone):
    symbol = encode("https://example.org/easiest", version=4)
    spec = PatternSpec(tone=tone)
    easiest = easiest_mask(symbol, spec)
    masks = [replace(symbol, mask=mask) for mask in range(8)]
    hardest = max(masks, key=lambda other: joining_area(other, tone))
    assert payload_of(easiest) == payload_of(symbol)
    assert build(easiest, spec).changed_area_mm2 < build(hardest, spec).changed_area_mm2


def test_the_estimate_is_near_what_is_painted():
    symbol = encode("https://example.org/easiest", version=8)
    pattern = build(symbol, PatternSpec())
    assert joining_area(symbol, "normal") == pytest.approx(
        pattern.changed_area_mm2 / pattern.module_mm**2, rel=0.25
    )
