"""Eqs. (1)-(3) at and around their limits."""

import math

import numpy as np
import pytest

from perfqr_cad.errors import SymbolError
from perfqr_cad.symbol import Matrix, ReadabilityTracker, Symbol, encode, layout, readability, recover


def damaged(symbol: Symbol, block: int, count: int) -> Matrix:
    """The matrix with one module wrong in each of `count` codewords of a block."""
    at = layout(symbol.version, symbol.level)
    return symbol.matrix.flipped(at.modules[at.codewords_of_block(block)[:count], 3])


def test_clean_symbol_loses_nothing() -> None:
    symbol = encode("HELLO", version=5, level="Q")
    result = readability(symbol.matrix, symbol)
    assert (result.total, result.unused_correction, sum(result.errors)) == (0.0, 1.0, 0)


@pytest.mark.parametrize(("version", "level"), [(1, "L"), (1, "M"), (2, "L"), (5, "Q"), (8, "M")])
def test_r_errors_are_finite_and_recovered_and_one_more_is_not(version: int, level: str) -> None:
    symbol = encode("HELLO", version=version, level=level)
    structure = symbol.blocks
    full = damaged(symbol, 0, structure.capacity)
    assert readability(full, symbol).total == 1 / structure.count
    assert recover(full).symbol == symbol
    beyond = damaged(symbol, 0, structure.capacity + 1)
    assert readability(beyond, symbol).total == math.inf
    with pytest.raises(
        SymbolError, match=rf"1 of {structure.count} blocks \(1\) have more than {structure.capacity} wrong"
    ):
        recover(beyond)


def test_three_format_regions_are_finite_and_four_are_not() -> None:
    symbol = encode("HELLO", version=3)
    regions = layout(3, "M").format_region
    first = [np.argwhere(regions == k)[0] for k in range(4)]
    for count in range(4):
        assert readability(symbol.matrix.flipped(first[:count]), symbol).total == count / 4
    assert readability(symbol.matrix.flipped(first), symbol).total == math.inf


def test_tracker_agrees_with_the_full_count_on_a_random_walk() -> None:
    symbol = encode("HELLO", version=4, level="M")
    random = np.random.default_rng(3)
    tracker = ReadabilityTracker(symbol)
    for _ in range(150):
        row, column = (int(k) for k in random.integers(symbol.size, size=2))
        expected = readability(tracker.observed.flipped([(row, column)]), symbol)
        assert tracker.preview([(row, column)]) == expected.total
        tracker.flip(row, column)
        assert tracker.readability() == expected
        assert tracker.total == expected.total
