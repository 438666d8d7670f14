"""What a reinforcement ends with."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from perfqr_cad.structure.stress_field import StressField

if TYPE_CHECKING:
    from perfqr_cad.pattern import Bridge, Pattern

STRONG = "strong"


@dataclass(frozen=True)
class Reinforcement:
    """A pattern and the structural bridges it was given, with the fields before and after.

    `iterations` counts bridges added, `confirmations` the conforming meshes that checked them; `history` is
    the largest stress in MPa, first unreinforced, then after each round and confirmation. `status` is
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
    yield_mpa: float
    removed: int = 0
    remedies: tuple[str, ...] = ()

    @property
    def strong(self) -> bool:
        """Whether the largest stress is within the yield stress."""
        return self.status == STRONG
