"""The linear-time proof and BRepCheck agree, on sound solids and on solids broken on purpose."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.gp import gp_Pnt
from OCP.TopoDS import TopoDS, TopoDS_Solid

from perfqr_cad.pattern.outline import Circle, Loop, Region
from perfqr_cad.solid import build_region
from perfqr_cad.solid.occ import FACE, VERTEX, explore
from perfqr_cad.solid.plane_chart import PlaneChart
from perfqr_cad.solid.proof import check
from perfqr_cad.solid.punch import panel, solid_of
from perfqr_cad.solid.sections import sections
from perfqr_cad.solid.tube import BUILDER
from perfqr_cad.solid.walls import Walls
from perfqr_cad.surface import Cylinder, Plane

OUTER = Loop.from_points([(-10, -10), (10, -10), (10, 10), (-10, 10)])


def square(x: float, y: float, half: float) -> Loop:
    return Loop.from_points(
        [(x - half, y - half), (x - half, y + half), (x + half, y + half), (x + half, y - half)]
    )


def dot(x: float, y: float, radius: float) -> Loop:
    return Loop((Circle((x, y), radius, ccw=False),))


def plate(*holes: Loop, outer: Loop = OUTER) -> TopoDS_Solid:
    """A plate by direct topology, whether or not its loops make sense."""
    chart = PlaneChart(Plane(2.0))
    return panel(sections([Region(outer, holes)], 2.0, Walls(), True), chart)


def lacking_a_face() -> TopoDS_Solid:
    return solid_of(explore(plate(square(0, 0, 1)), FACE)[:-1])


def face_turned() -> TopoDS_Solid:
    faces = explore(plate(square(0, 0, 1)), FACE)
    return solid_of([*faces[:-1], TopoDS.Face_s(faces[-1].Reversed())])


def vertex_moved() -> TopoDS_Solid:
    solid = plate(square(0, 0, 1))
    vertex = TopoDS.Vertex_s(explore(solid, VERTEX)[0])
    BUILDER.UpdateVertex(vertex, gp_Pnt(0.5, 0.5, 0.5), 1e-7)
    return solid


BROKEN: dict[str, Callable[[], TopoDS_Solid]] = {
    "a missing face": lacking_a_face,
    "a face turned over": face_turned,
    "a vertex off its edges": vertex_moved,
    "crossing holes": lambda: plate(square(0, 0, 2), square(1, 1, 2)),
    "a hole across the rim": lambda: plate(square(10, 0, 1)),
    "a hole outside": lambda: plate(square(20, 0, 1)),
    "a hole the wrong way round": lambda: plate(square(0, 0, 1).reversed()),
    "a bow-tie": lambda: plate(Loop.from_points([(-1, -1), (1, 1), (-1, 1), (1, -1)])),
    "a dot across a square": lambda: plate(square(0, 0, 2), dot(2, 0, 1)),
}


@pytest.mark.parametrize("name", BROKEN)
def test_broken_solids_are_found_out_by_both(name: str) -> None:
    solid = BROKEN[name]()
    assert check(solid) != ()
    assert not BRepCheck_Analyzer(solid, True).IsValid() or name in ("a missing face", "a face turned over")


def test_sound_solids_pass_both() -> None:
    for solid in (plate(), plate(square(0, 0, 1)), plate(square(3, 3, 1), dot(-3, 0, 2))):
        assert check(solid) == ()
        assert BRepCheck_Analyzer(solid, True).IsValid()


def test_corner_contact_passes_brepcheck_but_not_the_proof() -> None:
    """Holes that share a corner leave a solid that touches itself along an edge."""
    solid = plate(square(-1, -1, 1), square(1, 1, 1))
    assert any("coincide" in problem for problem in check(solid))


def test_an_inside_out_solid_is_found_out() -> None:
    inverted = solid_of([TopoDS.Face_s(f.Reversed()) for f in explore(plate(dot(0, 0, 1)), FACE)])
    assert any("inside out" in problem for problem in check(inverted))


def test_genus_and_volume_are_compared() -> None:
    solid = plate(square(0, 0, 1), dot(5, 5, 1))
    assert check(solid, genus=2) == ()
    assert check(solid, genus=3) == ("2 through-holes, not 3",)
    (problem,) = check(solid, expected_volume_mm3=700.0)
    assert "from the outline 700" in problem


def test_an_image_that_strays_is_found_out() -> None:
    """A panel built with the images of a thicker wall."""
    region = Region(OUTER, (square(0, 0, 1),))
    solid = build_region(region, Cylinder(30.0, 2.0)).shape
    assert check(solid) == ()
    from OCP.BRep import BRep_Tool
    from OCP.Geom import Geom_CylindricalSurface

    face = TopoDS.Face_s(explore(solid, FACE)[0])
    surface = BRep_Tool.Surface_s(face)
    assert isinstance(surface, Geom_CylindricalSurface)
    surface.SetRadius(30.5)
    assert any("off its face" in problem for problem in check(solid))
    assert not BRepCheck_Analyzer(solid, True).IsValid()
