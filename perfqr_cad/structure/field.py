"""What an analysis finds."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np

from perfqr_cad.structure.t6 import Floats, Ints


@dataclass(frozen=True)
class StressField:
    """Displacement and stress of a loaded part, on its middle surface.

    Arrays: `uv_mm` (n, 2) nodes in the pattern plane; `nodes_mm` (n, 3) in space; `triangles` (m, 3), four to
    each six-node element; `displacement_mm` (n, 3); `deflection_mm` (n,) along the normal that faces the
    reader; `von_mises_mpa` (n,) the named measure.

    `max_stress_mpa` is the largest von Mises stress of the tensor averaged over a disc of
    `disc_width_mm`: the figure to compare with the yield stress. `sharp_peak_mpa` is the largest at any node
    without averaging; it grows with every refinement and is given as what not to use.
    `balance` is the unbalanced part of load and reactions over the load.
    """

    uv_mm: Floats
    nodes_mm: Floats
    triangles: Ints
    displacement_mm: Floats
    deflection_mm: Floats
    von_mises_mpa: Floats
    max_stress_mpa: float
    max_stress_at_mm: tuple[float, float]
    sharp_peak_mpa: float
    disc_width_mm: float
    max_deflection_mm: float
    max_deflection_at_mm: tuple[float, float]
    yield_mpa: float
    mass_g: float
    load_n: tuple[float, float, float]
    reactions_n: tuple[float, float, float]
    balance: float
    material: str
    support: str
    thickness_mm: float
    mesh_size_mm: float
    unknowns: int
    solver: str
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for entry in fields(self):
            value = getattr(self, entry.name)
            if isinstance(value, np.ndarray):
                value.setflags(write=False)

    @property
    def safety_factor(self) -> float:
        """Yield stress over the largest stress; infinite for an unloaded part."""
        return self.yield_mpa / self.max_stress_mpa if self.max_stress_mpa > 0.0 else math.inf

    @property
    def strong(self) -> bool:
        """Whether the largest stress stays within the yield stress."""
        return self.max_stress_mpa <= self.yield_mpa
