"""Materials as data: isotropic, linear elastic, at room temperature.

Printed plastics scatter: moduli are midpoints of the cited range, yield stresses its lower end, both of solid
prints loaded in the plane of the layers. What a part is allowed is less: `KnockDowns` of the process say by
how much and whence. Poisson's ratios of plastics are assumed, as of glassy and of semi-crystalline polymers:
between 0.33 and 0.42 the deflection, with 1 - ν², changes by 8 %.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from perfqr_cad.errors import AnalysisError


@dataclass(frozen=True)
class KnockDowns:
    """Shares of the yield stress that a process leaves to a part, and where each figure is from.

    layers    across the layers: of walls that are printed upright, as curved ones are
    notch     at corners finer than the disc over which stress is averaged
    creep     under a load that stays, for years at room temperature
    scatter   from one printer, spool or batch to the next
    """

    process: str
    layers: float
    notch: float
    creep: float
    scatter: float
    source: str


PRINTED = KnockDowns(
    "fused filament",
    layers=0.65,
    notch=0.9,
    creep=0.4,
    scatter=0.9,
    source="layers: PLA 35-45 MPa upright, 50-65 flat (additive.tools); 33.75 MPa at interfaces, 22.5 % below"
    " the filament (3D Print. Addit. Manuf. 2020, 10.1089/3dp.2020.0109). creep: short-term figures are no"
    " allowance for years (Curbell, plastic part design); the share, notch and scatter are assumed",
)
SINTERED = KnockDowns(
    "powder or vat",
    layers=0.85,
    notch=0.9,
    creep=0.4,
    scatter=0.9,
    source="layers: assumed between filament and solid; creep as for filament; notch and scatter: assumed",
)
WROUGHT = KnockDowns(
    "sheet metal",
    layers=1.0,
    notch=1.0,
    creep=1.0,
    scatter=1.0,
    source="minimum yield stresses of the standards named: they leave no scatter, and metals no creep at room"
    " temperature; ductile metals yield at notches without breaking",
)


@dataclass(frozen=True)
class Material:
    """An isotropic elastic material: modulus and yield stress in MPa, density in kg/m³."""

    name: str
    e_mpa: float
    nu: float
    yield_mpa: float
    density_kg_m3: float
    source: str
    knock_downs: KnockDowns = PRINTED

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
        "PLA",
        3500.0,
        0.36,
        50.0,
        1240.0,
        "additive.tools/materials/pla, printed flat: 3-4 GPa, strength 50-65 MPa, 1.22-1.26 g/cm³",
    ),
    Material(
        "PETG",
        2000.0,
        0.40,
        44.0,
        1270.0,
        "designerdata.nl, PETG: 2 GPa; additive.tools/materials/petg, flat: 44-56 MPa, 1.25-1.29 g/cm³",
    ),
    Material(
        "ABS",
        2413.0,
        0.37,
        33.0,
        1040.0,
        "Stratasys, Fortus ABS-M30: 2413 MPa; its ISO 527 test at Loughborough University: 33 MPa",
    ),
    Material(
        "PA12",
        1700.0,
        0.40,
        43.0,
        930.0,
        "laser sintered: 1.39 GPa, 43 MPa (3D Systems, in PMC10406103 table 2) to 2 GPa, 52 MPa, 0.93 g/cm³"
        " (additive.tools/materials/pa12)",
        SINTERED,
    ),
    Material(
        "resin",
        2250.0,
        0.40,
        40.0,
        1150.0,
        "Stratasys VERO, in PMC10406103 table 2: 2.0-2.5 GPa, 40-55 MPa; acrylates 1.1-1.2 g/cm³",
        SINTERED,
    ),
    Material(
        "aluminium",
        68900.0,
        0.33,
        276.0,
        2700.0,
        "6061-T6, Aluminum Association typical values: 68.9 GPa, 276 MPa, 2.70 g/cm³",
        WROUGHT,
    ),
    Material(
        "steel",
        210000.0,
        0.30,
        235.0,
        7850.0,
        "S235JR: EN 10025-2 table 7, up to 16 mm thick; EN 1993-1-1 §3.2.6; EN 1991-1-1 table A.4",
        WROUGHT,
    ),
    Material(
        "stainless",
        200000.0,
        0.30,
        210.0,
        7900.0,
        "1.4301 (AISI 304): EN 10088-1 and -2, EN 1993-1-4 §2.1.3",
        WROUGHT,
    ),
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
