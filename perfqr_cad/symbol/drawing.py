"""From codewords to modules and back; the value `Symbol`."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from perfqr_cad.errors import SymbolError
from perfqr_cad.symbol.format import format_word
from perfqr_cad.symbol.layout import FORMAT_BITS, layout
from perfqr_cad.symbol.masks import mask_pattern
from perfqr_cad.symbol.matrix import Matrix
from perfqr_cad.symbol.tables import Blocks, Level, blocks, check_level, check_mask, size_of


@dataclass(frozen=True)
class Symbol:
    """A correct QR code.

    `codewords` are all of them, data and error correction, in placed (interleaved) order. The matrix is
    drawn from them, so it cannot disagree.
    """

    version: int
    level: Level
    mask: int
    codewords: bytes

    def __post_init__(self) -> None:
        _check_count(self.codewords, self.version, check_level(self.level))
        check_mask(self.mask)

    @cached_property
    def matrix(self) -> Matrix:
        """Q₀, the modules as the standard draws them."""
        return draw(self.version, self.level, self.mask, self.codewords)

    @property
    def size(self) -> int:
        """Modules on one side."""
        return size_of(self.version)

    @property
    def blocks(self) -> Blocks:
        return blocks(self.version, self.level)

    @property
    def data(self) -> bytes:
        """The data codewords of all blocks in the order of the message (§7.6 undone)."""
        return b"".join(
            word[:count] for word, count in zip(deinterleave(self), self.blocks.data, strict=True)
        )


def draw(version: int, level: Level, mask: int, codewords: bytes) -> Matrix:
    """The modules of a symbol. `codewords` in placed order; wrong ones are drawn as they are."""
    _check_count(codewords, version, level)
    at = layout(version, level)
    dark = at.function_dark.copy()
    bits = np.unpackbits(np.frombuffer(codewords, np.uint8)).astype(np.bool_)
    dark[at.modules[..., 0].ravel(), at.modules[..., 1].ravel()] = bits
    dark ^= mask_pattern(version, check_mask(mask))
    word = format_word(level, mask)
    places = at.format_modules
    dark[places[..., 0], places[..., 1]] = (word >> np.arange(FORMAT_BITS)) & 1
    return Matrix(dark)


def _check_count(codewords: bytes, version: int, level: Level) -> None:
    expected = blocks(version, level).codewords
    if len(codewords) != expected:
        raise SymbolError(f"{len(codewords)} codewords given: version {version}-{level} has {expected}")


def extract(matrix: Matrix, level: Level, mask: int) -> bytes:
    """The codewords of a matrix in placed order, errors and all: `draw` undone."""
    at = layout(matrix.version, level)
    bits = (matrix.dark ^ mask_pattern(matrix.version, mask))[at.modules[..., 0], at.modules[..., 1]]
    return np.packbits(bits, axis=1).tobytes()


def deinterleave(symbol: Symbol) -> tuple[bytes, ...]:
    """Codewords by block: data, then error correction (§7.6 undone)."""
    placed = np.frombuffer(symbol.codewords, np.uint8)
    groups = layout(symbol.version, symbol.level).groups
    return tuple(word.tobytes() for group in groups for word in placed[group])
