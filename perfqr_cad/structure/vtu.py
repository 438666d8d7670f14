"""A stress field as a VTK unstructured grid (XML, text), for ParaView and its kin."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.structure.field import StressField

_QUADRATIC_TRIANGLE = 22  # VTK cell type, nodes in the order of `t6.Mesh`


def write_vtu(field: StressField, path: str | Path) -> None:
    """Write the middle surface with displacement and deflection (mm) and von Mises stress (MPa) at its nodes.

    Raises:
        OSError: the file cannot be written.
    """
    elements = field.mesh.elements
    count, nodes = elements.shape
    cells = (
        _array("connectivity", "Int64", elements),
        _array("offsets", "Int64", nodes * np.arange(1, count + 1)),
        _array("types", "UInt8", np.full(count, _QUADRATIC_TRIANGLE)),
    )
    values = (
        _array("displacement_mm", "Float64", field.displacement_mm),
        _array("deflection_mm", "Float64", field.deflection_mm),
        _array("von_mises_mpa", "Float64", field.von_mises_mpa),
    )
    lines = (
        '<?xml version="1.0"?>',
        '<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian"><UnstructuredGrid>',
        f'<Piece NumberOfPoints="{len(field.nodes_mm)}" NumberOfCells="{count}">',
        f"<Points>{_array('points', 'Float64', field.nodes_mm)}</Points>",
        f"<Cells>{''.join(cells)}</Cells>",
        f'<PointData Vectors="displacement_mm" Scalars="von_mises_mpa">{"".join(values)}</PointData>',
        "</Piece></UnstructuredGrid></VTKFile>",
    )
    Path(path).write_text("\n".join(lines) + "\n", encoding="ascii")


def _array(name: str, kind: str, values: NDArray[np.float64] | NDArray[np.int64]) -> str:
    components = values.shape[1] if kind == "Float64" and values.ndim == 2 else 1
    form = "%.9g" if kind == "Float64" else "%d"
    text = " ".join([form % value for value in values.ravel().tolist()])
    head = f'type="{kind}" Name="{name}" NumberOfComponents="{components}" format="ascii"'
    return f"<DataArray {head}>{text}</DataArray>"
