"""The shortest cut of a text into segments of different modes (ISO/IEC 18004 §7.4; Annex J approximates it).

A dynamic programme over the letters, exact in bits: the idea is that of Nayuki, "Optimal text segmentation
for QR Codes" (2018).
"""

from __future__ import annotations

from itertools import groupby, islice
from typing import Final, Literal

from perfqr_cad.symbol.payload import ALPHANUMERIC
from perfqr_cad.symbol.tables import count_bits

AsciiMode = Literal["numeric", "alphanumeric", "byte"]

_MODE_BITS: Final = 4
_SIXTHS: Final = 6  # of a bit: digits take 10/3 bits and alphanumeric letters 11/2
_SIXTHS_OF: Final[dict[AsciiMode, int]] = {"numeric": 20, "alphanumeric": 33, "byte": 48}
_LETTERS: Final[dict[AsciiMode, str]] = {"numeric": "0123456789", "alphanumeric": ALPHANUMERIC}


def segmentation(text: str, version: int, fnc1: bool = False) -> tuple[tuple[AsciiMode, str], ...]:
    """Modes and letters of the segments of an ASCII text that need the fewest bits in symbols of a version.

    fnc1  "%" stays in bytes: behind FNC1 it means a separator in alphanumeric mode (§7.4.8.2)

    >>> segmentation("https://example.com/p/1234567", 3)
    (('byte', 'https://example.com/p/'), ('numeric', '1234567'))
    """
    heads = {mode: (_MODE_BITS + count_bits(mode, version)) * _SIXTHS for mode in _SIXTHS_OF}
    # Of the letters so far, by the mode of the last: cost in sixths of a bit, and the mode of each letter.
    best: dict[AsciiMode, tuple[int, tuple[AsciiMode, ...]]] = {}
    for letter in text:
        best = {mode: _extended(best, mode, heads[mode]) for mode in _modes_of(letter, fnc1)}
    modes = min(best.values(), key=lambda way: _whole(way[0]))[1]
    letters = iter(text)
    runs: list[tuple[AsciiMode, int]] = [(mode, len(list(run))) for mode, run in groupby(modes)]
    return tuple((mode, "".join(islice(letters, count))) for mode, count in runs)


def _modes_of(letter: str, fnc1: bool) -> list[AsciiMode]:
    if fnc1 and letter == "%":
        return ["byte"]
    return [mode for mode in _SIXTHS_OF if letter in _LETTERS.get(mode, letter)]


def _extended(
    best: dict[AsciiMode, tuple[int, tuple[AsciiMode, ...]]], mode: AsciiMode, head: int
) -> tuple[int, tuple[AsciiMode, ...]]:
    """The cheapest way to go on with one more letter in this mode."""
    ways = [
        (cost if last == mode else _whole(cost) + head, modes) for last, (cost, modes) in best.items()
    ] or [(head, ())]
    cost, modes = min(ways, key=lambda way: way[0])
    return cost + _SIXTHS_OF[mode], (*modes, mode)


def _whole(sixths: int) -> int:
    """Rounded up to whole bits, where a segment ends."""
    return -(-sixths // _SIXTHS) * _SIXTHS
