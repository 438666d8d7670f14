"""Solids seen by others: brute-force booleans, manifold3d, gmsh, and PrusaSlicer and FreeCAD where
installed."""

from __future__ import annotations

import functools
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeCylinder
from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt

from perfqr_cad.geometry.outline import Circle, Loop, Region
from perfqr_cad.pattern import Bridge
from perfqr_cad.profile import Caption, Profile, Walls
from perfqr_cad.solid import Solid, build_profile, read_step, write_step
from perfqr_cad.solid.kernel import occ
from perfqr_cad.surface import Cone, Cylinder, Placement, Plane, Sphere

RED = (0.8, 0.2, 0.1)
RNG = np.random.default_rng(11)
CELLS = [(c - 4.5, r - 4.5) for r in range(10) for c in range(10) if RNG.random() < 0.4]
OUTER = Loop.from_points([(-7, -7), (7, -7), (7, 7), (-7, 7)])


def cell(x: float, y: float) -> Loop:
    h = 0.4
    return Loop.from_points([(x - h, y - h), (x - h, y + h), (x + h, y + h), (x + h, y - h)])


REGION = Region(OUTER, tuple(cell(x, y) for x, y in CELLS))
DOTS = Region(OUTER, tuple(Loop((Circle(c, 0.4, ccw=False),)) for c in CELLS))
PLACEMENTS: dict[str, Placement] = {
    "plane": Plane(2.0),
    "cylinder": Cylinder(30.0, 2.0),
    "sphere": Sphere(40.0, 2.0),
    "cone": Cone(30.0, 10.0, 2.0),
}


def symmetric_difference(a: object, b: object) -> float:
    """Volume of what one has and the other has not, mm³."""
    return sum(abs(occ.volume(BRepAlgoAPI_Cut(*pair).Shape())) for pair in ((a, b), (b, a)))


def test_a_plate_equals_boxes_cut_one_by_one() -> None:
    brute = BRepPrimAPI_MakeBox(gp_Pnt(-7, -7, 0), 14, 14, 2).Shape()
    for x, y in CELLS[:12]:
        brute = BRepAlgoAPI_Cut(
            brute, BRepPrimAPI_MakeBox(gp_Pnt(x - 0.4, y - 0.4, -1), 0.8, 0.8, 4).Shape()
        ).Shape()
    solid = build_profile(Profile((Region(OUTER, REGION.holes[:12]),)), Plane(2.0))
    assert symmetric_difference(solid.shape, brute) < 1e-6 * solid.volume_mm3


def test_flared_dots_equal_cones_cut_one_by_one() -> None:
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCone

    brute = BRepPrimAPI_MakeBox(gp_Pnt(-7, -7, 0), 14, 14, 2).Shape()
    wide = 0.4 + 2 * np.tan(np.radians(2.5))
    for x, y in CELLS[:12]:
        axis = gp_Ax2(gp_Pnt(x, y, 0), gp_Dir(0, 0, 1))
        brute = BRepAlgoAPI_Cut(brute, BRepPrimAPI_MakeCone(axis, wide, 0.4, 2.0).Shape()).Shape()
    solid = build_profile(Profile((Region(OUTER, DOTS.holes[:12]),)), Plane(2.0), Walls(draft_deg=2.5))
    assert symmetric_difference(solid.shape, brute) < 1e-6 * solid.volume_mm3


def test_a_difference_shows() -> None:
    """The oracle sees a hole that is missing."""
    one, two = (build_profile(Profile((Region(OUTER, REGION.holes[:k]),)), Plane(2.0)) for k in (4, 5))
    assert symmetric_difference(one.shape, two.shape) == pytest.approx(0.8 * 0.8 * 2)


def test_a_band_equals_sectors_cut_from_a_tube() -> None:
    """A hole on grid lines of a cylinder is a box in cylindrical coordinates."""
    solid = build_profile(Profile((Region(OUTER, (cell(0, 0),)),)), Cylinder(30.0, 2.0))

    def ring(low: float, high: float, angle: float) -> object:
        axis = gp_Ax2(gp_Pnt(0, low, 0), gp_Dir(0, 1, 0), gp_Dir(np.sin(-angle / 2), 0, np.cos(-angle / 2)))
        tube = [BRepPrimAPI_MakeCylinder(axis, r, high - low, angle).Shape() for r in (30.0, 28.0)]
        return BRepAlgoAPI_Cut(*tube).Shape()

    brute = BRepAlgoAPI_Cut(ring(-7, 7, 14 / 30), ring(-0.4, 0.4, 0.8 / 30)).Shape()
    assert symmetric_difference(solid.shape, brute) < 1e-6 * solid.volume_mm3


RING = Region(
    Loop.from_points([(-3, -3), (3, -3), (3, 3), (-3, 3)]),
    (Loop.from_points([(-2, -2), (-2, 2), (2, 2), (2, -2)]),),
)
SLOT = Region(OUTER, (Loop.from_points([(-5, -5), (-5, 5), (5, 5), (5, -5)]),))
BAR = Bridge((0.0, 3.0), (0.0, 5.0), 1.0, "function", 0.0, height_mm=0.6)


