"""Tables cut into pieces or closed rings: which entry belongs to which, and which comes next."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from perfqr_cad.geometry.segments import Indices


def owners(starts: Indices) -> Indices:
    """For a table that is cut at `starts` (n + 1,): which piece each entry belongs to."""
    return np.repeat(np.arange(len(starts) - 1), np.diff(starts))


def starts_of(counts: Iterable[int] | Indices) -> Indices:
    """Where pieces of so many entries start, and the end, (n + 1,)."""
    return np.concatenate([[0], np.cumsum(np.fromiter(counts, np.int64))]).astype(np.int64)


def following(starts: Indices) -> Indices:
    """For a table that is cut in rings at `starts` (n + 1,), none of them empty: the entry after each, the
    first after the last."""
    after = np.arange(1, starts[-1] + 1)
    after[starts[1:] - 1] = starts[:-1]
    return after


def numbering(size: int, rows: Indices, numbers: Indices | None = None) -> Indices:
    """(size,) the numbers at some rows, their own places unless given; −1 elsewhere."""
    found = np.full(size, -1)
    found[rows] = np.arange(len(rows)) if numbers is None else numbers
    return found
