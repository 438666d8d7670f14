"""What the user says about the place of a code on a part."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from perfqr_cad.errors import DesignError
from perfqr_cad.hosts.body import Array

Triple = tuple[float, float, float]


@dataclass(frozen=True)
class Wish:
    """Face number (from 1), or where the reader is (mm) and looks, and what points up.

    Raises `DesignError` for lists that are no three finite numbers, and for directions of no length.
    """

    face: int | None = None
    point: Triple | None = None
    direction: Triple | None = None
    up: Triple | None = None

    def __post_init__(self) -> None:
        for name in ("point", "direction", "up"):
            value = getattr(self, name)
            if value is None:
                continue
            numbers = np.asarray(value, float)
            if numbers.shape != (3,) or not np.isfinite(numbers).all():
                raise DesignError(f"{name}={value} is not three numbers: give x,y,z in mm")
            if name != "point" and not np.linalg.norm(numbers) > 0:
                raise DesignError(f"{name}={triple(numbers)} has no length: give a direction")

    def look(self) -> Array | None:
        """Unit direction (3,) in which the reader looks."""
        if self.direction is None:
            return None
        look = np.asarray(self.direction, float)
        return look / np.linalg.norm(look)


def floored(size_mm: float) -> str:
    """A size for people, no greater than it is, in few digits."""
    return f"{np.floor(size_mm * 100) / 100:.4g}"


def triple(v: ArrayLike) -> str:
    """A point or direction for people; what is zero but for rounding is zero."""
    return "(" + ",".join(f"{x:.4g}" for x in np.round(np.asarray(v, float), 9) + 0.0) + ")"
