"""Format and version information, each drawn twice (ISO/IEC 18004 §7.9, §7.10, Annexes C and D)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.errors import SymbolError
from perfqr_cad.symbol.layout import (
    FIRST_VERSION_WITH_INFO,
    FORMAT_BITS,
    VERSION_BITS,
    layout,
    version_word,
)
from perfqr_cad.symbol.matrix import BoolArray, Matrix, read_only
from perfqr_cad.symbol.tables import LEVELS, MASKS, MAX_VERSION, Level

BCH_CAPACITY: Final = 3  # wrong bits that the (15, 5) code corrects
_SOFT_CANDIDATES: Final = 4  # the blocks' own check decides between them
_BCH_GENERATOR: Final = 0x537
_XOR: Final = 0x5412
_LEVEL_BITS: Final[dict[Level, int]] = {"L": 1, "M": 0, "Q": 3, "H": 2}


@dataclass(frozen=True)
class FormatInfo:
    """A reading of the format information.

    `distances` are the bits in which each of the two copies differs from the word of this level and mask.
    """

    level: Level
    mask: int
    distances: tuple[int, int]


@cache
def format_word(level: Level, mask: int) -> int:
    """The 15 bits as drawn: two of level, three of mask, ten of BCH remainder, XORed (§7.9.1)."""
    data = _LEVEL_BITS[level] << 3 | mask
    remainder = data
    for _ in range(10):
        remainder = remainder << 1 ^ (remainder >> 9) * _BCH_GENERATOR
    return (data << 10 | remainder) ^ _XOR


@cache
def _words() -> tuple[tuple[tuple[Level, int], ...], BoolArray]:
    """All (level, mask) and their words, (32, 15), bit 0 first."""
    kinds: list[tuple[Level, int]] = [(level, mask) for level in LEVELS for mask in range(MASKS)]
    words = np.array([format_word(*kind) for kind in kinds])
    return tuple(kinds), read_only((words[:, None] >> np.arange(FORMAT_BITS) & 1).astype(np.bool_))


def format_candidates(matrix: Matrix, log_likelihood: NDArray[np.floating] | None = None) -> list[FormatInfo]:
    """Readings of the format information that are worth trying, likeliest first.

    A word is within reach when one copy has at most three wrong bits. The nearest single copy comes first,
    then the nearest of both together. With `log_likelihood` (n, n), positive = dark, the likeliest word
    comes first, and the four likeliest count as within reach. SymbolError when no word is.
    """
    places = layout(matrix.version, "L").format_modules
    kinds, words = _words()
    read = matrix.dark[places[..., 0], places[..., 1]]
    distances = np.count_nonzero(read[None] ^ words[:, None], axis=2)  # (32, 2)
    cost = distances.min(axis=1) + distances.sum(axis=1) / (2 * FORMAT_BITS + 1)
    if log_likelihood is not None:
        seen = log_likelihood[places[..., 0], places[..., 1]].sum(axis=0)
        cost = -(np.where(words, 1.0, -1.0) @ seen)
    ranked = [int(k) for k in np.argsort(cost, kind="stable")]
    sure = 0 if log_likelihood is None else _SOFT_CANDIDATES
    reach = [k for rank, k in enumerate(ranked) if rank < sure or distances[k].min() <= BCH_CAPACITY]
    if not reach:
        raise SymbolError(
            f"the format information cannot be read: {distances.min()} of {FORMAT_BITS} bits are wrong in the"
            f" better copy, at most {BCH_CAPACITY} can be corrected; restore the modules beside the finders"
        )
    return [FormatInfo(*kinds[k], (int(distances[k, 0]), int(distances[k, 1]))) for k in reach]


def read_format(matrix: Matrix) -> FormatInfo:
    """The level and mask of a matrix, from the better copy. SymbolError when neither is readable."""
    return format_candidates(matrix)[0]


def read_version(matrix: Matrix) -> int:
    """The version that a matrix claims: by its 18-bit words from version 7 on (§7.10), else by its size.

    SymbolError when both copies have more than three wrong bits, the most that the code corrects.
    """
    places = layout(matrix.version, "L").version_modules
    if not places.size:
        return matrix.version
    versions = range(FIRST_VERSION_WITH_INFO, MAX_VERSION + 1)
    words = np.array([version_word(version) for version in versions])
    bits = (words[:, None] >> np.arange(VERSION_BITS) & 1).astype(np.bool_)
    read = matrix.dark[places[..., 0], places[..., 1]]
    distances = np.count_nonzero(read[None] ^ bits[:, None], axis=2).min(axis=1)
    if distances.min() > BCH_CAPACITY:
        raise SymbolError(
            f"the version information cannot be read: {distances.min()} of {VERSION_BITS} bits are wrong in"
            f" the better copy, at most {BCH_CAPACITY} can be corrected"
        )
    return versions[int(distances.argmin())]
