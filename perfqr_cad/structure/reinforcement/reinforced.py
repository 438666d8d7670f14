"""What a reinforcement ends with."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from perfqr_cad.structure.handling.capacity import Capacity
from perfqr_cad.structure.stress_field import StressField

if TYPE_CHECKING:
    from perfqr_cad.pattern import Bridge, Pattern

STRONG = "strong"


@dataclass(frozen=True)
class Reinforcement:
    """A pattern and the structural bridges it was given, with the fields before and after.

    `iterations` counts bridges added, `confirmations` the conforming meshes that checked them; `history` is
    the largest stress in MPa, first unreinforced, then after each round and confirmation.
    `capacities` is what the part bears of each load of a hand, least first. `status` is
    "strong" or "weak: no affordable bridge is left"; `remedies` then says what else would help.
    """

    pattern: Pattern
    before: StressField
    after: StressField
    bridges: tuple[Bridge, ...]
    iterations: int
    confirmations: int
    status: str
    history: tuple[float, ...]
    method: str
    limit_mpa: float
    capacities: tuple[Capacity, ...] = ()
    removed: int = 0
    remedies: tuple[str, ...] = ()

    @property
    def strong(self) -> bool:
        """Whether the part bears what it is asked to."""
        return self.status == STRONG
