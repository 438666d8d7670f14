"""STEP written in linear time is read back by the kernel: valid, same volume, faces, names, colours,
units."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from OCP.BRepCheck import BRepCheck_Analyzer

from perfqr_cad.errors import KernelError
from perfqr_cad.geometry.outline import Circle, Loop, Region
from perfqr_cad.profile import Profile, Walls
from perfqr_cad.solid import Solid, build_profile, read_step, write_step
from perfqr_cad.solid.kernel import occ
from perfqr_cad.solid.step.text import real, text
from perfqr_cad.surface import Cone, Cylinder, HeightField, Placement, Plane, Revolution, Sphere

OUTER = Loop.from_points([(-8, -8), (8, -8), (8, 8), (-8, 8)])
HOLES = (
    Loop.from_points([(-1, -1), (-1, 1), (1, 1), (1, -1)]),
    Loop((Circle((4, 4), 1.5, ccw=False),)),
)
WALLS: dict[str, Placement] = {
    "plane": Plane(2.0),
    "cylinder": Cylinder(30.0, 2.0),
    "sphere": Sphere(40.0, 2.0),
    "cone": Cone(30.0, 15.0, 2.0),
    "vase": Revolution(((20.0, 0.0), (26.0, 20.0), (30.0, 40.0), (27.0, 60.0), (20.0, 80.0)), 40.0, 2.0),
    "free form": HeightField.of(lambda x, y: np.sin(x / 8) + y * y / 90, 10.0, 2.0, samples=9),
}


def part(placement: Placement, walls: Walls | None = None) -> Solid:
    return build_profile(Profile((Region(OUTER, HOLES),)), placement, walls)


@pytest.mark.parametrize("heal", [True, False])
@pytest.mark.parametrize("name", WALLS)
def test_written_solids_read_back_the_same(name: str, heal: bool, tmp_path: Path) -> None:
    solid = part(WALLS[name], Walls(draft_deg=8.0, lip_mm=0.4) if name in ("plane", "cylinder") else None)
    write_step(solid, tmp_path / "part.step")
    (found,) = read_step(tmp_path / "part.step", heal=heal)
    assert BRepCheck_Analyzer(found.shape, True).IsValid()
    assert occ.volume(found.shape) == pytest.approx(solid.volume_mm3, rel=1e-6)
    assert occ.count(found.shape, occ.FACE) == solid.faces


def test_names_colours_and_an_assembly_come_back(tmp_path: Path) -> None:
    backing = replace(part(Plane(1.0)), name="Rückwand 'B'", colour=(0.1, 0.2, 0.3))
    solid = replace(part(Plane(2.0)), name="Lochplatte", colour=(0.9, 0.8, 0.7), extras=(backing,))
    write_step(solid, tmp_path / "part.step")
    front, back = read_step(tmp_path / "part.step")
    assert (front.name, back.name) == ("Lochplatte", "Rückwand 'B'")
    assert front.colour == pytest.approx((0.9, 0.8, 0.7), abs=1e-6)
    assert back.colour == pytest.approx((0.1, 0.2, 0.3), abs=1e-6)
    assert occ.volume(back.shape) == pytest.approx(backing.volume_mm3)


def test_the_same_part_gives_the_same_bytes(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    for path in (tmp_path / "part.step", tmp_path / "a" / "other.step"):
        write_step(part(Sphere(40.0, 2.0)), path)
    assert (tmp_path / "part.step").read_bytes() == (tmp_path / "a" / "other.step").read_bytes()


def test_a_solid_with_a_cavity_keeps_it(tmp_path: Path) -> None:
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeSphere
    from OCP.gp import gp_Pnt

    hollow = BRepAlgoAPI_Cut(
        BRepPrimAPI_MakeBox(gp_Pnt(-5, -5, -5), 10, 10, 10).Shape(), BRepPrimAPI_MakeSphere(3.0).Shape()
    ).Shape()
    (shape,) = occ.explore(hollow, occ.SOLID)
    write_step(replace(part(Plane(1.0)), exact=shape), tmp_path / "hollow.step")
    (found,) = read_step(tmp_path / "hollow.step")
    assert occ.volume(found.shape) == pytest.approx(1000 - 4 / 3 * np.pi * 27, rel=1e-9)


def test_other_units_are_read_as_millimetres(tmp_path: Path) -> None:
    write_step(part(Plane(2.0)), tmp_path / "mm.step")
    mm = (tmp_path / "mm.step").read_text("ascii")
    metric = "(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))"
    assert metric in mm
    (tmp_path / "m.step").write_text(mm.replace(".MILLI.,", ".CENTI.,"), "ascii")
    (found,) = read_step(tmp_path / "m.step")
    assert occ.volume(found.shape) == pytest.approx(1000 * part(Plane(2.0)).volume_mm3, rel=1e-9)


@pytest.mark.parametrize("content", ["", "ISO-10303-21;\nHEADER;\n", "no step at all"])
def test_a_broken_file_is_refused_in_one_line(content: str, tmp_path: Path) -> None:
    (tmp_path / "bad.step").write_text(content)
    with pytest.raises(KernelError) as caught:
        read_step(tmp_path / "bad.step")
    assert "\n" not in str(caught.value)


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(KernelError, match="No such file"):
        read_step(tmp_path / "none.step")


@pytest.mark.parametrize(
    ("value", "written"),
    [(0.0, "0."), (-0.0, "0."), (1.5, "1.5"), (1e-7, "1.E-7"), (-2.5e20, "-2.5E20"), (3.0, "3.")],
)
def test_numbers_have_a_point(value: float, written: str) -> None:
    assert real(value) == written


def test_strings_are_escaped() -> None:
    assert text("it's") == "'it''s'"
    assert text("ü😀") == r"'\X2\00FC\X0\\X4\0001F600\X0\'"
