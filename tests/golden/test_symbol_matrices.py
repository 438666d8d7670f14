"""All 40 × 4 × 8 matrices against two independent encoders (digests: symbol_matrices.py)."""

import json
import runpy
from pathlib import Path

import numpy as np
import pytest
import segno

from perfqr_cad.symbol import LEVELS, Matrix, draw, encode, extract, free_codewords, recover, with_pads

SCRIPT = runpy.run_path(str(Path(__file__).with_name("symbol_matrices.py")))
DIGESTS = json.loads(SCRIPT["GOLDEN"].read_text())
digest, digits_for = SCRIPT["digest"], SCRIPT["digits_for"]


@pytest.mark.parametrize("version", range(1, 41))
def test_every_level_and_mask_matches_both_encoders(version: int) -> None:
    for level in LEVELS:
        symbol = encode(digits_for(version, level), version=version, level=level, mask=0)
        matrices = [draw(version, level, mask, symbol.codewords) for mask in range(8)]
        assert [digest(matrix.dark) for matrix in matrices] == DIGESTS[f"{version}-{level}"]
        assert [extract(matrix, level, mask) for mask, matrix in enumerate(matrices)] == 8 * [
            symbol.codewords
        ]


@pytest.mark.parametrize(
    ("version", "level", "mask"),
    [(1, "H", 2), (6, "Q", 5), (7, "L", 7), (14, "M", 0), (22, "H", 3), (32, "L", 6)],
)
def test_digests_are_still_those_of_the_encoders(version: int, level: str, mask: int) -> None:
    text = digits_for(version, level)
    for encoder in ("by_qrcodegen", "by_segno"):
        assert digest(SCRIPT[encoder](text, version, level, mask)) == DIGESTS[f"{version}-{level}"][mask]


def test_a_single_module_changes_the_digest() -> None:
    dark = encode("1", version=1, level="L", mask=0).matrix.dark
    other = dark.copy()
    other[10, 10] ^= True
    assert digest(dark) != digest(other)
    assert np.count_nonzero(dark ^ other) == 1


def test_segno_differs_only_by_its_wrong_pad_codeword() -> None:
    """Data that ends on a codeword boundary: segno 1.6.6 puts 0x00 before the first pad (issues 123, 148)."""
    code = segno.make("boundary", version=3, error="L", mask=1, boost_error=False)
    theirs = recover(Matrix(np.array([list(row) for row in code.matrix]) == 1)).symbol
    ours = encode("boundary", version=3, level="L", mask=1)
    free = free_codewords(ours)
    assert ours.data[:-free] == theirs.data[:-free]
    assert ours.data[-free:] == (b"\xec\x11" * free)[:free]
    assert theirs.data[-free:] == (b"\x00" + b"\xec\x11" * free)[:free]
    assert with_pads(ours, theirs.data[-free:]) == theirs
