"""Correction at its limits: format and version words, erasures, trust."""

import math

import numpy as np
import pytest

from perfqr_cad.errors import SymbolError
from perfqr_cad.symbol import (
    LEVELS,
    Matrix,
    Symbol,
    blocks,
    deinterleave,
    encode,
    format_candidates,
    format_word,
    layout,
    read_format,
    read_version,
    readability,
    recover,
)
from perfqr_cad.symbol.correction import MISDECODE_LIMIT, misdecode_chance, misread_chance
from perfqr_cad.symbol.layout import version_word


def test_three_wrong_bits_in_each_copy_of_the_format_are_corrected() -> None:
    symbol = encode("FORMAT", version=4, level="Q", mask=6)
    places = layout(4, "Q").format_modules
    observed = symbol.matrix.flipped(places[:, [0, 8, 12]].reshape(-1, 2))
    info = read_format(observed)
    assert (info.level, info.mask, info.distances) == ("Q", 6, (3, 3))
    assert recover(observed).symbol == symbol
    assert (
        readability(observed, symbol).total == math.inf
    )  # all four regions: Eq. (3), stricter than the code


def test_one_lost_copy_of_the_format_does_no_harm() -> None:
    symbol = encode("FORMAT", version=4, level="Q", mask=6)
    first = layout(4, "Q").format_modules[0]
    observed = symbol.matrix.flipped(first)
    assert recover(observed).symbol == symbol
    assert readability(observed, symbol).total == 0.5


def with_format(matrix: Matrix, word: int) -> Matrix:
    """The matrix with another word in both copies of its format information."""
    places = layout(matrix.version, "L").format_modules
    dark = matrix.dark.copy()
    dark[places[..., 0], places[..., 1]] = word >> np.arange(15) & 1
    return Matrix(dark)


def test_format_beyond_reach_names_bits_and_limit() -> None:
    words = [format_word(level, mask) for level in LEVELS for mask in range(8)]
    far = next(k for k in range(1 << 15) if min((k ^ word).bit_count() for word in words) == 4)
    observed = with_format(encode("FORMAT", version=4).matrix, far)
    with pytest.raises(SymbolError, match=r"4 of 15 bits are wrong in the better copy, at most 3"):
        recover(observed)


def test_a_format_that_points_elsewhere_is_found_out_by_the_blocks() -> None:
    """One copy rewritten to another valid word: both are perfect readings, only one makes sense."""
    symbol = encode("FORMAT", version=4, level="Q", mask=6)
    other = with_format(symbol.matrix, format_word("H", 1)).dark
    places = layout(4, "Q").format_modules[1]
    dark = other.copy()
    dark[places[:, 0], places[:, 1]] = symbol.matrix.dark[places[:, 0], places[:, 1]]
    recovery = recover(Matrix(dark))
    assert recovery.symbol == symbol
    assert {(info.level, info.mask) for info in format_candidates(Matrix(dark))} >= {("Q", 6), ("H", 1)}


def test_shades_find_a_format_that_hard_decisions_cannot() -> None:
    symbol = encode("FORMAT", version=4, level="Q", mask=6)
    places = layout(4, "Q").format_modules
    wrong = places[:, [1, 4, 6, 9, 13]].reshape(-1, 2)
    observed = symbol.matrix.flipped(wrong)
    assert ("Q", 6) not in {(info.level, info.mask) for info in format_candidates(observed)}
    log_likelihood = np.where(observed.dark, 4.0, -4.0)
    log_likelihood[wrong[:, 0], wrong[:, 1]] *= 0.05
    assert recover(observed, log_likelihood=log_likelihood).symbol == symbol


@pytest.mark.parametrize("version", [6, 7, 25, 40])
def test_version_is_read_through_three_wrong_bits(version: int) -> None:
    matrix = encode("V", version=version).matrix
    places = layout(version, "L").version_modules
    assert read_version(matrix) == version
    assert read_version(matrix.flipped(places[:, 2:5].reshape(-1, 2))) == version
    assert read_version(matrix.flipped(places[1])) == version


def test_unreadable_version_names_bits_and_limit() -> None:
    words = [version_word(version) for version in range(7, 41)]
    far = next(k for k in range(1 << 18) if min((k ^ word).bit_count() for word in words) == 5)
    dark = encode("V", version=7).matrix.dark.copy()
    places = layout(7, "L").version_modules
    dark[places[..., 0], places[..., 1]] = far >> np.arange(18) & 1
    with pytest.raises(SymbolError, match="5 of 18 bits are wrong in the better copy, at most 3"):
        read_version(Matrix(dark))


