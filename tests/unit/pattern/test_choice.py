"""The choice of mask, segments, padding and version."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import pytest

from perfqr_cad.pattern import PatternSpec, build
from perfqr_cad.pattern.arrangement import joining
from perfqr_cad.pattern.choice import FREEDOMS, chosen, easiest
from perfqr_cad.symbol import encode, payload_of

TEXT = "https://example.com/p/1234567"
WRITE = partial(encode, TEXT)


@pytest.mark.parametrize("tone", ["normal", "inverted"])
def test_the_easiest_mask_changes_less_and_keeps_the_message(tone):
    symbol = encode("https://example.org/easiest", version=4)
    spec = PatternSpec(tone=tone)
    best, left = easiest(symbol, spec, pads=False)
    masks = [replace(symbol, mask=mask) for mask in range(8)]
    hardest = max(masks, key=lambda other: joining(other, tone == "inverted", 4).area)
    assert left.area == min(joining(other, tone == "inverted", 4).area for other in masks)
    assert payload_of(best) == payload_of(symbol)
    assert build(best, spec).changed_area_mm2 < build(hardest, spec).changed_area_mm2


def test_the_estimate_is_near_what_is_painted():
    symbol = encode("https://example.org/easiest", version=8)
    pattern = build(symbol, PatternSpec())
    assert joining(symbol, False, 4).area == pytest.approx(
        pattern.changed_area_mm2 / pattern.module_mm**2, rel=0.25
    )


@pytest.mark.parametrize("tone", ["normal", "inverted"])
@pytest.mark.parametrize("version", [3, 6])
def test_free_bits_save_most_bridges(version: int, tone):
    spec = PatternSpec(tone=tone)
    symbol = encode(TEXT, version=version)
    by_mask, left_by_mask = easiest(symbol, spec, pads=False)
    best, left = easiest(symbol, spec)
    assert payload_of(best) == payload_of(symbol)
    assert left.area < (0.9 if tone == "inverted" else 0.75) * left_by_mask.area
    assert len(build(best, spec).bridges) < (0.9 if tone == "inverted" else 0.8) * len(
        build(by_mask, spec).bridges
    )
    assert build(best, spec).readability.total == 0


def test_the_next_version_is_taken_where_it_is_worth_it():
    choice = chosen(WRITE, PatternSpec(size_mm=60))
    kept = chosen(WRITE, PatternSpec(size_mm=60), free=frozenset(FREEDOMS) - {"version"})
    assert (kept.symbol.version, choice.symbol.version) == (3, 4)
    assert choice.left.area < 0.85 * kept.left.area
    assert payload_of(choice.symbol).text == payload_of(choice.plain).text == TEXT
    assert chosen(WRITE, PatternSpec(size_mm=45)).symbol.version == 3  # modules of 1.1 mm cannot be made
    assert chosen(WRITE, PatternSpec()).symbol.version == 3  # the size is open: it would grow
    bare = PatternSpec(size_mm=60, quiet_modules=1)
    assert (
        chosen(partial(encode, "LOT 7731 / 2027-05"), bare).symbol.version == 1
    )  # modules would shrink by a seventh


def test_what_is_asked_for_stays():
    choice = chosen(partial(encode, TEXT, level="Q"), PatternSpec(size_mm=60), version=5, mask=2)
    assert (choice.symbol.version, choice.symbol.mask, choice.symbol.level) == (5, 2, "Q")
    assert choice.pads_are_free


def test_without_freedom_it_is_the_ordinary_symbol():
    choice = chosen(WRITE, PatternSpec(size_mm=60), free=frozenset())
    assert choice.symbol == choice.plain == encode(TEXT)
    assert not choice.pads_are_free
    segments = chosen(WRITE, PatternSpec(size_mm=60), free=frozenset({"segment"}))
    assert not segments.pads_are_free
    assert [segment.mode for segment in payload_of(segments.symbol).segments] == ["byte", "numeric"]


def test_the_same_seed_chooses_the_same():
    spec = PatternSpec(size_mm=60, seed=3)
    assert chosen(WRITE, spec).symbol == chosen(WRITE, spec).symbol
