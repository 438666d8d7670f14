"""The kernel's own reader opens what is written; the writer itself is tested with the kernel layer."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from OCP.BRep import BRep_Tool
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopExp import TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS

from perfqr_cad import export
from perfqr_cad.errors import KernelError
from perfqr_cad.geometry import Triangles
from perfqr_cad.profile import Profile
from perfqr_cad.solid import build_profile, read_step
from perfqr_cad.surface import Plane

from .conftest import curved_region


@pytest.fixture(scope="module")
def design():
    region, placement = curved_region(), Plane(2.0)
    solid = build_profile(Profile((region,)), placement, name="Ünïque part", colour=(0.8, 0.1, 0.1))
    return SimpleNamespace(solid=solid, placement=placement, pattern=SimpleNamespace(region=region))


def test_name_colour_and_volume_come_back(design, tmp_path):
    export.write(design, tmp_path / "part.step")
    [part] = read_step(tmp_path / "part.step")
    assert part.name == "Ünïque part"
    assert part.colour == pytest.approx((0.8, 0.1, 0.1), abs=1e-3)
    assert design.solid.volume_mm3 == pytest.approx(design.pattern.region.area * 2, rel=1e-9)


def test_header_names_no_folder_and_no_clock(design, tmp_path):
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        export.write(design, tmp_path / folder / "part.stp")
    text = (tmp_path / "a" / "part.stp").read_text("ascii")
    assert text == (tmp_path / "b" / "part.stp").read_text("ascii")
    assert "AP242" in text
    assert str(tmp_path) not in text
    assert ".perfqr-" not in text


def test_a_body_of_triangles_comes_back_as_it_is(design, tmp_path):
    """A carved mesh has no exact faces: its triangles go into a tessellated solid."""
    meshed = SimpleNamespace(solid=replace(design.solid, exact=None))
    export.write(meshed, tmp_path / "mesh.step")
    [part] = read_step(tmp_path / "mesh.step")
    assert part.name == "Ünïque part"
    assert part.colour == pytest.approx((0.8, 0.1, 0.1), abs=1e-3)
    faces = TopExp_Explorer(part.shape, TopAbs_ShapeEnum.TopAbs_FACE)
    mesh = BRep_Tool.Triangulation_s(TopoDS.Face_s(faces.Current()), TopLoc_Location())
    nodes = [mesh.Node(i + 1).Coord() for i in range(mesh.NbNodes())]
    corners = [mesh.Triangle(i + 1).Get() for i in range(mesh.NbTriangles())]
    back = Triangles(np.array(nodes), np.array(corners) - 1)
    assert back.closed
    assert back.volume_mm3 == pytest.approx(design.solid.triangles.volume_mm3, rel=1e-9)


def test_a_body_of_nothing_is_refused(design, tmp_path):
    empty = Triangles(np.zeros((0, 3)), np.zeros((0, 3), int))
    nothing = SimpleNamespace(solid=replace(design.solid, exact=None, triangles=empty))
    with pytest.raises(KernelError, match="0 triangles"):
        export.write(nothing, tmp_path / "none.step")
    assert not list(tmp_path.iterdir())
