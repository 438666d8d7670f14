"""The frame of a code on a host: where its centre is, and its axes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry.arrays import Array


@dataclass(frozen=True)
class Frame:
    """Where the code's centre lies, mm, and how it is turned: origin (3,), rows e1 (right), e2 (up) and n (to
    the reader).

    >>> Frame.at((0, 0, 10), (0, 0, 2)).to_frame([(1, 2, 10)]).tolist()
    [[1.0, 2.0, 0.0]]
    """

    origin: Array
    axes: Array

    @staticmethod
    def at(origin: ArrayLike, normal: ArrayLike, up: ArrayLike | None = None) -> Frame:
        """A frame whose e2 follows `up` (default +z, or +y where the face looks along z)."""
        n = np.asarray(normal, float) / np.linalg.norm(normal)
        tries = [up] if up is not None else [(0.0, 0.0, 1.0), (0.0, 1.0, 0.0)]
        for wanted in tries:
            e2 = np.asarray(wanted, float) - np.dot(wanted, n) * n
            if np.linalg.norm(e2) > 0.1 * np.linalg.norm(wanted):
                e2 /= np.linalg.norm(e2)
                return Frame(np.asarray(origin, float), np.asarray(np.stack([np.cross(e2, n), e2, n]), float))
        raise DesignError(
            f"up={_vector(tries[0])} points along the face's normal: choose another up direction"
        )

    def to_space(self, xyh: ArrayLike) -> Array:
        """Points (k, 3) of space from frame coordinates (k, 3)."""
        return self.origin + np.asarray(xyh, float) @ self.axes

    def to_frame(self, points: ArrayLike) -> Array:
        """Frame coordinates (k, 3) of points of space."""
        return (np.asarray(points, float) - self.origin) @ self.axes.T

    def turned(self, angle_deg: float) -> Frame:
        """The frame turned counter-clockwise about its normal."""
        c, s = np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))
        return Frame(self.origin, np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]) @ self.axes)


def frame_at(origin: ArrayLike, normal: ArrayLike, up: ArrayLike | None) -> Frame | None:
    """`Frame.at`, or None where the wanted for `up` runs along the normal."""
    try:
        return Frame.at(origin, normal, up)
    except DesignError:
        return None


def _vector(v: ArrayLike) -> str:
    return "(" + ", ".join(f"{x:.4g}" for x in np.asarray(v, float)) + ")"
