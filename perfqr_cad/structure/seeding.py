"""Nodes along an outline: fine at re-entrant corners, where stress is singular, coarse between them.

A mesher that is given these nodes fills the inside to match, so the grading is set here and nowhere else.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.structure.t6 import Floats

REENTRANT_DEG = 50.0  # a gentler bend, as between two chords of a fillet, needs no finer mesh
GROWTH = 2.0  # length of an edge over that of the one nearer to the corner


def seed(outline: Floats, size_mm: float, corner_mm: float) -> Floats:
    """The points (k, 2) of a loop with material on its left, and nodes between them.

    Edges start with `corner_mm` at re-entrant corners and grow to `size_mm`.
    """
    fine = reentrant(outline)
    pieces: list[Floats] = []
    for a, b, fine_a, fine_b in zip(outline, np.roll(outline, -1, 0), fine, np.roll(fine, -1), strict=True):
        length = float(np.hypot(*(b - a)))
        at = _stations(length, size_mm, corner_mm if fine_a else size_mm, corner_mm if fine_b else size_mm)
        pieces.append(a + at[:, None] * (b - a) / length)
    return np.concatenate(pieces)


def reentrant(outline: Floats) -> NDArray[np.bool_]:
    """Which corners of a loop with material on its left stick into the material."""
    before, after = outline - np.roll(outline, 1, axis=0), np.roll(outline, -1, axis=0) - outline
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    turn = np.arctan2(cross, np.einsum("kc,kc->k", before, after))
    return turn < -np.radians(REENTRANT_DEG)


def _stations(length: float, size: float, first: float, last: float) -> Floats:
    """Where nodes lie along an edge, from 0 and short of its length: growing from both ends."""
    head, tail = [0.0], [length]
    while True:
        left = tail[-1] - head[-1]
        step = min(first, last)
        if left <= 1.5 * step or step >= size:
            break
        if first <= last:
            head.append(head[-1] + first)
            first = min(GROWTH * first, size)
        else:
            tail.append(tail[-1] - last)
            last = min(GROWTH * last, size)
    left = tail[-1] - head[-1]
    parts = max(1, round(left / min(first, last, size)))
    middle = head[-1] + left * np.arange(1, parts) / parts
    return np.array([*head, *middle, *reversed(tail[1:])])
