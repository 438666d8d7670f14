"""Round trips and repair at random."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from perfqr_cad.errors import SymbolError
from perfqr_cad.symbol import (
    LEVELS,
    Matrix,
    ReadabilityTracker,
    Symbol,
    encode,
    free_codewords,
    layout,
    payload_of,
    readability,
    recover,
    with_pads,
)

texts = st.one_of(
    st.text(alphabet="0123456789", min_size=1, max_size=60),
    st.text(alphabet="0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ $%*+-./:", min_size=1, max_size=60),
    st.text(alphabet=st.characters(exclude_categories=["Cs"]), min_size=1, max_size=40),
)
levels = st.sampled_from(LEVELS)
masks = st.one_of(st.none(), st.integers(0, 7))
seeds = st.integers(0, 2**32 - 1)
# Small versions have every block structure and misdecode exception; large ones cost time.
versions = st.one_of(st.integers(1, 14), st.sampled_from([21, 27, 32, 40]))
MANY = settings(max_examples=60, deadline=None)
FEW = settings(max_examples=20, deadline=None)


def symbol_of(version: int, level: str, seed: int) -> Symbol:
    return encode(str(seed)[:8], version=version, level=level, mask=seed % 8)


def damage(symbol: Symbol, counts: list[int], random: np.random.Generator) -> Matrix:
    """Wrong modules, one to eight of them, in as many codewords of each block as said."""
    at = layout(symbol.version, symbol.level)
    modules = []
    for block, count in enumerate(counts):
        for codeword in random.choice(at.codewords_of_block(block), count, replace=False):
            modules.extend(at.modules[codeword, random.permutation(8)[: random.integers(1, 9)]])
    return symbol.matrix.flipped(np.array(modules).reshape(-1, 2))


@MANY
@given(text=texts, level=levels, mask=masks)
def test_text_round_trip(text: str, level: str, mask: int | None) -> None:
    symbol = encode(text, level=level, mask=mask)
    recovery = recover(symbol.matrix)
    assert recovery.symbol == symbol
    assert recovery.payload.text == text
    assert sum(recovery.errors) == sum(recovery.erasures) == 0


@MANY
@given(
    data=st.binary(min_size=1, max_size=80), version=st.one_of(st.none(), st.integers(12, 40)), level=levels
)
def test_bytes_round_trip(data: bytes, version: int, level: str) -> None:
    assert recover(encode(data, version=version, level=level).matrix).payload.data == data


@FEW
@given(version=versions, level=levels, seed=seeds)
def test_damage_up_to_r_in_every_block_is_repaired(version: int, level: str, seed: int) -> None:
    symbol = symbol_of(version, level, seed)
    random = np.random.default_rng(seed)
    counts = random.integers(0, symbol.blocks.capacity + 1, symbol.blocks.count).tolist()
    observed = damage(symbol, counts, random)
    recovery = recover(observed)
    assert recovery.symbol == symbol
    assert list(recovery.errors) == counts
    assert all(count <= r for count, r in zip(recovery.errors, recovery.capacity, strict=True))
    loss = sum((count / symbol.blocks.capacity) ** 2 for count in counts) / symbol.blocks.count
    assert readability(observed, symbol).total == pytest.approx(loss, abs=1e-12)


@MANY
@given(version=versions, level=levels, seed=seeds)
def test_one_error_more_is_refused_and_never_misread(version: int, level: str, seed: int) -> None:
    symbol = symbol_of(version, level, seed)
    random = np.random.default_rng(seed)
    counts = [0] * symbol.blocks.count
    counts[seed % symbol.blocks.count] = symbol.blocks.capacity + 1
    observed = damage(symbol, counts, random)
    assert readability(observed, symbol).total == np.inf
    with pytest.raises(SymbolError, match=f"more than {symbol.blocks.capacity} wrong codewords"):
        recover(observed)


@FEW
@given(version=st.integers(2, 14), level=levels, seed=seeds)
def test_marked_damage_beyond_r_is_repaired_by_erasures(version: int, level: str, seed: int) -> None:
    symbol = symbol_of(version, level, seed)
    random = np.random.default_rng(seed)
    structure = symbol.blocks
    count = min(structure.capacity * 3 // 2, structure.ec - 5)
    observed = damage(symbol, [count] * structure.count, random)
    wrong = observed.dark ^ symbol.matrix.dark
    log_likelihood = np.where(observed.dark, 1.0, -1.0) * np.where(wrong, 0.1, 5.0)
    recovery = recover(observed, log_likelihood=log_likelihood)
    assert recovery.symbol == symbol
    assert recovery.errors == (count,) * structure.count
    beyond = count > structure.capacity
    assert all((erased > 0) == beyond and erased <= structure.ec for erased in recovery.erasures)


@FEW
@given(version=st.integers(1, 10), level=levels, seed=seeds)
def test_noise_is_never_read(version: int, level: str, seed: int) -> None:
    random = np.random.default_rng(seed)
    certainty = random.normal(size=(17 + 4 * version,) * 2)
    noise = Matrix(certainty > 0)
    for log_likelihood in (None, certainty):
        with pytest.raises(SymbolError):
            recover(noise, log_likelihood=log_likelihood)


@MANY
@given(version=st.integers(1, 10), level=levels, seed=seeds)
def test_tracker_equals_the_full_count(version: int, level: str, seed: int) -> None:
    symbol = symbol_of(version, level, seed)
    random = np.random.default_rng(seed)
    tracker = ReadabilityTracker(symbol)
    for row, column in random.integers(symbol.size, size=(random.integers(1, 60), 2)).tolist():
        tracker.flip(row, column)
    before = tracker.readability()
    assert before == readability(tracker.observed, symbol)
    assert tracker.total == pytest.approx(before.total)
    changes = [(int(r), int(c)) for r, c in random.integers(symbol.size, size=(5, 2))]
    preview = tracker.preview(changes)
    assert tracker.readability() == before
    for row, column in changes:
        tracker.flip(row, column)
    assert tracker.total == preview


@MANY
@given(version=st.integers(2, 12), level=levels, seed=seeds)
def test_any_pads_and_mask_keep_the_message(version: int, level: str, seed: int) -> None:
    symbol = symbol_of(version, level, seed)
    pads = np.random.default_rng(seed).bytes(free_codewords(symbol))
    other = with_pads(symbol, pads, mask=seed // 8 % 8)
    assert recover(other.matrix).symbol == other
    assert payload_of(other) == payload_of(symbol)
