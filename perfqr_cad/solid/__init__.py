"""Exact solids: a pattern carved into a wall of material, checked, meshed, written as STEP.

The modeller is heavy to load; names below that need it are imported on first use.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from .shape import Solid
from .walls import Walls

if TYPE_CHECKING:
    from .assemble import back, build, build_plan, build_region
    from .backing import Backing
    from .caption import Caption
    from .imported.meshing import mesh_step
    from .lettering import Lettering
    from .plan import Plan
    from .step import write_step
    from .step_reader import read_step

_HOMES = {
    "Backing": "backing",
    "Caption": "caption",
    "Lettering": "lettering",
    "Plan": "plan",
    "back": "assemble",
    "build": "assemble",
    "build_plan": "assemble",
    "build_region": "assemble",
    "mesh_step": "imported.meshing",
    "read_step": "step_reader",
    "write_step": "step",
}

__all__ = [
    "Backing",
    "Caption",
    "Lettering",
    "Plan",
    "Solid",
    "Walls",
    "back",
    "build",
    "build_plan",
    "build_region",
    "mesh_step",
    "read_step",
    "write_step",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_HOMES[name]}", __name__), name)
