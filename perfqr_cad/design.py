"""The pipeline: a `Request` becomes a `Design`, once round the chain.

    text | picture -> symbol -> pattern -> placement -> strength -> solid -> scan

`make` is the only place where the links meet; every link is a free function of its own layer.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any, Protocol

from perfqr_cad.errors import DesignError

if TYPE_CHECKING:
    from perfqr_cad.capture import Capture
    from perfqr_cad.pattern import Pattern
    from perfqr_cad.scan import ScanReport
    from perfqr_cad.solid import Solid, Walls
    from perfqr_cad.structure import Reinforcement, StressField
    from perfqr_cad.surface import Placement
    from perfqr_cad.symbol import Symbol

Progress = Callable[[str], None]


class Target(Protocol):
    """What the code is carved into."""

    def placement(self, size_mm: float) -> Placement:
        """Where a code of this edge (quiet zone included) lies."""
        ...

    def solid(self, pattern: Pattern, placement: Placement, walls: Walls) -> Solid:
        """The finished part."""
        ...


@dataclass(frozen=True)
class Request:
    """Everything a user can ask for. Lengths in mm, pressure and stress in MPa, angles in degrees.

    `size_mm` is the edge of the whole code with its quiet zone; None takes the smallest that the nozzle
    prints. `yield_mpa` None takes the material's. Raises `DesignError` for values that cannot be meant.
    """

    text: str | None = None
    image: str | None = None
    name: str = "perforated-qr"
    level: str = "M"
    version: int | None = None
    mask: int | None = None
    size_mm: float | None = None
    thickness_mm: float = 1.6
    nozzle_mm: float = 0.4
    quiet_modules: int = 4
    style: str = "square"
    fillet_mm: float | None = None
    tone: str = "normal"
    finder: str = "panel"
    objective: str = "optimal"
    draft_deg: float = 0.0
    lip_mm: float = 0.0
    material: str = "PLA"
    pressure_mpa: float = 5e-6
    support: str = "clamped"
    yield_mpa: float | None = None
    method: str = "optimal"
    seed: int = 0

    def __post_init__(self) -> None:
        if (self.text is None) == (self.image is None):
            raise DesignError("give either a text or a picture (--image FILE), and not both")
        if self.text is not None and not self.text:
            raise DesignError("the text is empty: give at least 1 character")
        for entry in fields(self):
            value = getattr(self, entry.name)
            if isinstance(value, float) and not math.isfinite(value):
                raise DesignError(f"{entry.name}={value} is not a finite number")
        for name, low, high in _LIMITS:
            value = getattr(self, name)
            if value is not None and not low <= value <= high:
                raise DesignError(f"{name}={value:g} is outside {low:g} to {high:g}: choose a value within")


# Name, least, most. Upper ends are far beyond any printer or cutter; they catch slips of unit.
_LIMITS: tuple[tuple[str, float, float], ...] = (
    ("size_mm", 1.0, 10_000.0),
    ("thickness_mm", 0.05, 500.0),
    ("nozzle_mm", 0.01, 10.0),
    ("quiet_modules", 0, 20),
    ("fillet_mm", 0.0, 100.0),
    ("draft_deg", 0.0, 60.0),
    ("lip_mm", 0.0, 500.0),
    ("pressure_mpa", 0.0, 1000.0),
    ("yield_mpa", 1e-3, 1e5),
)


@dataclass(frozen=True)
class Sheet:
    """A wall of even thickness on an analytic placement."""

    surface: Placement

    def placement(self, size_mm: float) -> Placement:
        del size_mm
        return self.surface

    def solid(self, pattern: Pattern, placement: Placement, walls: Walls) -> Solid:
        from perfqr_cad.solid import build

        return build(pattern, placement, walls)


@dataclass(frozen=True)
class Design:
    """A finished part with everything that was measured on the way. Exporters read only this."""

    request: Request
    capture: Capture | None
    symbol: Symbol
    pattern: Pattern
    placement: Placement
    reinforcement: Reinforcement
    solid: Solid
    scan: ScanReport
    timings_s: dict[str, float] = field(default_factory=dict[str, float])
    files: tuple[dict[str, Any], ...] = ()

    @property
    def stress(self) -> StressField:
        """The stress field of the finished part."""
        return self.reinforcement.after
