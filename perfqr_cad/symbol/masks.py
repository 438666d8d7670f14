"""The eight data masks and the penalty by which one is chosen (ISO/IEC 18004 §7.8)."""

from __future__ import annotations

from functools import cache
from typing import Final

import numpy as np

from perfqr_cad.symbol.layout import Role, layout
from perfqr_cad.symbol.matrix import BoolArray, read_only
from perfqr_cad.symbol.tables import check_mask, size_of

# Table 11: weights of the four features.
N1: Final = 3
N2: Final = 3
N3: Final = 40
N4: Final = 10
_LONG_RUN: Final = 5  # modules of one colour in a line
_BALANCE_STEP: Final = 20  # one twentieth of the symbol: the standard's 5 %


@cache
def mask_pattern(version: int, mask: int) -> BoolArray:
    """(n, n) modules that a mask turns over: its condition (Table 10) within the encoding region."""
    size = size_of(version)
    i, j = np.ogrid[:size, :size]
    condition = (
        lambda: (i + j) % 2,
        lambda: i % 2 + 0 * j,
        lambda: j % 3 + 0 * i,
        lambda: (i + j) % 3,
        lambda: (i // 2 + j // 3) % 2,
        lambda: i * j % 2 + i * j % 3,
        lambda: (i * j % 2 + i * j % 3) % 2,
        lambda: ((i + j) % 2 + i * j % 3) % 2,
    )[check_mask(mask)]
    return read_only((condition() == 0) & (layout(version, "L").roles >= Role.DATA))


def penalty(dark: BoolArray) -> int:
    """Penalty points of an (n, n) symbol; the mask with the fewest is used (§7.8.3.1).

    The quiet zone counts as light beside a finder-like pattern, and a pattern that is light on both sides
    counts once: so read, the rules give the mask of the standard's own example (Annex I).
    """
    lines = np.vstack([dark, dark.T])
    return _long_runs(lines) + _squares(dark) + _finder_likes(lines) + _imbalance(dark)


def _long_runs(lines: BoolArray) -> int:
    """N1 + excess for each run of five or more in a row or column."""
    breaks = np.ones((lines.shape[0], lines.shape[1] + 1), np.bool_)
    breaks[:, 1:-1] = lines[:, 1:] != lines[:, :-1]
    starts = np.flatnonzero(breaks)  # the last break of a line is next to the first of the following one
    runs = np.diff(starts)
    runs = runs[runs >= _LONG_RUN]
    return int(np.sum(runs - _LONG_RUN + N1))


def _squares(dark: BoolArray) -> int:
    """N2 for each 2 × 2 square of one colour, overlapping ones included."""
    count = dark.astype(np.int8)
    count = count[1:] + count[:-1]
    count = count[:, 1:] + count[:, :-1]
    return N2 * int(np.count_nonzero((count == 0) | (count == 4)))


def _finder_likes(lines: BoolArray) -> int:
    """N3 for each 1:1:3:1:1 in a row or column with four units of light before or after it."""
    quiet = np.pad(lines, ((0, 0), (lines.shape[1], lines.shape[1]))).ravel()
    runs = np.diff(np.flatnonzero(np.diff(quiet, prepend=True, append=True)))  # light, dark, … light
    before, a, b, c, d, e, after = (runs[k : len(runs) - 6 + k : 2] for k in range(7))
    core = (a == b) & (c == 3 * a) & (d == a) & (e == a)
    return N3 * int(np.count_nonzero(core & ((before >= 4 * a) | (after >= 4 * a))))


def _imbalance(dark: BoolArray) -> int:
    """N4 for each full 5 % by which the share of dark modules leaves 50 %."""
    total = dark.size
    excess = abs(2 * int(np.count_nonzero(dark)) - total) * _BALANCE_STEP // 2
    return N4 * max(0, -(-excess // total) - 1)
