"""The loss of readability L(Q) (paper §4.3, Eqs. 1-3).

How the paper's terms map onto the standard:

r          The paper's "maximum number of erroneous codewords" of a block is the capacity of Table 9,
           ⌊(ec − p)/2⌋: ec error correction codewords, of which p are kept for misdecode protection (p = 3
           for 1-L, 2 for 1-M and 2-L, 1 for 1-Q, 1-H and 3-L, else 0). It is the same for all blocks.
four       The format word is drawn twice, 15 bits each, and each copy has two straight arms: the paper's
regions    four format regions (`layout` numbers them). The BCH code corrects three bits in either copy;
           Eq. (3) is stricter: ΔF = 1 at the first wrong module of a region.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from perfqr_cad.errors import SymbolError
from perfqr_cad.symbol.drawing import Symbol
from perfqr_cad.symbol.layout import FORMAT_REGIONS, layout
from perfqr_cad.symbol.matrix import Matrix
from perfqr_cad.symbol.tables import Blocks

Module = tuple[int, int]


@dataclass(frozen=True)
class Readability:
    """L(Q) and its parts.

    codeword_loss           L_C of Eq. (2); inf when a block has more than r erroneous codewords
    format_loss             L_F of Eq. (3); inf when all four regions are damaged
    errors, capacity        erroneous codewords of each block, and r
    format_regions_damaged  0-4
    unused_correction       least share of a block's error correction codewords that is left, in [0, 1]:
                            1 − 2·errors/ec (ISO/IEC 15415 §7.5.9 without its p). zxing-cpp computes
                            the same figure, UEC, and prints two digits of it
    """

    codeword_loss: float
    format_loss: float
    errors: tuple[int, ...]
    capacity: tuple[int, ...]
    format_regions_damaged: int
    unused_correction: float

    @property
    def total(self) -> float:
        """L(Q) of Eq. (1)."""
        return self.codeword_loss + self.format_loss


def readability(observed: Matrix, symbol: Symbol) -> Readability:
    """L(Q) of the modules seen, Q, against the correct symbol, Q₀. SymbolError when the sizes differ.

    >>> from perfqr_cad.symbol import encode
    >>> symbol = encode("HELLO", level="H")
    >>> seen = readability(symbol.matrix.flipped([(20, 20)]), symbol)
    >>> seen.errors, seen.capacity, round(seen.total, 4)
    ((1,), (8,), 0.0156)
    """
    _check_same_size(observed, symbol)
    at = layout(symbol.version, symbol.level)
    wrong = observed.dark ^ symbol.matrix.dark
    erroneous = wrong[at.modules[..., 0], at.modules[..., 1]].any(axis=1)
    errors = np.bincount(at.block_of_codeword[erroneous], minlength=at.blocks.count)
    regions = at.format_region[wrong & (at.format_region >= 0)]
    return _assess([int(count) for count in errors], len(set(regions.tolist())), at.blocks)


def _assess(errors: list[int], damaged: int, structure: Blocks) -> Readability:
    return Readability(
        codeword_loss=_codeword_loss(sum(e * e for e in errors), max(errors), structure),
        format_loss=_format_loss(damaged),
        errors=tuple(errors),
        capacity=(structure.capacity,) * structure.count,
        format_regions_damaged=damaged,
        unused_correction=max(0.0, 1.0 - 2 * max(errors) / structure.ec),
    )


def _codeword_loss(sum_of_squares: int, most: int, structure: Blocks) -> float:
    """Eq. (2); all blocks of a symbol have the same r."""
    if most > structure.capacity:
        return math.inf
    return sum_of_squares / (structure.capacity**2 * structure.count)


def _format_loss(damaged: int) -> float:
    """Eq. (3)."""
    return damaged / FORMAT_REGIONS if damaged < FORMAT_REGIONS else math.inf


def _check_same_size(observed: Matrix, symbol: Symbol) -> None:
    if observed.size != symbol.size:
        raise SymbolError(
            f"the matrix has {observed.size} modules on a side, the symbol {symbol.size}:"
            " compare equal versions"
        )


class ReadabilityTracker:
    """L(Q) of a matrix that changes module by module; each change costs O(1).

    The one mutable value of this package: searches over thousands of connectors need it. It keeps, as
    integers, the wrong modules of each codeword and format region and the wrong codewords of each block.
    """

    def __init__(self, symbol: Symbol, observed: Matrix | None = None) -> None:
        """Starts from `observed`, or from the correct symbol."""
        observed = symbol.matrix if observed is None else observed
        _check_same_size(observed, symbol)
        at = layout(symbol.version, symbol.level)
        self.symbol = symbol
        self._size = symbol.size
        self._structure = at.blocks
        self._codeword_of: list[int] = at.codeword_of.ravel().tolist()
        self._block_of: list[int] = at.block_of_codeword.tolist()
        self._region_of: list[int] = at.format_region.ravel().tolist()
        self._wrong = bytearray(symbol.size**2)
        self._wrong_in_codeword = [0] * at.blocks.codewords
        self._wrong_in_region = [0] * FORMAT_REGIONS
        self._errors = [0] * at.blocks.count
        self._sum_of_squares = 0
        self._overloaded = 0  # blocks beyond r
        self._damaged = 0  # format regions
        for row, column in np.argwhere(observed.dark ^ symbol.matrix.dark).tolist():
            self.flip(row, column)

    def flip(self, row: int, column: int) -> None:
        """Turns one module from dark to light or back."""
        module = row * self._size + column
        self._wrong[module] ^= 1
        step = 1 if self._wrong[module] else -1
        codeword = self._codeword_of[module]
        if codeword >= 0:
            self._count_in_codeword(codeword, step)
        elif (region := self._region_of[module]) >= 0:
            before = self._wrong_in_region[region]
            self._wrong_in_region[region] = before + step
            self._damaged += (before + step > 0) - (before > 0)

    def _count_in_codeword(self, codeword: int, step: int) -> None:
        before = self._wrong_in_codeword[codeword]
        self._wrong_in_codeword[codeword] = before + step
        change = (before + step > 0) - (before > 0)
        if change:
            block = self._block_of[codeword]
            errors = self._errors[block]
            self._errors[block] = errors + change
            self._sum_of_squares += change * (2 * errors + change)
            capacity = self._structure.capacity
            self._overloaded += (errors + change > capacity) - (errors > capacity)

    @property
    def total(self) -> float:
        """L(Q) of Eq. (1)."""
        if self._overloaded or self._damaged == FORMAT_REGIONS:
            return math.inf
        return _codeword_loss(self._sum_of_squares, 0, self._structure) + _format_loss(self._damaged)

    def preview(self, changes: Iterable[Module]) -> float:
        """L(Q) if these modules (row, column) were flipped; a module named twice stays as it is."""
        modules = list(changes)
        for row, column in modules:
            self.flip(row, column)
        loss = self.total
        for row, column in modules:
            self.flip(row, column)
        return loss

    def readability(self) -> Readability:
        """The whole `Readability` as it stands."""
        return _assess(self._errors, self._damaged, self._structure)

    @property
    def observed(self) -> Matrix:
        """The modules as they stand."""
        wrong = np.frombuffer(bytes(self._wrong), np.uint8).reshape(self._size, self._size)
        return Matrix(self.symbol.matrix.dark ^ wrong.astype(np.bool_))
