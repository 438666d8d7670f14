"""Strength: Reissner-Mindlin shells, a stress that can be believed, and reinforcement by bridges.

`mesh` triangulates the light region, `elements` makes stiffness matrices and solves, `reinforcement` adds
bridges. Here: what is asked (`Case`), what is analysed (`Part`), and the answer. No solid modeller, no files.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .loads import Finger, Hold, Load, Pressure, Support, Weight
from .material_table import MATERIALS, Material, material

if TYPE_CHECKING:
    from .analysis import analyse, analyse_part
    from .case import Case
    from .part import Part
    from .reinforcement.algorithm1 import reinforce
    from .reinforcement.reinforced import Reinforcement
    from .solid_check import SolidCheck, verify_solid
    from .stress_field import StressField

__all__ = [
    "MATERIALS",
    "Case",
    "Finger",
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
    "material",
    "reinforce",
    "verify_solid",
]

_HOME = {
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
