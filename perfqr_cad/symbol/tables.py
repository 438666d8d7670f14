"""Numbers of ISO/IEC 18004:2015 that every other module of `symbol` reads.

Levels are the letters L, M, Q, H; versions are 1 to 40; a *codeword* is one byte of the symbol.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Final, Literal

from perfqr_cad.errors import SymbolError

Level = Literal["L", "M", "Q", "H"]

LEVELS: Final[tuple[Level, ...]] = ("L", "M", "Q", "H")
MIN_VERSION: Final = 1
MAX_VERSION: Final = 40
MASKS: Final = 8
QUIET_MODULES: Final = 4  # §6.3.8: width of the quiet zone
CODEWORD_BITS: Final = 8

# Table 9, columns "number of error correction codewords" / "number of blocks", versions 1 to 40.
_EC_PER_BLOCK: Final[dict[Level, tuple[int, ...]]] = {
    "L": (7, 10, 15, 20, 26, 18, 20, 24, 30, 18, 20, 24, 26, 30, 22, 24, 28, 30, 28, 28,
          28, 28, 30, 30, 26, 28, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30),
    "M": (10, 16, 26, 18, 24, 16, 18, 22, 22, 26, 30, 22, 22, 24, 24, 28, 28, 26, 26, 26,
          26, 28, 28, 28, 28, 28, 28, 28, 28, 28, 28, 28, 28, 28, 28, 28, 28, 28, 28, 28),
    "Q": (13, 22, 18, 26, 18, 24, 18, 22, 20, 24, 28, 26, 24, 20, 30, 24, 28, 28, 26, 30,
          28, 30, 30, 30, 30, 28, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30),
    "H": (17, 28, 22, 16, 22, 28, 26, 26, 24, 28, 24, 28, 22, 24, 24, 30, 28, 28, 26, 28,
          30, 24, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30, 30),
}  # fmt: skip
_BLOCKS: Final[dict[Level, tuple[int, ...]]] = {
    "L": (1, 1, 1, 1, 1, 2, 2, 2, 2, 4, 4, 4, 4, 4, 6, 6, 6, 6, 7, 8,
          8, 9, 9, 10, 12, 12, 12, 13, 14, 15, 16, 17, 18, 19, 19, 20, 21, 22, 24, 25),
    "M": (1, 1, 1, 2, 2, 4, 4, 4, 5, 5, 5, 8, 9, 9, 10, 10, 11, 13, 14, 16,
          17, 17, 18, 20, 21, 23, 25, 26, 28, 29, 31, 33, 35, 37, 38, 40, 43, 45, 47, 49),
    "Q": (1, 1, 2, 2, 4, 4, 6, 6, 8, 8, 8, 10, 12, 16, 12, 17, 16, 18, 21, 20,
          23, 23, 25, 27, 29, 34, 34, 35, 38, 40, 43, 45, 48, 51, 53, 56, 59, 62, 65, 68),
    "H": (1, 1, 2, 4, 4, 4, 5, 6, 8, 8, 11, 11, 16, 16, 18, 16, 19, 21, 25, 25,
          25, 34, 30, 32, 35, 37, 40, 42, 45, 48, 51, 54, 57, 60, 63, 66, 70, 74, 77, 81),
}  # fmt: skip

# Table 9, note on p, the codewords kept for misdecode protection; 0 for all others.
_PROTECTION: Final[dict[tuple[int, Level], int]] = {
    (1, "L"): 3, (1, "M"): 2, (1, "Q"): 1, (1, "H"): 1, (2, "L"): 2, (3, "L"): 1,
}  # fmt: skip

# Annex E, Table E.1 differs from an even spacing only in version 32.
_ALIGNMENT_STEP_32: Final = 26

CountBits = tuple[int, int, int]
# Table 3: width of the character count in versions 1-9, 10-26, 27-40.
COUNT_BITS: Final[dict[str, CountBits]] = {
    "numeric": (10, 12, 14),
    "alphanumeric": (9, 11, 13),
    "byte": (8, 16, 16),
    "kanji": (8, 10, 12),
    "hanzi": (8, 10, 12),  # GB/T 18284
}


@dataclass(frozen=True)
class Blocks:
    """How the codewords of one version and level are split (Table 9).

    `data` and `total` are per block, short blocks first; `ec` is the same for every block, and so is the
    capacity r = ⌊(ec − p)/2⌋, the number of erroneous codewords a block is guaranteed to bear.
    """

    data: tuple[int, ...]
    ec: int
    protection: int

    @property
    def count(self) -> int:
        return len(self.data)

    @property
    def data_codewords(self) -> int:
        return sum(self.data)

    @property
    def codewords(self) -> int:
        return self.data_codewords + self.ec * self.count

    @property
    def capacity(self) -> int:
        return (self.ec - self.protection) // 2


def check_version(version: int) -> int:
    """The version itself. SymbolError unless it is 1 to 40."""
    if not MIN_VERSION <= version <= MAX_VERSION:
        raise SymbolError(f"version {version} does not exist: use {MIN_VERSION} to {MAX_VERSION}")
    return version


def check_level(level: str) -> Level:
    """The level itself. SymbolError unless it is L, M, Q or H."""
    for known in LEVELS:
        if level == known:
            return known
    raise SymbolError(f"error correction level {level!r} does not exist: use L, M, Q or H")


def check_mask(mask: int) -> int:
    """The mask itself. SymbolError unless it is 0 to 7."""
    if not 0 <= mask < MASKS:
        raise SymbolError(f"mask {mask} does not exist: use 0 to {MASKS - 1}")
    return mask


def size_of(version: int) -> int:
    """Modules on one side: 17 + 4·version (§6.1).

    >>> size_of(1), size_of(40)
    (21, 177)
    """
    return 17 + 4 * check_version(version)


def version_of(size: int) -> int:
    """Version of a symbol with `size` modules on one side. SymbolError when there is none."""
    version, rest = divmod(size - 17, 4)
    if rest or not MIN_VERSION <= version <= MAX_VERSION:
        raise SymbolError(f"{size} modules on a side is no QR code: sizes are 21, 25, … 177")
    return version


@cache
def alignment_centres(version: int) -> tuple[int, ...]:
    """Row and column coordinates of the centres of the alignment patterns (Annex E)."""
    if check_version(version) == 1:
        return ()
    count = version // 7 + 2
    last = size_of(version) - 7
    step = _ALIGNMENT_STEP_32 if version == 32 else -(-(last - 6) // (2 * (count - 1))) * 2
    return (6, *(last - step * k for k in reversed(range(count - 1))))


def encoding_modules(version: int) -> int:
    """Modules that carry codewords or remainder bits (Table 1, "data modules except (C)")."""
    size = size_of(version)
    aligned = len(alignment_centres(version))
    modules = size * size - 3 * 64 - 2 * (size - 16) - 31  # finders with separators, timing, format
    if aligned:
        modules -= (aligned * aligned - 3) * 25 - (aligned - 2) * 2 * 5  # those on the timing lines overlap
    if version >= 7:
        modules -= 2 * 18  # version information
    return modules


@cache
def blocks(version: int, level: Level) -> Blocks:
    """The block structure of a version and level (Table 9).

    >>> blocks(5, "Q").data, blocks(5, "Q").ec, blocks(5, "Q").capacity
    ((15, 15, 16, 16), 18, 9)
    """
    total = encoding_modules(version) // CODEWORD_BITS
    count = _BLOCKS[level][version - 1]
    ec = _EC_PER_BLOCK[level][version - 1]
    short, longer = divmod(total, count)
    data = tuple(short - ec + (1 if k >= count - longer else 0) for k in range(count))
    return Blocks(data, ec, _PROTECTION.get((version, level), 0))


def count_bits(mode: str, version: int) -> int:
    """Width of the character count indicator (Table 3)."""
    return COUNT_BITS[mode][0 if version <= 9 else 1 if version <= 26 else 2]
