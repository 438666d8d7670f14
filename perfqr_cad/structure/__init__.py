"""Strength: Reissner-Mindlin shells, a stress that can be believed, and reinforcement by bridges.

`mesh` triangulates the light region, `elements` makes stiffness matrices and solves, `reinforcement` adds
bridges. Here: what is asked (`Case`), what is analysed (`Part`), and the answer. No solid modeller, no files.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from perfqr_cad.structure.handling.named_loads import HandlingLoad, handling_loads
from perfqr_cad.structure.loads import Finger, Hold, Load, Pressure, Support, Weight
from perfqr_cad.structure.material_table import MATERIALS, Material, material

if TYPE_CHECKING:
    from perfqr_cad.structure.analysis import analyse, analyse_part
    from perfqr_cad.structure.assessment import assess
    from perfqr_cad.structure.case import Case
    from perfqr_cad.structure.handling.capacity import Capacity
    from perfqr_cad.structure.part import Part
    from perfqr_cad.structure.reinforcement.algorithm1 import reinforce
    from perfqr_cad.structure.reinforcement.reinforced import Reinforcement
    from perfqr_cad.structure.solid_check import SolidCheck, verify_solid
    from perfqr_cad.structure.stress_field import StressField

__all__ = [
    "MATERIALS",
    "Capacity",
    "Case",
    "Finger",
    "HandlingLoad",
    "Hold",
    "Load",
    "Material",
    "Part",
    "Pressure",
    "Reinforcement",
    "SolidCheck",
    "StressField",
    "Support",
    "Weight",
    "analyse",
    "analyse_part",
    "assess",
    "handling_loads",
    "material",
    "reinforce",
    "verify_solid",
]

_HOME = {
    "Capacity": "handling.capacity",
    "assess": "assessment",
    "Case": "case",
    "Part": "part",
    "Reinforcement": "reinforcement.reinforced",
    "SolidCheck": "solid_check",
    "StressField": "stress_field",
    "analyse": "analysis",
    "analyse_part": "analysis",
    "reinforce": "reinforcement.algorithm1",
    "verify_solid": "solid_check",
}


def __getattr__(name: str) -> Any:
    """Modules that need SciPy are loaded when first used."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
