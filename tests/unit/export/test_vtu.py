"""The stress field as a file, read back."""

from pathlib import Path
from types import SimpleNamespace

import meshio
import pytest
from shapely.geometry import box

from perfqr_cad.errors import DesignError
from perfqr_cad.export import vtu
from perfqr_cad.structure import Case, Part, Pressure, analyse_part
from perfqr_cad.structure.mesh.seeding import MeshSize
from perfqr_cad.surface import Plane


def test_the_field_of_the_finished_part_is_read_back_as_it_was_written(tmp_path: Path) -> None:
    part = Part(box(-5, -5, 5, 5), Plane(1.0))
    field = analyse_part(part, Case.of(Pressure(1e-3)), MeshSize.graded(2.0, 0.4))
    vtu.write(SimpleNamespace(stress=field), tmp_path / "part.vtu")
    read = meshio.read(tmp_path / "part.vtu")
    assert (read.points == field.nodes_mm).all()
    assert (read.cells_dict["triangle6"] == field.mesh.elements).all()
    assert (read.point_data["displacement_mm"] == field.displacement_mm).all()
    assert (read.point_data["deflection_mm"] == field.deflection_mm).all()
    assert (read.point_data["von_mises_mpa"] == field.von_mises_mpa).all()


def test_a_design_without_a_field_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DesignError, match="no stress field"):
        vtu.write(SimpleNamespace(stress=None), tmp_path / "part.vtu")
    assert not list(tmp_path.iterdir())
