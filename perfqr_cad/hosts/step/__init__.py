"""Codes in the walls of imported solids (STEP): find the place, map the code onto it, punch the holes.

Every hole runs between the host's own exact faces. Reading STEP itself is in `solid/step`; nothing here knows
of meshes that were imported as such.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from perfqr_cad.hosts.step.imported_face import ImportedFace
    from perfqr_cad.hosts.step.meshing import mesh_shape

__all__ = ["ImportedFace", "mesh_shape"]

_HOMES = {"ImportedFace": "imported_face", "mesh_shape": "meshing"}


def __getattr__(name: str) -> Any:
    """The modeller is heavy to load: who only meshes a file has no need of it in this process."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_HOMES[name]}", __name__), name)
