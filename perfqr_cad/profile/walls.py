"""How the walls of the holes run through the material."""

from __future__ import annotations

import math
from dataclasses import dataclass

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry.outline import LEAST_MM
from perfqr_cad.remedy import Remedy

MOST_DRAFT_DEG = 60.0  # beyond it the holes of neighbouring modules meet long before the back of any plate


@dataclass(frozen=True)
class Walls:
    """Walls of the holes, from the reader's side inwards.

    draft_deg   flare of the walls towards the back, from the normal, so that walls do not hide the holes
    lip_mm      straight piece behind the front before the flare begins
    depth_mm    None for through-holes; else the depth of blind pockets, which leave a floor at the back
    or_straight whether walls that cannot flare anywhere are straight instead, which is noted, not an error

    >>> pockets = Walls(depth_mm=0.8)
    >>> pockets.reach_mm(2.0), Walls().reach_mm(2.0)
    (0.8, 2.0)
    >>> round(Walls(draft_deg=45, lip_mm=0.5).flare_mm(2.0), 9)
    1.5
    """

    draft_deg: float = 0.0
    lip_mm: float = 0.0
    depth_mm: float | None = None
    or_straight: bool = False

    def __post_init__(self) -> None:
        if not (math.isfinite(self.draft_deg) and 0 <= self.draft_deg <= MOST_DRAFT_DEG):
            raise DesignError(
                f"draft {self.draft_deg:g}° is outside 0° to {MOST_DRAFT_DEG:g}°: choose one within"
            )
        if not (math.isfinite(self.lip_mm) and self.lip_mm >= 0):
            raise DesignError(f"lip {self.lip_mm:g} mm is not a length of 0 mm or more")
        if self.depth_mm is not None and not (math.isfinite(self.depth_mm) and self.depth_mm > 0):
            raise DesignError(f"depth {self.depth_mm:g} mm is not above 0 mm")

    def require_fit(self, thickness_mm: float) -> None:
        """Raises `DesignError` for pockets or a lip deeper than a wall of that thickness has room for."""
        self.flare_mm(self.reach_mm(thickness_mm))

    def reach_mm(self, thickness_mm: float) -> float:
        """Depth of the holes in a wall of that thickness. Raises `DesignError` when there is no floor
        left."""
        if self.depth_mm is None:
            return thickness_mm
        if self.depth_mm >= thickness_mm:
            raise DesignError(
                f"pockets of {self.depth_mm:g} mm leave no floor in {thickness_mm:g} mm",
                f"a depth below {thickness_mm:g} mm",
                Remedy(depth_mm=None),
            )
        return self.depth_mm

    def flare_mm(self, reach_mm: float) -> float:
        """How far a hole is wider at its far end than at the front, to each side, mm."""
        flared = reach_mm - self.lip_mm
        if self.draft_deg == 0:
            return 0.0
        if flared <= LEAST_MM:
            raise DesignError(
                f"a lip of {self.lip_mm:g} mm leaves nothing to flare in holes {reach_mm:g} mm deep",
                f"a lip below {reach_mm:g} mm",
                Remedy(lip_mm=None, draft_deg=0.0),
            )
        flare = flared * math.tan(math.radians(self.draft_deg))
        return flare if flare > LEAST_MM else 0.0
