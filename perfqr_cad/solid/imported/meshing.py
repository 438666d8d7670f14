"""Triangles of a solid, for those who only want to look at it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from perfqr_cad.solid.imported.host import Host
from perfqr_cad.solid.imported.reader import read_part
from perfqr_cad.surface import Triangles


def mesh_step(path: str | Path, part: str | int | None = None) -> Triangles:
    """The solid of a STEP file as triangles, mm. Raises as `read_part` does."""
    chosen = read_part(path, part)
    return Host(chosen.name, chosen.shape).body.triangles


def mesh_shape(shape: Any) -> Triangles:
    """The one solid of a kernel shape, build123d or CadQuery object as triangles, mm.

    Raises `DesignError` for a shape of no or several solids, `KernelError` for an unsound one.
    """
    return Host.of(shape).body.triangles
