"""AP242 STEP of the part: exact faces, millimetres, product names, colours; the kernel layer writes it."""

from __future__ import annotations

from pathlib import Path

from perfqr_cad import solid
from perfqr_cad.export.design_view import DesignView


def write(design: DesignView, path: Path) -> None:
    """Write the solid and what belongs to it, a backing say, each under its own name and colour.

    Raises `KernelError` for a solid without a shape.
    """
    solid.write_step(design.solid, path)
