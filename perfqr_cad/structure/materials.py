"""Materials as data: isotropic, linear elastic, at room temperature.

The printed plastics are data-sheet values of solid prints loaded in the plane of the layers; a part loaded
across its layers carries roughly half as much. Use a lower `yield_mpa` where that matters (the paper stops
at 10 MPa for PLA).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from perfqr_cad.errors import AnalysisError


@dataclass(frozen=True)
class Material:
    """An isotropic elastic material: modulus and yield stress in MPa, density in kg/m³."""

    name: str
    e_mpa: float
    nu: float
    yield_mpa: float
    density_kg_m3: float
    source: str

    def __post_init__(self) -> None:
        for label, value in (
            ("modulus", self.e_mpa),
            ("yield stress", self.yield_mpa),
            ("density", self.density_kg_m3),
        ):
            if not (math.isfinite(value) and value > 0.0):
                raise AnalysisError(f"material {self.name}: {label} is {value}; it must be a positive number")
        if not -1.0 < self.nu < 0.5:
            raise AnalysisError(
                f"material {self.name}: Poisson's ratio is {self.nu}; it must lie in (-1, 0.5)"
            )

    @property
    def shear_mpa(self) -> float:
        """Shear modulus G = E / 2(1 + ν) in MPa."""
        return self.e_mpa / (2.0 * (1.0 + self.nu))


_MATERIALS = (
    Material(
        "PLA", 3500.0, 0.36, 50.0, 1240.0, "Ultimaker PLA technical data sheet; ν: Ferreira et al. 2017"
    ),
    Material(
        "PETG", 2050.0, 0.40, 47.0, 1270.0, "Prusament PETG technical data sheet (XY); ν typical of PET"
    ),
    Material(
        "ABS", 2070.0, 0.37, 39.0, 1100.0, "Ultimaker ABS technical data sheet; ν: Cantrell et al. 2017"
    ),
    Material("PA12", 1650.0, 0.40, 48.0, 930.0, "EOS PA 2200 data sheet, laser sintered; ν typical of PA12"),
    Material(
        "resin", 2800.0, 0.40, 65.0, 1180.0, "Formlabs Clear V4 data sheet, post-cured; ν typical of acrylate"
    ),
    Material("aluminium", 68900.0, 0.33, 276.0, 2700.0, "6061-T6: ASM Handbook vol. 2"),
    Material("steel", 210000.0, 0.30, 235.0, 7850.0, "S235: EN 1993-1-1 §3.2.6 and table 3.1"),
    Material("stainless", 200000.0, 0.30, 210.0, 7900.0, "1.4301 (AISI 304): EN 10088-2, EN 1993-1-4 §2.1.3"),
)
MATERIALS: dict[str, Material] = {material.name: material for material in _MATERIALS}


def material(name: str) -> Material:
    """The material of that name, whatever its case.

    Raises:
        AnalysisError: no such material; the message lists those there are.
    """
    for known in _MATERIALS:
        if known.name.lower() == name.lower():
            return known
    raise AnalysisError(f"material {name!r} is unknown; choose one of {', '.join(MATERIALS)}")
