"""STEP files as users have them: units, assemblies, shells, damage."""

import re
from pathlib import Path

import pytest
from OCP.BRep import BRep_Builder
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox
from OCP.TopoDS import TopoDS_Compound

from perfqr_cad.errors import DesignError, KernelError
from perfqr_cad.hosts.step.reader import read_part, read_parts
from perfqr_cad.solid.kernel import booleans as kernel
from perfqr_cad.solid.kernel import occ
from perfqr_cad.solid.kernel.to_shape import solid_of

from .imports import SHARED, tray, write_step


def compound(*shapes):
    builder, made = BRep_Builder(), TopoDS_Compound()
    builder.MakeCompound(made)
    for shape in shapes:
        builder.Add(made, shape)
    return made


@pytest.mark.parametrize("unit", ["MM", "INCH", "M"])
def test_declared_units_are_honoured(tmp_path: Path, unit: str) -> None:
    part = read_part(write_step(BRepPrimAPI_MakeBox(10, 20, 30).Shape(), tmp_path / "a.step", unit))
    assert occ.volume(part.shape) == pytest.approx(6000, rel=1e-9)


def test_an_assembly_asks_which_part(tmp_path: Path) -> None:
    two = compound(BRepPrimAPI_MakeBox(1, 1, 1).Shape(), BRepPrimAPI_MakeBox(2, 2, 2).Shape())
    path = write_step(two, tmp_path / "two.step")
    names = [p.name for p in read_parts(path)]
    assert len(set(names)) == 2
    with pytest.raises(DesignError, match=f"assembly of 2 solids.*{names[0]}"):
        read_part(path)
    assert occ.volume(read_part(path, 2).shape) == pytest.approx(8)
    assert occ.volume(read_part(path, names[0]).shape) == pytest.approx(1)
    with pytest.raises(DesignError, match="no part 'lid'"):
        read_part(path, "lid")


def test_a_closed_shell_is_a_solid_and_an_open_one_is_refused(tmp_path: Path) -> None:
    box = BRepPrimAPI_MakeBox(1, 2, 3).Shape()
    closed = kernel.explore(box, "SHELL")[0]
    assert occ.volume(read_part(write_step(closed, tmp_path / "c.step")).shape) == pytest.approx(6)
    opened = kernel.explore(solid_of(kernel.faces(box)[:5]), "SHELL")[0]
    opened.Closed(False)
    with pytest.raises(KernelError, match="no solid, only 1 open shells and 5 faces"):
        read_part(write_step(opened, tmp_path / "o.step"))


def test_damaged_files(tmp_path: Path) -> None:
    whole = write_step(tray(), tmp_path / "t.step").read_bytes()
    for name, data, says in (
        ("short.step", whole[: len(whole) // 2], "cut short"),
        ("text.step", b"hello", "not a STEP file"),
        ("empty.step", b"", "not a STEP file"),
        ("bare.step", whole[: whole.index(b"DATA;")] + b"DATA;\nENDSEC;\nEND-ISO-10303-21;\n", "damaged"),
    ):
        (tmp_path / name).write_bytes(data)
        with pytest.raises(KernelError, match=says):
            read_part(tmp_path / name)
    with pytest.raises(KernelError, match="cannot be read"):
        read_part(tmp_path / "none.step")


@pytest.mark.parametrize("written", ["B\\X2\\00F6\\X0\\den", "Böden", "Böden".encode().decode("latin-1")])
def test_names_with_umlauts(tmp_path: Path, written: str) -> None:
    path = write_step(BRepPrimAPI_MakeBox(1, 1, 1).Shape(), tmp_path / "Gehäuse.step")
    product = f"PRODUCT('{written}','{written}'".encode().replace(b"\\", b"\\\\")
    text, changed = re.subn(rb"PRODUCT\('[^']*',\s*'[^']*'", product, path.read_bytes())
    assert changed == 1
    path.write_bytes(text)
    assert [part.name for part in read_parts(path)] == ["Böden"]


@pytest.mark.skipif(not SHARED.is_dir(), reason="needs the shared parts")
def test_shared_assembly_lists_its_parts() -> None:
    with pytest.raises(DesignError, match="red_cube"):
        read_part(SHARED / "solids" / "cadquery_red_cube_blue_cylinder.step")
