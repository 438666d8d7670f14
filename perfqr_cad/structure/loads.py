"""What pushes on the part, and what holds it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

from perfqr_cad.errors import AnalysisError

STANDARD_GRAVITY_MM_S2 = 9806.65  # ISO 80000-3
FINGERTIP_RADIUS_MM = 8.0  # contact radius of a firmly pressed finger, about 16 mm across


@dataclass(frozen=True)
class Pressure:
    """Uniform pressure on the front face along the inward normal (§5.2 of the paper), in MPa."""

    pressure_mpa: float

    def __post_init__(self) -> None:
        require_finite("pressure", self.pressure_mpa, "MPa")


@dataclass(frozen=True)
class Finger:
    """A force in N spread over a disc on the front face, along the inward normal.

    `at_mm` is the centre in the pattern plane; None looks for the worst place on the part. Holes inside
    the disc carry nothing: the material under the finger takes the whole force.
    """

    force_n: float
    radius_mm: float = FINGERTIP_RADIUS_MM
    at_mm: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        require_finite("finger force", self.force_n, "N")
        if not (math.isfinite(self.radius_mm) and self.radius_mm > 0.0):
            raise AnalysisError(f"finger radius is {self.radius_mm} mm; it must be a positive number")


@dataclass(frozen=True)
class Weight:
    """The part's own weight. `direction` is gravity in the placement's space; None is the worst for a
    plate, straight into the front face."""

    direction: tuple[float, float, float] | None = None
    gravities: float = 1.0

    def __post_init__(self) -> None:
        require_finite("acceleration", self.gravities, "g")
        if self.direction is not None and not math.hypot(*self.direction) > 0.0:
            raise AnalysisError(f"gravity direction is {self.direction}; it must have a length")


Load = Pressure | Finger | Weight


class Hold(StrEnum):
    """How the outer boundary of the part is held."""

    CLAMPED = "clamped"  # every point of the outer boundary, displacement and rotation: the paper's
    SIMPLE = "simple"  # every point of the outer boundary, displacement only
    TWO_SIDES = "two-sides"  # the left and the right edge, clamped
    CORNERS = "corners"  # four square pads in the corners of the bounding box, clamped
    FREE = "free"  # in the hand: each load is balanced by the hand that holds against it

    @property
    def pinned(self) -> bool:
        """Whether the held boundary is free to rotate."""
        return self is Hold.SIMPLE


LARGEST = 1e9  # of a load in its unit: far beyond any part, far within the range of a double
CORNER_PAD_FRACTION = 0.05  # of the smaller edge: a screw head at the corner of a sign


@dataclass(frozen=True)
class Support:
    """A way of holding the part; `pad_mm` is the edge of the corner pads (None: 5 % of the part)."""

    hold: Hold = Hold.CLAMPED
    pad_mm: float | None = None

    def __post_init__(self) -> None:
        if self.pad_mm is not None and not (math.isfinite(self.pad_mm) and self.pad_mm > 0.0):
            raise AnalysisError(f"corner pad is {self.pad_mm} mm; it must be a positive number")

    @staticmethod
    def named(name: str) -> Support:
        """The support of that name.

        Raises:
            AnalysisError: no such support; the message lists those there are.
        """
        if name not in {*Hold}:
            raise AnalysisError(f"support {name!r} is unknown; choose one of {', '.join(Hold)}")
        return Support(Hold(name))


def require_finite(label: str, value: float, unit: str) -> None:
    """Refuse what is no number or beyond any part."""
    if not abs(value) <= LARGEST:
        raise AnalysisError(
            f"{label} is {value} {unit}; it must be a finite number of no more than {LARGEST:g} {unit}"
        )
