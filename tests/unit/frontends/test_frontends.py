"""The front ends hand over one kernel shape, in their own ways of building."""

import subprocess
import sys

import cadquery
import pytest
from build123d import Align, Axis, Box, BuildPart, Location, Mode, Part, Pos

import perfqr_cad.frontends.cadquery_plugin  # noqa: F401 - adds Workplane.perforatedQR
from perfqr_cad import make
from perfqr_cad.errors import DesignError, KernelError
from perfqr_cad.frontends import PerforatedQR, shape_of, to_build123d, to_cadquery
from perfqr_cad.frontends.designs import design_of
from perfqr_cad.geometry import Triangles
from perfqr_cad.solid import Solid

TEXT, SIZE = "PERFQR", 40.0


@pytest.fixture(scope="module")
def code() -> PerforatedQR:
    return PerforatedQR(TEXT, SIZE, 2.0, version=1)


def test_algebra_mode(code: PerforatedQR) -> None:
    assert code.is_valid
    box = code.bounding_box()
    assert pytest.approx(SIZE, abs=1e-6) == box.size.X
    assert (pytest.approx(0, abs=1e-6), pytest.approx(2, abs=1e-6)) == (box.min.Z, box.max.Z)
    both = code + Pos(0, -SIZE / 2 - 5, 0) * Box(SIZE, 12, 2, align=(Align.CENTER, Align.CENTER, Align.MIN))
    assert len(both.solids()) == 1
    assert both.volume == pytest.approx(code.volume + SIZE * 11 * 2, rel=1e-6)


def test_builder_mode_with_align_rotation_and_mode() -> None:
    with BuildPart() as stand:
        PerforatedQR(TEXT, SIZE, 2.0, version=1, rotation=(90, 0, 0), align=(Align.MIN, Align.MIN, Align.MAX))
    box = stand.part.bounding_box()
    assert (pytest.approx(0, abs=1e-6), pytest.approx(SIZE, abs=1e-6)) == (box.min.X, box.size.Z)
    with BuildPart() as alone:
        Box(100, 100, 2)
        made = PerforatedQR(TEXT, SIZE, 2.0, version=1, mode=Mode.PRIVATE)
    assert alone.part.volume == pytest.approx(100 * 100 * 2)
    assert made.volume > 0
    assert stand.part.faces().sort_by(Axis.Y)[0] is not None


def test_cadquery_places_one_at_every_point() -> None:
    made = (
        cadquery.Workplane()
        .pushPoints([(0, 0), (50, 0)])
        .perforatedQR(TEXT, SIZE, 2.0, version=1, combine=False)
    )
    assert made.solids().size() == 2
    upright = cadquery.Workplane("XZ").perforatedQR(TEXT, SIZE, 2.0, version=1)
    box = upright.val().BoundingBox()
    assert (box.zlen, box.ylen) == (pytest.approx(SIZE, abs=1e-6), pytest.approx(2.0, abs=1e-6))


def test_conversions_share_the_shape(code: PerforatedQR) -> None:
    solid = design_of(TEXT, size_mm=SIZE, thickness_mm=2.0, version=1).solid
    part, workplane = to_build123d(solid), to_cadquery(solid)
    assert isinstance(part, Part)
    assert shape_of(part).IsSame(solid.shape)
    assert shape_of(workplane).IsSame(solid.shape)
    assert shape_of(to_build123d(workplane)).IsSame(solid.shape)
    assert shape_of(to_cadquery(part)).IsSame(solid.shape)
    assert part.label == solid.name
    moved = Location((1, 2, 3)) * code
    assert to_cadquery(moved).val().Volume() == pytest.approx(code.volume, rel=1e-9)


def test_an_object_is_the_part_that_make_makes(code: PerforatedQR) -> None:
    design = make(text=TEXT, size_mm=SIZE, thickness_mm=2.0, version=1)
    assert code.design.certificate()["connectivity"] == design.certificate()["connectivity"]
    assert code.volume == pytest.approx(design.solid.volume_mm3, rel=1e-9)
    placed = cadquery.Workplane().perforatedQR(TEXT, SIZE, 2.0, version=1)
    assert placed.design is code.design


def test_refusals() -> None:
    with pytest.raises(DesignError, match="no setting 'color'"):
        PerforatedQR(TEXT, SIZE, color="red")
    mesh = Triangles(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    )
    carved = Solid(None, mesh, True, 1, 4, 6, 1 / 6, ((0, 0, 0), (1, 1, 1)))
    with pytest.raises(KernelError, match="triangles only"):
        to_build123d(carved)


def test_neither_program_is_loaded_before_it_is_wanted() -> None:
    look = (
        "import sys, perfqr_cad, perfqr_cad.frontends;"
        "print({'build123d', 'cadquery', 'OCP'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", look], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"
