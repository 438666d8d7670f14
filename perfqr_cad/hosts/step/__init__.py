"""Codes in the walls of imported solids (STEP): find the place, lay the code on it, punch the holes."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from perfqr_cad.hosts.step.meshing import mesh_shape
    from perfqr_cad.hosts.step.target import ImportedFace

__all__ = ["ImportedFace", "mesh_shape"]

_HOMES = {"ImportedFace": "target", "mesh_shape": "meshing"}


def __getattr__(name: str) -> Any:
    """The modeller is heavy to load: who only meshes a file has no need of it in this process."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_HOMES[name]}", __name__), name)
