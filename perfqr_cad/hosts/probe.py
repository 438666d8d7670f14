"""Straight lines through a wall: where they enter it, how much material follows, what stands before."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from perfqr_cad.geometry.arrays import Array, Indices, Mask
from perfqr_cad.hosts.body import Body


@dataclass(frozen=True)
class Probe:
    """What lines through a wall meet, (k,) each: the front is the entry nearest to the line's reference
    point.

    offset_mm  of the front from the reference point, along the line towards the reader; NaN for no front
    wall_mm    material behind the front, NaN where its far side was not found
    normal     (k, 3) of the front
    front, back  numbers of the faces, -1 for none
    hidden     something of the part stands before the front
    """

    offset_mm: Array
    wall_mm: Array
    normal: Array
    front: Indices
    back: Indices
    hidden: Mask


def probe(body: Body, points: Array, towards_reader: Array) -> Probe:
    """Follow lines (unit directions) through reference points from outside the body inwards."""
    count = len(points)
    start = 2.0 * body.diagonal_mm + float(np.linalg.norm(points - body.centre_mm, axis=1).max())
    found = body.crossings(points + start * towards_reader, -towards_reader)
    offset = start - found.distance_mm
    entries = np.flatnonzero(found.entering)
    nearest = entries[np.lexsort((np.abs(offset[entries]), found.ray[entries]))]
    rays, first = np.unique(found.ray[nearest], return_index=True)
    at = nearest[first]
    # Crossings are sorted along each line: the wall's far side is the next one, unless the line ends.
    following = np.minimum(at + 1, len(offset) - 1)
    through = (following > at) & (found.ray[following] == found.ray[at]) & ~found.entering[following]
    before = np.maximum(at - 1, 0)

    def spread(value: ArrayLike, empty: float, kind: type = float) -> NDArray:
        out = np.full(count, empty, dtype=kind)
        out[rays] = value
        return out

    normal = np.zeros((count, 3))
    normal[rays] = found.normal[at]
    return Probe(
        spread(offset[at], np.nan),
        spread(np.where(through, offset[at] - offset[following], np.nan), np.nan),
        normal,
        spread(body.face_of[found.triangle[at]], -1, int),
        spread(np.where(through, body.face_of[found.triangle[following]], -1), -1, int),
        spread((before < at) & (found.ray[before] == found.ray[at]), False, bool),
    )
