"""A dark plate behind the part, for codes that are read before no dark ground."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry.outline import Circle, Loop, Region
from perfqr_cad.profile.colour import DARK, Colour
from perfqr_cad.profile.loft import Level, Loft
from perfqr_cad.profile.sections import Sections, halved
from perfqr_cad.surface import Placement

PROBES = 21  # lines each way at which a bent wall is asked whether it goes on so far behind


@dataclass(frozen=True)
class Backing:
    """A plate that follows the back of the part.

    gap_mm  between the back of the part and the plate; 0: touching

    >>> Backing(thickness_mm=0.0)
    Traceback (most recent call last):
    perfqr_cad.errors.DesignError: a backing 0 mm thick: give a number above 0
    """

    thickness_mm: float = 1.0
    gap_mm: float = 0.0
    colour: Colour = DARK

    def __post_init__(self) -> None:
        if not (math.isfinite(self.thickness_mm) and self.thickness_mm > 0):
            raise DesignError(f"a backing {self.thickness_mm:g} mm thick: give a number above 0")
        if not (math.isfinite(self.gap_mm) and self.gap_mm >= 0):
            raise DesignError(f"a gap of {self.gap_mm:g} mm before the backing: give 0 or more")

    def loops(self, body: Region, mounts: Collection[Circle]) -> tuple[Loop, ...]:
        """The part's outline and its mounting holes."""
        return body.outer, *(Loop((circle,)) for circle in mounts)

    def sections(self, loops: tuple[Loop, ...], placement: Placement, whole_circles: bool) -> Sections:
        """Loops of the plate at its two faces. Raises `DesignError` where the wall bends too tightly for
        it."""
        near = placement.thickness_mm + self.gap_mm
        far = near + self.thickness_mm
        corners = loops[0].flatten()
        u, v = (np.linspace(corners[:, k].min(), corners[:, k].max(), PROBES) for k in (0, 1))
        grid = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
        if placement.volume_density(grid, far).min() <= 0:
            raise DesignError(
                f"a backing that reaches {far:g} mm behind the front meets itself on this surface: "
                "take a smaller gap or a thinner backing"
            )
        levels = Level(near, True), Level(far, True)
        charted = [loop if whole_circles else halved(loop) for loop in loops]
        return Sections(tuple(Loft((loop, loop), levels) for loop in charted), genus=len(loops) - 1)
