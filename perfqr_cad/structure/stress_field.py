"""What an analysis finds."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np

from perfqr_cad.structure.measure import Discs
from perfqr_cad.structure.mesh.triangle import EDGES, Floats, Ints, Mesh


@dataclass(frozen=True)
class StressField:
    """Displacement and stress of a loaded part, on its middle surface.

    Arrays: `nodes_mm` (n, 3) in space; `displacement_mm` (n, 3); `deflection_mm` (n,) along the normal that
    faces the reader; `stress_mpa` (m, 3, layers, 5) the tensors σ11, σ22, τ12, τ13, τ23 at the corners of the
    elements of `mesh`, by layers through the thickness.

    `max_stress_mpa` is the largest von Mises stress of the tensor averaged over a disc of
    `disc_width_mm`: the figure to compare with the yield stress. `sharp_peak_mpa` is the largest at any node
    without averaging; it grows with every refinement and is given as what not to use.
    `limit_mpa` is what is allowed of `yield_mpa`.
    `balance` is the unbalanced part of load and reactions over the load.
    """

    mesh: Mesh
    nodes_mm: Floats
    displacement_mm: Floats
    deflection_mm: Floats
    stress_mpa: Floats
    max_stress_mpa: float
    max_stress_at_mm: tuple[float, float]
    sharp_peak_mpa: float
    disc_width_mm: float
    max_deflection_mm: float
    max_deflection_at_mm: tuple[float, float]
    yield_mpa: float
    limit_mpa: float
    load_n: tuple[float, float, float]
    reactions_n: tuple[float, float, float]
    balance: float
    material: str
    support: str
    e_mpa: float
    nu: float
    kappa: float
    thickness_mm: float
    edge_mm: float
    unknowns: int
    solver: str
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for entry in fields(self):
            value = getattr(self, entry.name)
            if isinstance(value, np.ndarray):
                value.setflags(write=False)

    @property
    def uv_mm(self) -> Floats:
        """Nodes (n, 2) in the pattern plane."""
        return self.mesh.nodes

    @cached_property
    def triangles(self) -> Ints:
        """Four corner triangles to each six-node one, for drawing: (4m, 3)."""
        return self.mesh.elements[:, [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]]].reshape(-1, 3)

    @cached_property
    def von_mises_mpa(self) -> Floats:
        """The measure at every node (n,), in the quality of a map."""
        at_corners = np.minimum(
            Discs(self.mesh, self.disc_width_mm).everywhere(self.stress_mpa), self.max_stress_mpa
        )
        out = np.empty(len(self.mesh.nodes))
        out[: self.mesh.corners] = at_corners
        for k, edge in enumerate(EDGES):
            out[self.mesh.elements[:, 3 + k]] = at_corners[self.mesh.elements[:, edge]].mean(axis=1)
        out.setflags(write=False)
        return out

    @property
    def safety_factor(self) -> float:
        """Yield stress over the largest stress; infinite for an unloaded part."""
        return self.yield_mpa / self.max_stress_mpa if self.max_stress_mpa > 0.0 else math.inf

    @property
    def use(self) -> float:
        """The largest stress over what is allowed."""
        return self.max_stress_mpa / self.limit_mpa

    @property
    def strong(self) -> bool:
        """Whether the largest stress stays within what is allowed."""
        return self.max_stress_mpa <= self.limit_mpa