def shaded(count: int, bits: int) -> tuple[Symbol, Matrix, np.ndarray]:
    """Version 5-Q (r = 9 of 18) with wrong, nearly undecided bits in `count` codewords of block 1."""
    symbol = encode("SHADES", version=5, level="Q")
    at = layout(5, "Q")
    modules = at.modules[at.codewords_of_block(0)[:count], :bits].reshape(-1, 2)
    observed = symbol.matrix.flipped(modules)
    log_likelihood = np.where(observed.dark, 6.0, -6.0)
    log_likelihood[modules[:, 0], modules[:, 1]] *= 0.01
    return symbol, observed, log_likelihood


@pytest.mark.parametrize(("count", "bits", "erased"), [(10, 3, 2), (14, 3, 10), (17, 3, 16), (14, 8, 14)])
def test_erasures_repair_nearly_twice_the_damage_and_are_reported(count: int, bits: int, erased: int) -> None:
    symbol, observed, log_likelihood = shaded(count, bits)
    with pytest.raises(SymbolError, match="more than 9 wrong codewords"):
        recover(observed)
    recovery = recover(observed, log_likelihood=log_likelihood)
    assert recovery.symbol == symbol
    assert (recovery.errors, recovery.erasures) == ((count, 0, 0, 0), (erased, 0, 0, 0))
    assert recovery.capacity == (9, 9, 9, 9)
    assert readability(observed, symbol).total == math.inf


@pytest.mark.parametrize(("count", "bits"), [(18, 3), (15, 8)])
def test_erasures_go_neither_beyond_the_code_nor_beyond_trust(count: int, bits: int) -> None:
    """15 codewords of which nothing is known leave 3 to check with: one random word in 256³ would pass."""
    _, observed, log_likelihood = shaded(count, bits)
    with pytest.raises(SymbolError, match="more than 9 wrong codewords"):
        recover(observed, log_likelihood=log_likelihood)


@pytest.mark.parametrize("scale", [0.02, 1.0, 50.0])
def test_trust_does_not_depend_on_the_scale_of_the_shades(scale: float) -> None:
    symbol, observed, log_likelihood = shaded(14, 3)
    recovery = recover(observed, log_likelihood=scale * log_likelihood)
    assert (recovery.symbol, recovery.erasures) == (symbol, (10, 0, 0, 0))


def test_a_word_that_contradicts_clear_shades_is_not_trusted() -> None:
    symbol = encode("SHADES", version=5, level="Q")
    word = np.frombuffer(deinterleave(symbol)[0], np.uint8)
    shades = 4.0 * np.where(np.unpackbits(word[:, None], axis=1), 1.0, -1.0)
    assert misread_chance(word, shades, 18) < 1e-30
    shades[:12] *= -1  # twelve of 33 codewords say the contrary, as loudly as the others
    assert misread_chance(word, shades, 18) > MISDECODE_LIMIT
    shades[:12] *= 0.01
    assert misread_chance(word, shades, 18) < MISDECODE_LIMIT


def test_chance_of_random_words_is_bounded() -> None:
    """Of 256^n words each is as likely as any when nothing is known: every valid one would do."""
    word = np.zeros(30, np.uint8)
    assert misread_chance(word, np.zeros((30, 8)), 10) == 1.0


def test_plain_decoding_is_within_the_trust_of_table_9_and_blind_erasure_is_not() -> None:
    chances = {
        (version, level): misdecode_chance(
            structure.data[-1] + structure.ec, structure.ec, 0, structure.capacity
        )
        for version in range(1, 41)
        for level in LEVELS
        for structure in [blocks(version, level)]
    }
    assert max(chances.values()) <= MISDECODE_LIMIT
    assert max(chances, key=lambda key: chances[key]) == (2, "L")
    assert misdecode_chance(26, 7, 0, 3) > MISDECODE_LIMIT  # 1-L without its p = 3
    assert misdecode_chance(33, 18, 18, 0) == 1.0


def test_likelihoods_of_another_size_are_refused() -> None:
    symbol = encode("SHADES", version=2)
    with pytest.raises(SymbolError, match="give one for each module"):
        recover(symbol.matrix, log_likelihood=np.zeros((21, 21)))
    with pytest.raises(SymbolError, match="not a number"):
        recover(symbol.matrix, log_likelihood=np.full((25, 25), np.nan))


def test_matrix_of_another_size_is_refused() -> None:
    with pytest.raises(SymbolError, match="29 modules on a side, the symbol 25"):
        readability(encode("A", version=3).matrix, encode("A", version=2))
