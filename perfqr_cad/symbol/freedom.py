"""All symbols with one payload: the bits after the terminator are free, and Reed-Solomon codes are linear.

The symbols of a payload, version, level and mask are an affine space over GF(2): an origin, and for each
free bit the modules that change colour with it, its own and those of its block's error correction. So as many
modules of a block as it has free bits can be given any colour (R. Cox draws pictures so, "QArt Codes", 2012).
ISO/IEC 18004 §7.4.10 fills those bits with 0xEC, 0x11, …; readers stop at the terminator (§7.4.9).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.symbol.drawing import Symbol
from perfqr_cad.symbol.encoding import interleave
from perfqr_cad.symbol.galois import parity
from perfqr_cad.symbol.layout import Layout, layout
from perfqr_cad.symbol.matrix import BoolArray, read_only
from perfqr_cad.symbol.payload import payload_of
from perfqr_cad.symbol.tables import CODEWORD_BITS

Places = NDArray[np.integer]


@dataclass(frozen=True, eq=False)
class FreeBlock:
    """One block with free bits.

    places (n, 2)  row and column of its modules, most significant bit of the first codeword first
    changes (n,)   of each module the free bits, counted within the block, that change it: bit k of the number
                   stands for the k-th
    bits (f,)      the free bits' places among the data bits of the whole message
    """

    places: Places
    changes: tuple[int, ...]
    bits: Places


@dataclass(frozen=True, eq=False)
class Freedom:
    """The symbols that have the payload, version, level and mask of `symbol`, which is one of them.

    bits (f,)  places of the free bits among the data bits, in the order of the message
    """

    symbol: Symbol
    bits: Places

    @property
    def dimension(self) -> int:
        """How many bits are free: the space has 2 to that power symbols."""
        return len(self.bits)

    @cached_property
    def blocks(self) -> tuple[FreeBlock, ...]:
        """The blocks that have free bits."""
        at = layout(self.symbol.version, self.symbol.level)
        ends = np.cumsum(at.blocks.data) * CODEWORD_BITS
        shares = np.split(self.bits, np.searchsorted(self.bits, ends[:-1]))
        return tuple(
            _free_block(at, block, share, end)
            for block, (share, end) in enumerate(zip(shares, ends.tolist(), strict=True))
            if len(share)
        )

    @cached_property
    def changes(self) -> Mapping[tuple[int, int], tuple[int, int]]:
        """Of each module that can change, by row and column: its block's place, and `FreeBlock.changes`."""
        return {
            (row, column): (number, change)
            for number, block in enumerate(self.blocks)
            for (row, column), change in zip(block.places.tolist(), block.changes, strict=True)
            if change
        }

    @cached_property
    def is_open(self) -> BoolArray:
        """(n, n) modules that differ between symbols of the space."""
        opened = np.zeros((self.symbol.size,) * 2, np.bool_)
        if self.changes:
            opened[tuple(np.array(list(self.changes)).T)] = True
        return read_only(opened)

    def member(self, change: BoolArray) -> Symbol:
        """The symbol in which the (f,) free bits that `change` marks are the other way round."""
        symbol = self.symbol
        bits = np.unpackbits(np.frombuffer(symbol.data, np.uint8))
        bits[self.bits] ^= change.astype(np.uint8)
        codewords = interleave(np.packbits(bits).tobytes(), symbol.version, symbol.level)
        return Symbol(symbol.version, symbol.level, symbol.mask, codewords)


def freedom(symbol: Symbol) -> Freedom:
    """The space of the bits after the terminator of a symbol.

    >>> from perfqr_cad.symbol import encode
    >>> freedom(encode("HELLO", version=2)).dimension
    179
    """
    return Freedom(
        symbol, read_only(np.arange(payload_of(symbol).used_bits, len(symbol.data) * CODEWORD_BITS))
    )


class Wishes:
    """Wishes for colours, granted one after the other for as long as they contradict none before.

    >>> from perfqr_cad.symbol import encode
    >>> wishes = Wishes(freedom(encode("HELLO", version=2)))
    >>> wishes.grant(12, 12, dark=True), wishes.grant(12, 13, dark=True), wishes.grant(12, 13, dark=False)
    (True, True, False)
    >>> wishes.symbol().matrix.dark[12, 12:14].tolist()
    [True, True]
    """

    def __init__(self, space: Freedom) -> None:
        self._space = space
        self._blocks = space.blocks
        self._known: list[dict[int, int]] = [{} for _ in space.blocks]  # equations by their leading bit
        self._dark: list[list[bool]] = space.symbol.matrix.dark.tolist()
        self.left = space.dimension  # bits that are still free

    def grant(self, row: int, column: int, *, dark: bool) -> bool:
        """Whether the module has that colour from now on; if not, it has the other one for good."""
        number, change = self._space.changes.get((row, column), (0, 0))
        known = self._known[number] if change else {}
        flip = dark != self._dark[row][column]
        # The equation: the sum of the free bits in `change` is `flip`; its right side is bit 0.
        equation = change << 1 | flip
        while equation > 1:
            lead = equation.bit_length()
            if lead not in known:
                known[lead] = equation
                self.left -= 1
                return True
            equation ^= known[lead]
        return equation == 0

    def symbol(self) -> Symbol:
        """The symbol of all that was granted; free bits that no wish needed are as in the first one."""
        change = np.zeros(self._space.dimension, np.bool_)
        first = 0
        for block, known in zip(self._blocks, self._known, strict=True):
            solved = 0  # like an equation: bit k + 1 is the k-th free bit
            for lead in sorted(known):  # an equation's other bits are lower: settled before it
                equation = known[lead]
                rest = equation & solved
                if (rest.bit_count() + (equation & 1)) % 2:
                    solved |= 1 << (lead - 1)
            change[first : first + len(block.bits)] = [solved >> (k + 1) & 1 for k in range(len(block.bits))]
            first += len(block.bits)
        return self._space.member(change)


def _free_block(at: Layout, block: int, bits: Places, end: int) -> FreeBlock:
    """A block's modules and what its free bits change; its data bits end before `end`."""
    count, ec = at.blocks.data[block], at.blocks.ec
    words, within = np.divmod(bits - (end - count * CODEWORD_BITS), CODEWORD_BITS)
    changed = np.zeros((len(bits), count + ec), np.uint8)
    changed[np.arange(len(bits)), words] = 128 >> within
    changed[:, count:] = _responses(max(at.blocks.data), ec)[max(at.blocks.data) - count + words, within]
    columns = np.packbits(np.unpackbits(changed, axis=1).T, axis=1, bitorder="little")
    changes = tuple(int.from_bytes(column.tobytes(), "little") for column in columns)
    places = at.modules[at.codewords_of_block(block)].reshape(-1, 2)
    return FreeBlock(places, changes, bits)


@cache
def _responses(count: int, ec: int) -> NDArray[np.uint8]:
    """(count, 8, ec) error correction codewords of a block of `count` data codewords in which one bit is set.

    Leading zeros change no remainder, so shorter blocks are the end of it.
    """
    units = np.zeros((count, CODEWORD_BITS, count), np.uint8)
    words = np.arange(count)
    for bit in range(CODEWORD_BITS):
        units[words, bit, words] = 128 >> bit
    return read_only(parity(units.reshape(-1, count), ec).reshape(count, CODEWORD_BITS, ec))
