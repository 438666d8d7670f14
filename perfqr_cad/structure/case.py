"""What a part is asked to bear, and how it is judged: one value for all of the strength layer."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from perfqr_cad.errors import AnalysisError
from perfqr_cad.structure.handling.named_loads import HandlingLoad
from perfqr_cad.structure.loads import Load, Support, Weight
from perfqr_cad.structure.material_table import Material
from perfqr_cad.structure.material_table import material as material_named

DEFAULT_NOZZLE_MM = 0.4
SAFETY = 2.0  # between yielding and what a part in the hand is asked to bear


@dataclass(frozen=True)
class Case:
    """A material, the loads on it, and how it is held.

    loads       act together: pressure, weight and fingers as the paper and benchmarks have them
    handling    judged one by one; if there are any, they decide and `loads` do not count

    nozzle_mm   width of the disc over which stress is averaged, and of the finest detail
    flare_mm    how far holes are wider at the back, to each side; see `Taper`
    yield_mpa   None: the material's own
    safety      factor between what stress may reach and what it is allowed
    knock_down  share of the yield stress that is left to the part
    strengthen  whether bridges are added where the part is too weak
    solver      "CHOLMOD", "SuperLU" or None for the best one installed

    Raises `AnalysisError` for a nozzle or yield stress that is no positive number.

    >>> from perfqr_cad.structure import Pressure
    >>> Case.of(Pressure(5e-6), material="PETG").limit_mpa
    44.0
    """

    material: Material
    loads: tuple[Load, ...]
    support: Support = Support()  # noqa: RUF009  # frozen
    nozzle_mm: float = DEFAULT_NOZZLE_MM
    flare_mm: float = 0.0
    yield_mpa: float | None = None
    solver: str | None = None
    handling: tuple[HandlingLoad, ...] = ()
    safety: float = 1.0
    knock_down: float = 1.0
    strengthen: bool = True

    def __post_init__(self) -> None:
        if not (math.isfinite(self.nozzle_mm) and self.nozzle_mm > 0.0):
            raise AnalysisError(f"nozzle is {self.nozzle_mm} mm; it must be a positive number")
        if not self.full_mpa > 0.0:
            raise AnalysisError(f"yield stress is {self.yield_mpa} MPa; it must be a positive number")

    @staticmethod
    def of(
        loads: Load | tuple[Load, ...],
        *,
        material: Material | str = "PLA",
        support: Support | str = "clamped",
        nozzle_mm: float = DEFAULT_NOZZLE_MM,
        flare_mm: float = 0.0,
        yield_mpa: float | None = None,
        solver: str | None = None,
    ) -> Case:
        """A case with material and support by name.

        Raises:
            AnalysisError: a name is unknown or a figure is out of range.
        """
        return Case(
            material=material_named(material) if isinstance(material, str) else material,
            loads=loads if isinstance(loads, tuple) else (loads,),
            support=Support.named(support) if isinstance(support, str) else support,
            nozzle_mm=nozzle_mm,
            flare_mm=flare_mm,
            yield_mpa=yield_mpa,
            solver=solver,
        )

    @property
    def limit_mpa(self) -> float:
        """The stress that the part may reach under loads that pass."""
        return self.full_mpa * self.knock_down / self.safety

    @property
    def full_mpa(self) -> float:
        """The yield stress without any deduction."""
        return self.material.yield_mpa if self.yield_mpa is None else self.yield_mpa

    def limit_under_mpa(self, load: HandlingLoad) -> float:
        """The stress that the part may reach under a load."""
        return self.limit_mpa * (self.material.knock_downs.creep if load.stays else 1.0)

    def for_hands(
        self,
        loads: tuple[HandlingLoad, ...],
        *,
        upright: bool,
        safety: float = SAFETY,
        strengthen: bool = True,
    ) -> Case:
        """The case of a part in the hand, with the deductions of its process.

        `upright` says that its walls are printed across their layers.
        """
        shares = self.material.knock_downs
        knock_down = shares.notch * shares.scatter * (shares.layers if upright else 1.0)
        return replace(self, handling=loads, safety=safety, knock_down=knock_down, strengthen=strengthen)

    @property
    def bends_only(self) -> bool:
        """Whether the loads act along the normal of a flat part."""
        return not any(isinstance(load, Weight) and load.direction is not None for load in self.loads)