@functools.cache
def part(name: str) -> Solid:
    """Plates and curved walls, straight and drafted, with recessed bars and letters."""
    region, drafted = Region(OUTER, DOTS.holes[:8]), Walls(draft_deg=3.0, lip_mm=0.4)
    match name:
        case "drafted":
            return build_profile(Profile((region,)), Plane(2.0), drafted, name=name, colour=RED)
        case "recessed":
            return build_profile(
                Profile((SLOT, RING), (BAR,), SLOT), Plane(2.0), drafted, name=name, colour=RED
            )
        case "recessed on a cylinder":
            profile = Profile((SLOT, RING), (BAR,), SLOT, letters=_letter(), relief_mm=0.3)
            return build_profile(profile, Cylinder(30.0, 2.0), name=name, colour=RED)
        case _:
            return build_profile(
                Profile((Region(OUTER, REGION.holes[:8]),)),
                PLACEMENTS[name],
                name=name,
                colour=RED,
                chord_mm=0.02,
            )


def _letter() -> tuple[Region, ...]:
    """An O on the rim of the slot."""
    (letter,) = Caption("O", 1.0).letters()
    outer, counter = (Loop.from_points(loop.flatten(0.05) - (0.0, 6.0)) for loop in letter.loops)
    return (Region(outer, (counter,)),)


PARTS = [*PLACEMENTS, "drafted", "recessed", "recessed on a cylinder"]


@pytest.mark.parametrize("name", PARTS)
def test_meshes_are_one_manifold_body(name: str) -> None:
    import manifold3d

    solid = part(name)
    mesh = solid.triangles
    body = manifold3d.Manifold(manifold3d.Mesh64(np.array(mesh.vertices), mesh.faces.astype(np.uint64)))
    assert body.status() == manifold3d.Error.NoError
    assert len(body.decompose()) == 1
    assert body.genus() == (2 if name.startswith("recessed") else 8)
    corners = mesh.vertices[mesh.faces]
    doubled = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    assert doubled.min() > 1e-9


@pytest.mark.parametrize("name", PARTS)
def test_gmsh_reads_one_volume_of_the_same_size(name: str, tmp_path: Path) -> None:
    import gmsh

    solid = part(name)
    write_step(solid, tmp_path / "part.step")
    gmsh.initialize(["-nopopup"], False, False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setString("Geometry.OCCTargetUnit", "MM")
        volumes = gmsh.model.occ.importShapes(str(tmp_path / "part.step"))
        sizes = [gmsh.model.occ.getMass(*v) for v in volumes if v[0] == 3]
    finally:
        gmsh.finalize()
    assert sizes == pytest.approx([solid.volume_mm3], rel=1e-6)


@pytest.mark.skipif(shutil.which("prusa-slicer") is None, reason="prusa-slicer is not installed")
@pytest.mark.parametrize("name", ["drafted", "recessed"])
def test_prusaslicer_slices_without_a_warning(name: str, tmp_path: Path) -> None:
    import trimesh

    mesh = part(name).triangles
    trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).export(tmp_path / "p.stl")
    command = ["prusa-slicer", "--export-gcode", "-o", str(tmp_path / "p.gcode"), str(tmp_path / "p.stl")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    assert "warning" not in (done.stdout + done.stderr).lower()
    info = subprocess.run(
        ["prusa-slicer", "--info", str(tmp_path / "p.stl")],
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    assert "number_of_parts =  1" in info.stdout
    assert "manifold = yes" in info.stdout


@pytest.mark.skipif(shutil.which("freecadcmd") is None, reason="freecad (headless) is not installed")
def test_freecad_reads_one_valid_solid_of_each(tmp_path: Path) -> None:
    """Its headless form shows names but no colours; those are read back by the modeller, below."""
    files = [str(tmp_path / f"{k}.step") for k in range(len(PARTS))]
    for name, file in zip(PARTS, files, strict=True):
        write_step(part(name), file)
    script = tmp_path / "read.py"
    script.write_text(
        "import FreeCAD, Import, Part\n"
        f"for file in {files!r}:\n"
        "    shape = Part.Shape()\n"
        "    shape.read(file)\n"
        "    document = FreeCAD.newDocument()\n"
        "    Import.insert(file, document.Name)\n"
        "    name = document.Objects[0].Label\n"
        "    print('\\nFOUND', len(shape.Solids), shape.isValid(), repr(shape.Volume), name, sep='|')\n"
    )
    done = subprocess.run(
        ["freecadcmd", str(script)], capture_output=True, text=True, timeout=200, check=False
    )
    rows = [line.split("|")[1:] for line in done.stdout.splitlines() if line.startswith("FOUND")]
    assert [(solids, valid, name) for solids, valid, _, name in rows] == [("1", "True", n) for n in PARTS]
    volumes = [float(volume) for _, _, volume, _ in rows]
    assert volumes == pytest.approx([part(name).volume_mm3 for name in PARTS], rel=1e-6)


@pytest.mark.parametrize("name", PARTS)
def test_the_modeller_reads_name_and_colour(name: str, tmp_path: Path) -> None:
    write_step(part(name), tmp_path / "part.step")
    (read,) = read_step(tmp_path / "part.step")
    assert read.name == name
    assert read.colour == pytest.approx(RED, abs=1e-6)
