"""Any text, version and level, drawn at any scale and turned anyhow, is read back module for module."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from perfqr_cad.capture import read
from perfqr_cad.symbol import LEVELS, encode, layout

EXAMPLES = 15

texts = st.text(st.characters(codec="utf-8", exclude_categories=["Cc", "Cs"]), min_size=1, max_size=12)


def _picture(dark: np.ndarray, scale: int, border: int, turns: int) -> np.ndarray:
    squares = np.kron(np.pad(np.rot90(dark, turns), border), np.ones((scale, scale)))
    return np.where(squares > 0, 0, 255).astype(np.uint8)


@settings(max_examples=EXAMPLES, deadline=None)
@given(
    text=texts,
    version=st.integers(5, 12),
    level=st.sampled_from(LEVELS),
    mask=st.integers(0, 7),
    scale=st.integers(2, 6),
    border=st.integers(1, 5),
    turns=st.integers(0, 3),
)
def test_reads_what_was_drawn(
    text: str, version: int, level: str, mask: int, scale: int, border: int, turns: int
) -> None:
    symbol = encode(text, version=version, level=level, mask=mask)  # pyright: ignore[reportArgumentType]
    found = read(_picture(symbol.matrix.dark, scale, border, turns))
    assert found.matrix == symbol.matrix
    assert found.recovery.payload.text == text
    assert found.recovery.symbol.mask == mask


@settings(max_examples=EXAMPLES, deadline=None)
@given(version=st.integers(2, 8), level=st.sampled_from(LEVELS), seed=st.integers(0, 2**32 - 1))
def test_damage_up_to_capacity_is_counted_exactly(version: int, level: str, seed: int) -> None:
    """r wrong codewords in every block, each with random wrong bits."""
    rng = np.random.default_rng(seed)
    symbol = encode("damage", version=version, level=level)  # pyright: ignore[reportArgumentType]
    at = layout(version, symbol.level)
    dark = symbol.matrix.dark.copy()
    for block in range(at.blocks.count):
        for codeword in rng.permutation(at.codewords_of_block(block))[: at.blocks.capacity]:
            bits = rng.random(8) < 0.5
            bits[rng.integers(8)] = True
            rows, columns = at.modules[codeword][bits].T
            dark[rows, columns] ^= True
    found = read(_picture(dark, 4, 4, 0))
    assert found.recovery.errors == (at.blocks.capacity,) * at.blocks.count
    assert found.recovery.symbol == symbol
    assert np.array_equal(found.matrix.dark, dark)
