"""Tables cut into pieces or closed rings: which entry belongs to which, and which comes next."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from perfqr_cad.geometry.arrays import Indices


def starts_of(counts: Iterable[int] | Indices) -> Indices:
    """Where pieces of so many entries start, and the end, (n + 1,).

    >>> starts_of([3, 0, 2]).tolist()
    [0, 3, 3, 5]
    """
    return np.concatenate([[0], np.cumsum(np.fromiter(counts, np.int64))]).astype(np.int64)


def owners(starts: Indices) -> Indices:
    """For a table that is cut at `starts` (n + 1,): which piece each entry belongs to.

    >>> owners(starts_of([3, 0, 2])).tolist()
    [0, 0, 0, 2, 2]
    """
    return np.repeat(np.arange(len(starts) - 1), np.diff(starts))


def following(starts: Indices) -> Indices:
    """For a table that is cut in rings at `starts` (n + 1,): the entry after each, the first after the last.

    >>> following(starts_of([3, 0, 2])).tolist()
    [1, 2, 0, 4, 3]
    """
    after = np.arange(1, starts[-1] + 1)
    full = np.diff(starts) > 0
    after[starts[1:][full] - 1] = starts[:-1][full]
    return after


def preceding(starts: Indices) -> Indices:
    """The entry before each, the last before the first.

    >>> preceding(starts_of([3, 0, 2])).tolist()
    [2, 0, 1, 4, 3]
    """
    before = np.arange(-1, starts[-1] - 1)
    full = np.diff(starts) > 0
    before[starts[:-1][full]] = starts[1:][full] - 1
    return before


def numbering(size: int, rows: Indices, numbers: Indices | None = None) -> Indices:
    """(size,) the numbers at some rows, their own places unless given; −1 elsewhere.

    >>> numbering(4, np.array([2, 0])).tolist()
    [1, -1, 0, -1]
    """
    found = np.full(size, -1)
    found[rows] = np.arange(len(rows)) if numbers is None else numbers
    return found
