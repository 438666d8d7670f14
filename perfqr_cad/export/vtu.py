"""Stress and deflection for ParaView: the shell's mesh as a VTK unstructured grid."""

from __future__ import annotations

from pathlib import Path

from perfqr_cad.errors import DesignError
from perfqr_cad.export.design_view import DesignView


def write(design: DesignView, path: Path) -> None:
    """Write the stress field of the finished part. Raises `DesignError` for a design without one."""
    from perfqr_cad.structure import write_vtu

    if design.stress is None:
        raise DesignError(f"{path.name}: the design has no stress field; analyse it first")
    write_vtu(design.stress, path)
