"""Exact solids: a profile on a placement becomes a boundary, is proven, meshed and written as STEP.

`tables/` hold the boundary, `charts/` map the pattern into space, `kernel/` is the one room of the modeller.
Nothing here chooses what is made: the profile does. Names that need the modeller are loaded on first use.
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
