"""Triangles of a solid, for those who only want to look at it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from perfqr_cad.geometry import Triangles
from perfqr_cad.hosts.step.host import Host
from perfqr_cad.hosts.step.reader import read_parts
from perfqr_cad.solid.kernel import booleans as kernel


def mesh_step(path: str | Path) -> Triangles:
    """All solids of a STEP file as triangles where they stand, mm. `KernelError` for an unsound one."""
    parts = [Host(part.name, kernel.sound(part.shape, part.name)) for part in read_parts(path)]
    first, *others = (part.body.triangles for part in parts)
    return first.joined(*others)


def mesh_shape(shape: Any) -> Triangles:
    """The one solid of a kernel shape, build123d or CadQuery object as triangles, mm.

    Raises `DesignError` for a shape of no or several solids, `KernelError` for an unsound one.
    """
    return Host.of(shape).body.triangles
