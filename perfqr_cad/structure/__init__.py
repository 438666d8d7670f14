"""Strength: Reissner-Mindlin shells, a stress that can be believed, and reinforcement by bridges."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from perfqr_cad.structure.loads import Finger, Hold, Load, Pressure, Support, Weight
from perfqr_cad.structure.materials import MATERIALS, Material, material

if TYPE_CHECKING:
    from perfqr_cad.structure.analysis import analyse, analyse_region
    from perfqr_cad.structure.field import StressField
    from perfqr_cad.structure.reinforcement import Reinforcement
    from perfqr_cad.structure.reinforcing import reinforce
    from perfqr_cad.structure.solid_check import SolidCheck, verify_solid
    from perfqr_cad.structure.vtu import write_vtu

__all__ = [
    "MATERIALS",
    "Finger",
    "Hold",
    "Load",
    "Material",
    "Pressure",
    "Reinforcement",
    "SolidCheck",
    "StressField",
    "Support",
    "Weight",
    "analyse",
    "analyse_region",
    "material",
    "reinforce",
    "verify_solid",
    "write_vtu",
]

_HOME = {
    "write_vtu": "vtu",
    "analyse": "analysis",
    "analyse_region": "analysis",
    "reinforce": "reinforcing",
    "Reinforcement": "reinforcement",
    "SolidCheck": "solid_check",
    "StressField": "field",
    "verify_solid": "solid_check",
}


def __getattr__(name: str) -> Any:
    """Modules that need SciPy are loaded when first used."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
