"""What every module of a symbol is for, and its codeword and block (ISO/IEC 18004 §6.3, §7.7).

Format regions. The paper (§4.1, Eq. 3) speaks of four *format regions*; the standard (§7.9.1) of one
15-bit word drawn twice. Each copy is two straight arms, so there are four, numbered

    0  column 8, rows 0-8        bits 0-7 of copy 1      1  row 8, columns 0-7       bits 8-14 of copy 1
    2  row 8, last 8 columns     bits 0-7 of copy 2      3  column 8, last 7 rows    bits 8-14 of copy 2

A region is damaged when any of its modules differs from Q₀. One whole region is enough to know the word:
the (15, 5) BCH code is cyclic, so any five consecutive bits tell its 32 words apart. The module above
region 3, always dark, carries nothing and belongs to no region.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.symbol.matrix import BoolArray, read_only
from perfqr_cad.symbol.tables import (
    CODEWORD_BITS,
    Blocks,
    Level,
    alignment_centres,
    blocks,
    check_level,
    size_of,
)

IntArray = NDArray[np.int32]

FORMAT_BITS = 15
FORMAT_REGIONS = 4
VERSION_BITS = 18
FIRST_VERSION_WITH_INFO = 7  # §7.10


class Role(IntEnum):
    """What a module is for. `DARK` is the one always-dark module; it belongs to no format region."""

    FINDER = 0
    SEPARATOR = 1
    TIMING = 2
    ALIGNMENT = 3
    FORMAT = 4
    VERSION = 5
    DARK = 6
    DATA = 7
    EC = 8
    REMAINDER = 9


@dataclass(frozen=True, eq=False)
class Layout:
    """The map of one version and level. All (n, n) arrays are indexed [row, column]; −1 means none.

    roles (n, n)           `Role` of each module
    codeword_of (n, n)     index of the module's codeword in placed (interleaved) order
    bit_of (n, n)          bit of that codeword, 7 = most significant
    format_region (n, n)   0-3, see the module's docstring
    function_dark (n, n)   colour of the function patterns, version and dark module; False elsewhere
    modules (C, 8, 2)      row and column of each codeword's modules, most significant bit first
    remainder (k, 2)       row and column of the remainder bits
    block_of_codeword (C,) block of each placed codeword
    place_in_block (C,)    its index in that block: data codewords first, then error correction
    format_modules (2, 15, 2)  copy, bit (0 = least significant), row and column
    version_modules (2, 18, 2) the same for version information; (2, 0, 2) below version 7

    `groups` and `codewords_of_block` are the way back from blocks to codewords.
    """

    version: int
    level: Level
    blocks: Blocks
    roles: IntArray
    codeword_of: IntArray
    bit_of: IntArray
    format_region: IntArray
    function_dark: BoolArray
    modules: IntArray
    remainder: IntArray
    block_of_codeword: IntArray
    place_in_block: IntArray
    format_modules: IntArray
    version_modules: IntArray

    @property
    def size(self) -> int:
        return size_of(self.version)

    @cached_property
    def block_of(self) -> IntArray:
        """(n, n) block of each module, −1 for modules outside the codewords."""
        return read_only(np.where(self.codeword_of >= 0, self.block_of_codeword[self.codeword_of], -1))

    @cached_property
    def groups(self) -> tuple[IntArray, ...]:
        """Short blocks, then long ones if any: (b, n) placed indices of b blocks of n codewords.

        Rows are in the order of the blocks, columns in the block's own order: data, then error correction.
        """
        order = np.lexsort((self.place_in_block, self.block_of_codeword)).astype(np.int32)
        short = min(self.blocks.data)
        count = self.blocks.data.count(short)
        split = count * (short + self.blocks.ec)
        groups = [order[:split].reshape(count, -1)]
        if count < self.blocks.count:
            groups.append(order[split:].reshape(self.blocks.count - count, -1))
        return tuple(read_only(group) for group in groups)

    def codewords_of_block(self, block: int) -> IntArray:
        """Placed indices of a block's codewords, in the block's own order."""
        short = len(self.groups[0])
        return self.groups[0][block] if block < short else self.groups[1][block - short]


@cache
def layout(version: int, level: Level) -> Layout:
    """The map of a version and level; computed once."""
    size = size_of(version)
    structure = blocks(version, check_level(level))
    roles, dark = _function_patterns(version)
    free = np.argwhere(roles[tuple(_zigzag(size).T)] < 0)[:, 0]
    path = _zigzag(size)[free]
    carried = structure.codewords * CODEWORD_BITS
    modules = path[:carried].reshape(-1, CODEWORD_BITS, 2)
    block_of, place_in = _interleaving(structure)
    codeword_of = np.full((size, size), -1, np.int32)
    bit_of = codeword_of.copy()
    rows, columns = modules[..., 0], modules[..., 1]
    codeword_of[rows, columns] = np.arange(len(modules))[:, None]
    bit_of[rows, columns] = np.arange(CODEWORD_BITS)[::-1]
    is_data = place_in < np.asarray(structure.data)[block_of]
    roles[rows, columns] = np.where(is_data, Role.DATA, Role.EC)[:, None]
    remainder = path[carried:]
    roles[remainder[:, 0], remainder[:, 1]] = Role.REMAINDER
    arrays = (roles, codeword_of, bit_of, _format_regions(size), dark, modules, remainder, block_of, place_in)
    places = (_format_modules(size), _version_modules(version))
    return Layout(version, level, structure, *map(read_only, arrays + places))


def _function_patterns(version: int) -> tuple[IntArray, BoolArray]:
    """Roles (−1 where codewords go) and colours of the function patterns, format left light (§6.3)."""
    size = size_of(version)
    roles = np.full((size, size), -1, np.int32)
    dark = np.zeros((size, size), np.bool_)
    for at in (np.s_[6, :], np.s_[:, 6]):
        roles[at] = Role.TIMING
        dark[at] = np.arange(size) % 2 == 0
    for row, column in _alignment_pattern_centres(version):
        roles[row - 2 : row + 3, column - 2 : column + 3] = Role.ALIGNMENT
        dark[row - 2 : row + 3, column - 2 : column + 3] = _rings(2) != 1
    finder = np.pad(_rings(3) != 2, 1)  # with its separator
    kind = np.where(np.pad(np.ones((7, 7), np.bool_), 1), Role.FINDER, Role.SEPARATOR)
    for top, left in ((-1, -1), (-1, size - 8), (size - 8, -1)):
        at = np.s_[max(top, 0) : top + 9, max(left, 0) : left + 9]
        part = np.s_[max(-top, 0) : size - top, max(-left, 0) : size - left]
        roles[at], dark[at] = kind[part], finder[part]
    for places, role in ((_format_modules(size), Role.FORMAT), (_version_modules(version), Role.VERSION)):
        roles[places[..., 0], places[..., 1]] = role
    roles[size - 8, 8], dark[size - 8, 8] = Role.DARK, True
    if version >= FIRST_VERSION_WITH_INFO:
        places = _version_modules(version)
        dark[places[..., 0], places[..., 1]] = version_word(version) >> np.arange(VERSION_BITS) & 1
    return roles, dark


def _rings(radius: int) -> IntArray:
    """Chebyshev distance from the centre of a square of side 2·radius + 1."""
    steps = np.abs(np.arange(-radius, radius + 1, dtype=np.int32))
    return np.maximum(steps[:, None], steps[None, :])


def _alignment_pattern_centres(version: int) -> list[tuple[int, int]]:
    """All pairs of Annex E coordinates but the three that finders occupy."""
    centres = alignment_centres(version)
    taken = {(6, 6), (6, size_of(version) - 7), (size_of(version) - 7, 6)}
    return [(row, column) for row in centres for column in centres if (row, column) not in taken]


def _zigzag(size: int) -> IntArray:
    """All modules right of and left of the vertical timing line in the order of §7.7.3."""
    rights = [column if column > 6 else column - 1 for column in range(size - 1, 0, -2)]
    path = np.empty((len(rights), size, 2, 2), np.int32)
    upwards = np.arange(size)[::-1]
    for k, right in enumerate(rights):
        path[k, :, :, 0] = (upwards if k % 2 == 0 else upwards[::-1])[:, None]
        path[k, :, :, 1] = (right, right - 1)
    return path.reshape(-1, 2)


def _interleaving(structure: Blocks) -> tuple[IntArray, IntArray]:
    """Block, and index in the block, of each codeword in placed order (§7.6)."""
    data = [(b, k) for k in range(max(structure.data)) for b, n in enumerate(structure.data) if k < n]
    ec = [(b, structure.data[b] + k) for k in range(structure.ec) for b in range(structure.count)]
    pairs = np.array(data + ec, np.int32)
    return pairs[:, 0].copy(), pairs[:, 1].copy()


def _format_modules(size: int) -> IntArray:
    """Places of both copies of the format word, bit 0 first (Figure 25)."""
    first = [(row, 8) for row in (0, 1, 2, 3, 4, 5, 7, 8)] + [(8, column) for column in (7, 5, 4, 3, 2, 1, 0)]
    second = [(8, size - 1 - k) for k in range(8)] + [(size - 7 + k, 8) for k in range(7)]
    return np.array([first, second], np.int32)


def _format_regions(size: int) -> IntArray:
    region = np.full((size, size), -1, np.int32)
    for copy, places in enumerate(_format_modules(size)):
        region[places[:8, 0], places[:8, 1]] = 2 * copy
        region[places[8:, 0], places[8:, 1]] = 2 * copy + 1
    return region


def _version_modules(version: int) -> IntArray:
    """Places of both copies of the version word, bit 0 first (Figure 28)."""
    if version < FIRST_VERSION_WITH_INFO:
        return np.zeros((2, 0, 2), np.int32)
    bit = np.arange(VERSION_BITS, dtype=np.int32)
    upright = np.stack([bit // 3, size_of(version) - 11 + bit % 3], axis=1)
    return np.stack([upright[:, ::-1], upright])


@cache
def version_word(version: int) -> int:
    """The 18-bit version information, (18, 6) Golay code (Annex D)."""
    remainder = version
    for _ in range(12):
        remainder = (remainder << 1) ^ (remainder >> 11) * 0x1F25
    return version << 12 | remainder
