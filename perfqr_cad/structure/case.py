"""What a part is asked to bear, and how it is judged: one value for all of the strength layer."""

from __future__ import annotations

import math
from dataclasses import dataclass

from perfqr_cad.errors import AnalysisError
from perfqr_cad.structure.loads import Load, Support, Weight
from perfqr_cad.structure.material_table import Material
from perfqr_cad.structure.material_table import material as material_named

DEFAULT_NOZZLE_MM = 0.4


@dataclass(frozen=True)
class Case:
    """A material, the loads that act together on it, and how it is held.

    nozzle_mm   width of the disc over which stress is averaged, and of the finest detail
    flare_mm    how far holes are wider at the back, to each side; see `Taper`
    yield_mpa   what the largest stress is compared with; None: the material's own
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

    def __post_init__(self) -> None:
        if not (math.isfinite(self.nozzle_mm) and self.nozzle_mm > 0.0):
            raise AnalysisError(f"nozzle is {self.nozzle_mm} mm; it must be a positive number")
        if not self.limit_mpa > 0.0:
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
        """The stress that the part may reach."""
        return self.material.yield_mpa if self.yield_mpa is None else self.yield_mpa

    @property
    def bends_only(self) -> bool:
        """Whether the loads act along the normal of a flat part."""
        return not any(isinstance(load, Weight) and load.direction is not None for load in self.loads)
