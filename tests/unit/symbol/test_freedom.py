"""The space of symbols with one payload, and wishes for colours within it."""

from __future__ import annotations

import numpy as np
import pytest

from perfqr_cad.symbol import LEVELS, Wishes, encode, freedom, payload_of
from perfqr_cad.symbol.encoding import free_codewords, padded, with_pads


@pytest.mark.parametrize("level", LEVELS)
@pytest.mark.parametrize("version", [1, 2, 5, 14, 40])
def test_every_bit_after_the_terminator_is_free(version: int, level) -> None:
    symbol = encode("HELLO", version=version, level=level)
    space = freedom(symbol)
    # mode 4, count 9, 11 or 13 bits, letters 28, terminator 4: ISO/IEC 18004 §7.4
    count = 9 if version <= 9 else 11 if version <= 26 else 13
    assert space.dimension == 8 * len(symbol.data) - (4 + count + 28 + 4)
    assert sum(len(block.bits) for block in space.blocks) == space.dimension
    everything = space.member(np.ones(space.dimension, bool))
    assert payload_of(everything) == payload_of(symbol)
    assert everything != symbol


def test_a_full_symbol_has_no_freedom() -> None:
    symbol = encode("A" * 14, version=1, level="M", mode="byte")
    space = freedom(symbol)
    assert space.dimension == 0
    assert not space.is_open.any()
    wishes = Wishes(space)
    assert wishes.grant(20, 20, dark=bool(symbol.matrix.dark[20, 20]))
    assert not wishes.grant(20, 20, dark=not symbol.matrix.dark[20, 20])
    assert wishes.symbol() == symbol


@pytest.mark.parametrize("version", [2, 7, 15])
def test_members_differ_where_the_space_is_open_only(version: int) -> None:
    symbol = encode("open", version=version, level="Q")
    space = freedom(symbol)
    random = np.random.default_rng(version)
    seen = np.zeros((symbol.size,) * 2, bool)
    for _ in range(40):
        member = space.member(random.integers(0, 2, space.dimension).astype(bool))
        seen |= member.matrix.dark != symbol.matrix.dark
    assert not (seen & ~space.is_open).any()
    assert (seen & space.is_open).sum() > 0.99 * space.is_open.sum()


@pytest.mark.parametrize(("version", "level"), [(2, "L"), (5, "H"), (10, "M")])
def test_as_many_wishes_are_granted_as_bits_are_free(version: int, level) -> None:
    space = freedom(encode("wish", version=version, level=level))
    random = np.random.default_rng(7)
    places = random.permutation(np.argwhere(space.is_open))
    wishes = Wishes(space)
    dark = random.integers(0, 2, len(places)).astype(bool)
    held = [
        wishes.grant(int(r), int(c), dark=bool(d)) for (r, c), d in zip(places.tolist(), dark, strict=True)
    ]
    assert wishes.left == 0
    found = wishes.symbol()
    assert payload_of(found).text == "wish"
    assert ((found.matrix.dark[tuple(places.T)] == dark) == held).all()
    assert sum(held) >= space.dimension
    # A module's own data bit is free, so wishes for data modules alone are all granted.
    first = Wishes(space)
    own = [
        tuple(block.places[k])
        for block in space.blocks
        for k, c in enumerate(block.changes)
        if c.bit_count() == 1
    ]
    assert len(own) >= space.dimension
    assert all(first.grant(r, c, dark=True) for r, c in own[: space.dimension])


def test_wishes_beyond_the_space_are_told() -> None:
    """A fixed module cannot change: the answer is whether it has the colour by itself."""
    symbol = encode("fixed", version=3)
    wishes = Wishes(freedom(symbol))
    assert wishes.grant(0, 0, dark=True)  # the corner of a finder
    assert not wishes.grant(0, 0, dark=False)
    assert wishes.left == freedom(symbol).dimension
    assert wishes.symbol() == symbol


def test_standard_padding_is_restored() -> None:
    symbol = encode("HELLO", version=3)
    space = freedom(symbol)
    assert padded(symbol) == symbol
    other = space.member(np.random.default_rng(0).integers(0, 2, space.dimension).astype(bool))
    assert other != symbol
    assert padded(other) == symbol
    assert padded(with_pads(symbol, bytes(free_codewords(symbol)))) == symbol
