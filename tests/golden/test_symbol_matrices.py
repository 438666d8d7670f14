"""All 40 × 4 × 8 matrices against two independent encoders (digests: symbol_matrices.py)."""

import json
import runpy
from pathlib import Path

import numpy as np
import pytest

from perfqr_cad.symbol import LEVELS, draw, encode, extract

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
