"""The search for the place of a code on a host: what is asked for, and what works instead where that does
not."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry.arrays import Array, Indices
from perfqr_cad.hosts.body import Body
from perfqr_cad.hosts.survey import Survey
from perfqr_cad.remedy import Remedy

Triple = tuple[float, float, float]
Problem = Callable[[Survey], str | None]  # why a surveyed wall cannot carry the code, or None

SEED = 0
LADDER = 13  # sizes tried below one that does not work


@dataclass(frozen=True)
class PlaceRequest:
    """Face number (from 1), or where the reader is (mm) and looks, and what points up.

    Raises `DesignError` for lists that are no three finite numbers, and for directions of no length.

    >>> PlaceRequest(point=(0, 0, 9), direction=(0, 0, -2)).look().tolist()
    [0.0, 0.0, -1.0]
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


@dataclass(frozen=True, eq=False)
class Spot:
    """A point (3,) of a host's mesh, the normal (3,) there, and the number of the face."""

    point: Array
    normal: Array
    face: int


@dataclass(frozen=True)
class PlaceSearch(ABC):
    """A search on one host.

    name     of the host, for messages
    problem  why a surveyed wall cannot carry the code, or None
    """

    body: Body
    name: str
    wanted: PlaceRequest
    problem: Problem

    @property
    @abstractmethod
    def on_surface_mm(self) -> float:
        """A given point this near to the surface is on it."""

    @property
    @abstractmethod
    def candidates(self) -> Sequence[Spot]:
        """Spots that may be named where the one that is asked for does not work."""

    @abstractmethod
    def survey_at(self, spot: Spot, size_mm: float) -> Survey | None:
        """The fine survey under a code at a spot; None where no code has a meaning there."""

    @abstractmethod
    def rough_surveys(self, spots: Sequence[Spot], size_mm: float) -> Sequence[Survey | None]:
        """Coarse surveys of many spots."""

    @abstractmethod
    def searched(self, size_mm: float) -> Survey:
        """The survey of the best place where no point is given. Raises `DesignError` where there is none."""

    def place(self, size_mm: float) -> Survey:
        """The survey of the place for a code of that edge.

        Raises `DesignError` with the reason, the largest size that works and, for a given point, the nearest
        place that works.
        """
        return self.searched(size_mm) if self.wanted.point is None else self.judged(self.met(), size_mm)

    def met(self) -> Spot:
        """Where the reader, at the point and looking along the direction, first meets the host.

        A point on the surface itself is taken as it is; without a direction the nearest surface is meant.
        """
        point, look = np.asarray(self.wanted.point, float), self.wanted.look()
        triangle, on = self.body.nearest(point)
        near = self._spot(triangle, on)
        if look is None or np.linalg.norm(on - point) < self.on_surface_mm:
            return near
        entered = self.body.first_entered(point, look)
        if entered is None:
            nearest = f"at {triple(on)}" if self.body.faceted else f"face {near.face + 1} at {triple(on)}"
            raise DesignError(
                f"looking from {triple(point)} along {triple(look)} meets no outer face of {self.name} (the "
                f"nearest is {nearest}): move the point, or give one on the surface"
            )
        return self._spot(*entered)

    def judged(self, spot: Spot, size_mm: float) -> Survey:
        """The survey at a spot. Raises `DesignError` with what would work instead."""
        found = self.survey_at(spot, size_mm)
        reason = "there is no flat enough surface" if found is None else self.problem(found)
        if found is not None and reason is None:
            return found
        largest = largest_below(size_mm, lambda size: self._works(self.survey_at(spot, size)))
        smaller = [Remedy(size_mm=floored(largest))] if largest > 0 else []
        elsewhere = ""
        if (nearest := self._nearest(spot, size_mm)) is not None:
            away = float(np.linalg.norm(nearest.frame.origin - spot.point))
            elsewhere = (
                f"; the nearest place that works is {away:.3g} mm away: point={triple(nearest.frame.origin)} "
                f"direction={triple(-nearest.frame.axes[2])}"
            )
        if not smaller and not elsewhere:
            elsewhere = f"; no place on {self.name} takes it: choose a smaller size"
        raise DesignError(
            f"a code of {size_mm:.4g} mm does not work at {triple(spot.point)}: {reason}{elsewhere}", *smaller
        )

    def sampled(self, count: int, faces: Sequence[int] | None = None) -> list[Spot]:
        """Spots spread evenly over the host or some of its faces."""
        chosen: Indices | None = None if faces is None else np.array(faces)
        points, normals, numbers = self.body.samples(count, SEED, chosen)
        return [Spot(p, n, i) for p, n, i in zip(points, normals, numbers.tolist(), strict=True)]

    def _spot(self, triangle: int, on: Array) -> Spot:
        return Spot(on, self.body.facet_normals[triangle], int(self.body.face_of[triangle]))

    def _works(self, found: Survey | None) -> bool:
        return found is not None and self.problem(found) is None

    def _nearest(self, to: Spot, size_mm: float) -> Survey | None:
        """The survey of the nearest candidate that works; on the same side of the host first, since another
        is rarely what was meant."""
        spots = sorted(
            self.candidates,
            key=lambda spot: (spot.normal @ to.normal < 0.5, float(np.linalg.norm(spot.point - to.point))),
        )
        for spot, rough in zip(spots, self.rough_surveys(spots, size_mm), strict=True):
            if self._works(rough) and self._works(fine := self.survey_at(spot, size_mm)):
                return fine
        return None


def largest_below(size_mm: float, works: Callable[[float], bool]) -> float:
    """The largest size below the given one that works, to 1 %; 0 when none of a few does.

    Sizes are tried from above: a wall that is thin for a wide module is a block for a narrow one.

    >>> 9.6 < largest_below(40.0, lambda size_mm: size_mm < 10.0) < 10.0
    True
    """
    steps = np.linspace(1.0, 0.1, LADDER)
    for high, low in pairwise((steps * size_mm).tolist()):
        if not works(low):
            continue
        while high - low > 0.01 * size_mm:
            middle = (low + high) / 2
            low, high = (middle, high) if works(middle) else (low, middle)
        return low
    return 0.0


def floored(size_mm: float) -> float:
    """A size for people, no greater than it is, in few digits.

    >>> floored(123.4567)
    123.45
    """
    return math.floor(size_mm * 100) / 100


def triple(v: ArrayLike) -> str:
    """A point or direction for people; what is zero but for rounding is zero.

    >>> triple((-1e-12, 2, 1 / 3))
    '(0,2,0.3333)'
    """
    return "(" + ",".join(f"{x:.4g}" for x in np.round(np.asarray(v, float), 9) + 0.0) + ")"
