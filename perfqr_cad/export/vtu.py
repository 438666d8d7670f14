"""Stress and deflection for ParaView: the shell's mesh as a VTK unstructured grid."""

from __future__ import annotations

from pathlib import Path

from numpy.typing import ArrayLike

from perfqr_cad.errors import DesignError
from perfqr_cad.export.design_view import DesignView


def write(design: DesignView, path: Path) -> None:
    """Write the middle surface with displacement and deflection (mm) and von Mises stress (MPa) at its nodes.

    Raises `DesignError` for a design without a stress field.
    """
    import meshio

    field = design.stress
    if field is None:
        raise DesignError(f"{path.name}: the design has no stress field; analyse it first")
    values: dict[str, ArrayLike] = {
        "displacement_mm": field.displacement_mm,
        "deflection_mm": field.deflection_mm,
        "von_mises_mpa": field.von_mises_mpa,
    }
    cells: list[tuple[str, ArrayLike] | meshio.CellBlock] = [("triangle6", field.mesh.elements)]
    meshio.Mesh(field.nodes_mm, cells, point_data=values).write(path, file_format="vtu")
