"""zxing-cpp reads what is drawn here, and its figure for unused error correction is ours."""

import numpy as np
import pytest
import zxingcpp

from perfqr_cad.symbol import (
    LEVELS,
    QUIET_MODULES,
    Matrix,
    Symbol,
    encode,
    free_codewords,
    freedom,
    layout,
    readability,
    with_pads,
)


def read(matrix: Matrix, pixels: int = 3) -> zxingcpp.Barcode | None:
    light = np.pad(~matrix.dark, QUIET_MODULES, constant_values=True)
    picture = np.kron(light, np.ones((pixels, pixels), bool)).astype(np.uint8) * 255
    return next(iter(zxingcpp.read_barcodes(picture)), None)


def as_zxing_prints(share: float) -> float:
    """The digits of zxing-cpp 3.1.1 where its compiler has no std::format (JSON.h): two, cut off, and
    without the zero after the point."""
    return float(f"{int(share)}.{int(share * 100) % 100}")


def damaged(symbol: Symbol, counts: list[int], seed: int) -> Matrix:
    """One wrong module in as many codewords of each block as said."""
    at = layout(symbol.version, symbol.level)
    random = np.random.default_rng(seed)
    chosen = [
        codeword
        for block, count in enumerate(counts)
        for codeword in random.choice(at.codewords_of_block(block), count, replace=False)
    ]
    return symbol.matrix.flipped(at.modules[chosen, random.integers(8, size=len(chosen))])


@pytest.mark.parametrize("version", range(1, 41))
def test_zxing_reads_every_version_and_level(version: int) -> None:
    for k, level in enumerate(LEVELS):
        symbol = encode("Pér", version=version, level=level, mask=(version + 2 * k) % 8)
        code = read(symbol.matrix)
        assert code is not None
        assert code.text == "Pér"
        assert code.extra["Version"] == str(version)
        assert (code.extra["ECLevel"], code.extra["DataMask"]) == (level, symbol.mask)
        assert code.extra["UEC"] == 1.0


@pytest.mark.parametrize(("version", "level"), [(1, "H"), (2, "M"), (5, "L"), (8, "Q"), (13, "M"), (20, "H")])
def test_unused_correction_is_the_uec_of_zxing(version: int, level: str) -> None:
    symbol = encode("UEC 42", version=version, level=level)
    random = np.random.default_rng(version)
    for share in (0.2, 0.6, 1.0):
        most = int(share * symbol.blocks.capacity)
        counts = [most, *random.integers(0, most + 1, symbol.blocks.count - 1).tolist()]
        observed = damaged(symbol, counts, version)
        code = read(observed)
        assert code is not None
        assert as_zxing_prints(readability(observed, symbol).unused_correction) == code.extra["UEC"]
        assert code.extra["UEC"] < 1.0


def test_zxing_uses_the_codewords_kept_against_misdecoding_and_eq_2_does_not() -> None:
    """Version 1-L: r = 2, yet seven error correction codewords can mend three errors."""
    symbol = encode("UEC 42", version=1, level="L")
    observed = damaged(symbol, [3], 1)
    code = read(observed)
    assert code is not None
    assert readability(observed, symbol).unused_correction == pytest.approx(1 / 7)
    assert code.extra["UEC"] == as_zxing_prints(1 / 7)
    assert readability(observed, symbol).total == np.inf


def test_nothing_is_left_when_a_block_is_beyond_repair() -> None:
    symbol = encode("UEC 42", version=2, level="M")
    observed = damaged(symbol, [9], 1)
    assert read(observed) is None
    assert readability(observed, symbol).unused_correction == 0.0


@pytest.mark.parametrize("seed", range(8))
def test_zxing_ignores_what_follows_the_terminator(seed: int) -> None:
    symbol = encode("pads", version=6, level="L")
    other = with_pads(symbol, np.random.default_rng(seed).bytes(free_codewords(symbol)), mask=seed)
    code = read(other.matrix)
    assert code is not None
    assert code.text == "pads"
    assert other.matrix != symbol.matrix


@pytest.mark.parametrize("version", [1, 2, 3, 5, 7, 11, 18, 27, 40])
@pytest.mark.parametrize("level", LEVELS)
def test_members_of_the_free_space_are_read_without_a_corrected_error(version: int, level) -> None:
    """zxing-cpp's unused correction is 1, and zbar reads the same bytes."""
    from pyzbar import pyzbar

    space = freedom(encode("FREE 42", version=version, level=level))
    random = np.random.default_rng(version)
    for _ in range(3):
        symbol = space.member(random.integers(0, 2, space.dimension).astype(bool))
        code = read(symbol.matrix)
        assert code is not None
        assert (code.text, code.extra["UEC"]) == ("FREE 42", 1.0)
        picture = np.kron(~np.pad(symbol.matrix.dark, 4), np.full((4, 4), 255, np.uint8)).astype(np.uint8)
        assert [one.data for one in pyzbar.decode(picture)] == [b"FREE 42"]
