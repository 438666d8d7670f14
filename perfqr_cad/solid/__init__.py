"""Exact solids: a pattern carved into a wall of material, checked, meshed, written as STEP.

The modeller is heavy to load; names below that need it are imported on first use.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from perfqr_cad.solid.shape import Solid

if TYPE_CHECKING:
    from perfqr_cad.solid.assemble import back, build, build_profile
    from perfqr_cad.solid.step.reader import read_step
    from perfqr_cad.solid.step.write import write_step

_HOMES = {
    "back": "assemble",
    "build": "assemble",
    "build_profile": "assemble",
    "read_step": "step.reader",
    "write_step": "step.write",
}

__all__ = ["Solid", "back", "build", "build_profile", "read_step", "write_step"]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
    globals()[name] = value
    return value
