"""The linear-time proof and BRepCheck agree, on sound solids and on solids broken on purpose."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from OCP.BRepCheck import BRepCheck_Analyzer

from perfqr_cad.errors import KernelError
from perfqr_cad.geometry.outline import Circle, Loop, Region
from perfqr_cad.profile import Profile
from perfqr_cad.profile.sections import sections
from perfqr_cad.profile.walls import Walls
from perfqr_cad.solid import build_profile
from perfqr_cad.solid.charts.plane_chart import PlaneChart
from perfqr_cad.solid.kernel import occ
from perfqr_cad.solid.kernel.from_shape import brep_of
from perfqr_cad.solid.kernel.modelled import ModelledSurfaces
from perfqr_cad.solid.kernel.to_shape import KernelShape
from perfqr_cad.solid.proof.check import check
from perfqr_cad.solid.stitch import panel
from perfqr_cad.solid.tables.batches import Lines, Planes
from perfqr_cad.solid.tables.brep import Batch, Brep
from perfqr_cad.surface import Cylinder, Plane

OUTER = Loop.from_points([(-10, -10), (10, -10), (10, 10), (-10, 10)])
FRONT, BACK = 0, 1  # faces of a plate


def square(x: float, y: float, half: float) -> Loop:
    return Loop.from_points(
        [(x - half, y - half), (x - half, y + half), (x + half, y + half), (x + half, y - half)]
    )


def dot(x: float, y: float, radius: float) -> Loop:
    return Loop((Circle((x, y), radius, ccw=False),))


def plate(*holes: Loop, outer: Loop = OUTER) -> Brep:
    """A plate by direct topology, whether or not its loops make sense."""
    return panel(sections([Region(outer, holes)], 2.0, Walls(), True), PlaneChart(Plane(2.0)))


def brepcheck(brep: Brep) -> bool:
    return BRepCheck_Analyzer(KernelShape(brep).solid(), True).IsValid()


def changed(table: np.ndarray, row: object, value: object) -> np.ndarray:
    copy = table.copy()
    copy[row] = value
    return copy


def lacking_a_face() -> Brep:
    """The last wall, of one loop of four edges, is left out."""
    whole = plate(square(0, 0, 1))
    last = whole.face_count - 1
    return replace(
        whole,
        edges=whole.edges[:-4],
        ahead=whole.ahead[:-4],
        loops=whole.loops[:-1],
        bounds=whole.bounds[:-1],
        outward=whole.outward[:-1],
        shells=np.array([0, last]),
        surfaces=tuple(
            batch.renumbered(np.append(np.arange(last), -1)) for batch in whole.surfaces if len(batch.rows)
        ),
    )


def face_turned() -> Brep:
    """The last wall looks into the material: its loop runs the other way round on the other side."""
    whole = plate(square(0, 0, 1))
    edges, ahead = whole.edges.copy(), whole.ahead.copy()
    edges[-4:], ahead[-4:] = edges[-4:][::-1], ~ahead[-4:][::-1]
    return replace(whole, edges=edges, ahead=ahead, outward=changed(whole.outward, -1, False))


def vertex_moved() -> Brep:
    whole = plate(square(0, 0, 1))
    return replace(whole, points=changed(whole.points, 0, (0.5, 0.5, 0.5)))


def plane_moved() -> Brep:
    """The front lies deeper than its edges."""
    whole = plate(square(0, 0, 1))
    first, *others = whole.surfaces
    assert isinstance(first.of, Planes)
    lower = replace(first.of, origin=first.of.origin - [0.0, 0.0, 0.1])
    return replace(whole, surfaces=(replace(first, of=lower), *others))


BROKEN: dict[str, Callable[[], Brep]] = {
    "a missing face": lacking_a_face,
    "a face turned over": face_turned,
    "a vertex off its edges": vertex_moved,
    "a face off its edges": plane_moved,
    "crossing holes": lambda: plate(square(0, 0, 2), square(1, 1, 2)),
    "a hole across the rim": lambda: plate(square(10, 0, 1)),
    "a hole outside": lambda: plate(square(20, 0, 1)),
    "a hole the wrong way round": lambda: plate(square(0, 0, 1).reversed()),
    "a bow-tie": lambda: plate(Loop.from_points([(-1, -1), (1, 1), (-1, 1), (1, -1)])),
    "a dot across a square": lambda: plate(square(0, 0, 2), dot(2, 0, 1)),
}
# The oracle looks at each face by itself, and hardly at the shell as a whole.
PASSED_BY_BREPCHECK = ("a missing face", "a face turned over")


@pytest.mark.parametrize("name", BROKEN)
def test_broken_solids_are_found_out_by_both(name: str) -> None:
    brep = BROKEN[name]()
    assert check(brep) != ()
    assert not brepcheck(brep) or name in PASSED_BY_BREPCHECK
    shape = KernelShape(brep).solid()
    assert check(brep_of(shape)) != ()


def test_sound_solids_pass_both() -> None:
    for brep in (plate(), plate(square(0, 0, 1)), plate(square(3, 3, 1), dot(-3, 0, 2))):
        assert check(brep) == ()
        assert brepcheck(brep)
        assert check(brep_of(KernelShape(brep).solid())) == ()


def test_corner_contact_passes_brepcheck_but_not_the_proof() -> None:
    """Holes that share a corner leave a solid that touches itself along an edge."""
    brep = plate(square(-1, -1, 1), square(1, 1, 1))
    assert any("coincide" in problem for problem in check(brep))


def test_one_vertex_in_two_places_is_found_out() -> None:
    """The corners of two holes become one vertex: the faces around it are two fans."""
    whole = plate(square(-1, -1, 1), square(1, 1, 1))
    same = np.flatnonzero((np.abs(whole.points - [0.0, 0.0, 2.0]) < 1e-9).all(axis=1))
    ends = np.where(whole.ends == same[1], same[0], whole.ends)
    assert any("touches itself" in problem for problem in check(replace(whole, ends=ends)))


def test_an_inside_out_solid_is_found_out() -> None:
    whole = plate(square(0, 0, 1))
    order = np.concatenate([np.arange(b - 1, a - 1, -1) for a, b in pairwise(whole.loops.tolist())])
    inverted = replace(whole, edges=whole.edges[order], ahead=~whole.ahead[order], outward=~whole.outward)
    assert check(inverted) == ("volume -792 mm³: the shell is inside out",)


def test_genus_and_volume_are_compared() -> None:
    brep = plate(square(0, 0, 1), dot(5, 5, 1))
    assert check(brep, genus=2) == ()
    assert check(brep, genus=3) == ("2 through-holes, not 3",)
    (problem,) = check(brep, expected_volume_mm3=700.0)
    assert "from the outline 700" in problem


def test_a_shell_in_two_pieces_is_found_out() -> None:
    """Two plates in one table."""
    one, other = plate(), plate(outer=Loop.from_points([(20, 0), (30, 0), (30, 5), (20, 5)]))
    edges, uses, faces = len(one.ends), len(one.edges), one.face_count
    both = replace(
        one,
        points=np.vstack([one.points, other.points]),
        ends=np.vstack([one.ends, other.ends + len(one.points)]),
        curves=(*one.curves, *(Batch(b.rows + edges, b.of) for b in other.curves)),
        tolerance_mm=np.concatenate([one.tolerance_mm, other.tolerance_mm]),
        edges=np.concatenate([one.edges, other.edges + edges]),
        ahead=np.concatenate([one.ahead, other.ahead]),
        loops=np.concatenate([one.loops, other.loops[1:] + uses]),
        bounds=np.concatenate([one.bounds, other.bounds[1:] + len(one.loops) - 1]),
        surfaces=(*one.surfaces, *(Batch(b.rows + faces, b.of) for b in other.surfaces)),
        outward=np.concatenate([one.outward, other.outward]),
        shells=np.array([0, faces + other.face_count]),
    )
    assert "the shell is in 2 pieces" in check(both)
    assert check(replace(both, shells=np.array([0, faces, faces + other.face_count]))) == (
        "2 shells, not one",
    )


def test_what_is_missing_is_said() -> None:
    whole = plate(dot(0, 0, 1))
    assert check(replace(whole, curves=whole.curves[1:])) == ("an edge has no curve",)
    assert check(replace(whole, images=())) == ("an edge has no image on its curved face",)
    assert check(replace(whole, ends=changed(whole.ends, (0, 1), -1))) == ("an edge has no vertex at an end",)
    empty = np.append(whole.bounds, whole.bounds[-1])
    outward = np.append(whole.outward, True)
    (bare,) = check(replace(whole, bounds=empty, outward=outward, shells=np.array([0, len(outward)])))
    assert bare == "a face has no outline"
    (bare,) = check(replace(whole, loops=changed(whole.loops, 1, 0)))
    assert bare == "a loop has no edges"


def test_a_loop_out_of_order_is_found_out() -> None:
    """Two edges of the outline of the front in the wrong order, which the modeller sorts for itself."""
    whole = plate(square(0, 0, 1))
    swapped = replace(whole, edges=changed(whole.edges, [1, 2], whole.edges[[2, 1]]))
    assert any("loop is broken" in problem for problem in check(swapped))


def test_an_edge_without_extent_is_found_out() -> None:
    whole = plate(square(0, 0, 1))
    lines = next(batch for batch in whole.curves if isinstance(batch.of, Lines))
    assert isinstance(lines.of, Lines)
    point = replace(lines, of=Lines(lines.of.start, lines.of.start.copy()))
    others = tuple(batch for batch in whole.curves if batch is not lines)
    assert any("no extent" in problem for problem in check(replace(whole, curves=(point, *others))))


def test_several_solids_are_no_solid() -> None:
    from OCP.BRep import BRep_Builder
    from OCP.TopoDS import TopoDS_Compound

    pair = TopoDS_Compound()
    BRep_Builder().MakeCompound(pair)
    for brep in (plate(), plate(square(0, 0, 1))):
        BRep_Builder().Add(pair, KernelShape(brep).solid())
    with pytest.raises(KernelError, match="2 solids"):
        brep_of(pair)


def test_an_image_that_strays_is_found_out() -> None:
    """A panel built with the images of a thicker wall."""
    from OCP.Geom import Geom_CylindricalSurface

    solid = build_profile(Profile((Region(OUTER, (square(0, 0, 1),)),)), Cylinder(30.0, 2.0))
    assert isinstance(solid.exact, Brep)
    assert check(solid.exact) == ()
    front = next(b.of for b in solid.exact.surfaces if isinstance(b.of, ModelledSurfaces))
    assert isinstance(front.handles[0], Geom_CylindricalSurface)
    front.handles[0].SetRadius(30.5)
    assert any("off its face" in problem for problem in check(solid.exact))
    assert not BRepCheck_Analyzer(solid.shape, True).IsValid()
    assert occ.count(solid.shape, occ.FACE) == solid.faces


def test_parts_of_the_modeller_pass() -> None:
    """Spheres close in poles, tori twice; booleans widen vertices, and turn loops by a period."""
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
    from OCP.BRepPrimAPI import (
        BRepPrimAPI_MakeBox,
        BRepPrimAPI_MakeCone,
        BRepPrimAPI_MakeCylinder,
        BRepPrimAPI_MakeSphere,
        BRepPrimAPI_MakeTorus,
    )
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt

    ball, ring = BRepPrimAPI_MakeSphere(4.0).Shape(), BRepPrimAPI_MakeTorus(5.0, 1.0).Shape()
    drill = BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(-9, 0, 0), gp_Dir(1, 0, 0)), 0.5, 18.0).Shape()
    half = BRepAlgoAPI_Cut(ball, BRepPrimAPI_MakeBox(gp_Pnt(-9, -9, -9), 18, 18, 9).Shape()).Shape()
    slant = BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(-9, 0, 2), gp_Dir(1, 0, 0)), 0.5, 18.0).Shape()
    parts = {
        "ball": (ball, 0),
        "ring": (ring, 1),
        "cone": (BRepPrimAPI_MakeCone(3.0, 0.0, 4.0).Shape(), 0),
        "drilled ball": (BRepAlgoAPI_Cut(ball, drill).Shape(), 1),
        "drilled ring": (BRepAlgoAPI_Cut(ring, drill).Shape(), None),
        "half a ball": (half, 0),
        "half a drilled ball": (BRepAlgoAPI_Cut(half, slant).Shape(), 1),
    }
    for name, (shape, genus) in parts.items():
        brep = brep_of(shape)
        assert (name, check(brep, genus=genus, volume_mm3=occ.volume(shape))) == (name, ())
