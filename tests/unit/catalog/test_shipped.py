"""The shipped templates from end to end on small parts that are made here, and what they refuse."""

from collections.abc import Callable
from pathlib import Path

import pytest
from build123d import Box, Compound, Cylinder, Pos, export_step
from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer

from perfqr_cad import catalog
from perfqr_cad.cli import main
from perfqr_cad.geometry import Triangles
from perfqr_cad.hosts.step import mesh_shape
from perfqr_cad.solid.kernel import booleans as kernel
from perfqr_cad.solid.kernel.to_shape import solid_of

SMALL = {"text": "A", "level": "L", "quiet": 2, "nozzle": 0.3}
SIZE_MM = 24.0


def step(path: Path, part: object) -> Path:
    """A part as a STEP file."""
    export_step(part, path)
    return path


def stl(path: Path, mesh: Triangles) -> Path:
    """A mesh as a binary STL file."""
    import trimesh

    trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).export(path)
    return path


def tray() -> object:
    return Box(34, 2, 34)


def made(name: str, folder: Path) -> dict[str, object]:
    """Parameters of a small part of each template, with the files they name."""
    match name:
        case "bottle":
            return {"size": SIZE_MM, "diameter": 50.0, "thickness": 1.0}
        case "sphere":
            return {"size": SIZE_MM, "diameter": 56.0, "thickness": 1.0, "finder": "recessed"}
        case "step-face":
            return {"solid": str(step(folder / "tray.step", tray())), "size": SIZE_MM, "face": 3}
        case _:
            return {"mesh": str(stl(folder / "tray.stl", mesh_shape(tray()))), "size": SIZE_MM}


@pytest.mark.parametrize("name", ["bottle", "sphere", "step-face", "mesh"])
def test_a_template_makes_a_part_that_reads(name: str, tmp_path: Path) -> None:
    design = catalog.find(name).build(SMALL | made(name, tmp_path))
    assert design.scan.readers
    assert design.solid.valid
    assert design.pattern.size_mm == pytest.approx(SIZE_MM)
    written = design.written([tmp_path / "part.stl", tmp_path / "part.json"])
    assert all((tmp_path / file).stat().st_size > 1000 for file in ("part.stl", "part.json"))
    assert len(written.files) == 2


def no_file(folder: Path) -> list[str]:
    return ["-t", "step-face", "-D", f"solid={folder / 'none.step'}"]


def empty_name(folder: Path) -> list[str]:
    return ["-t", "mesh"]


def no_solid(folder: Path) -> list[str]:
    sheet = kernel.explore(solid_of(kernel.faces(Box(30, 30, 2).wrapped)[:5]), "SHELL")[0]
    writer = STEPControl_Writer()
    writer.Transfer(sheet, STEPControl_StepModelType.STEPControl_ShellBasedSurfaceModel)
    writer.Write(str(folder / "sheet.step"))
    return ["-t", "step-face", "-D", f"solid={folder / 'sheet.step'}"]


def assembly(folder: Path) -> list[str]:
    left, right = Box(34, 2, 34), Pos(0, 10, 0) * Box(34, 2, 34)
    left.label, right.label = "door", "frame"
    path = step(folder / "two.step", Compound(children=[left, right]))
    return ["-t", "step-face", "-D", f"solid={path}"]


def cut_short(folder: Path) -> list[str]:
    path = step(folder / "tray.step", tray())
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    return ["-t", "step-face", "-D", f"solid={path}"]


def too_small(folder: Path) -> list[str]:
    return ["-t", "step-face", "-D", f"solid={step(folder / 'rod.step', Cylinder(3, 60))}"]


def block(folder: Path) -> list[str]:
    return ["-t", "step-face", "-D", f"solid={step(folder / 'block.step', Box(60, 60, 60))}"]


def no_such_face(folder: Path) -> list[str]:
    return ["-t", "step-face", "-D", f"solid={step(folder / 'tray.step', tray())}", "-D", "face=7"]


def open_mesh(folder: Path) -> list[str]:
    whole = mesh_shape(Box(34, 2, 34))
    path = stl(folder / "open.stl", Triangles(whole.vertices, whole.faces[: len(whole.faces) // 2]))
    return ["-t", "mesh", "-D", f"mesh={path}"]


def cut_mesh(folder: Path) -> list[str]:
    path = stl(folder / "tray.stl", mesh_shape(Box(34, 2, 34)))
    path.write_bytes(path.read_bytes()[:400])
    return ["-t", "mesh", "-D", f"mesh={path}"]


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (no_file, "none.step"),
        (empty_name, "name an STL, OBJ, PLY, OFF or 3MF file"),
        (no_solid, "close and stitch"),
        (assembly, "choose part='door', 'frame'"),
        (cut_short, "cut short"),
        (too_small, "no face of"),
        (block, "set depth"),
        (no_such_face, "has faces 1 to 6"),
        (open_mesh, "open"),
        (cut_mesh, "export the mesh again"),
    ],
)
def test_bad_input_is_one_line_with_a_remedy(
    arguments: Callable[[Path], list[str]], says: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    settings = [f"-D{name}={value}" for name, value in (SMALL | {"size": SIZE_MM}).items()]
    with pytest.raises(SystemExit) as stop:
        main(["make", *settings, *arguments(tmp_path), "-o", str(tmp_path / "part.stl")])
    told = capsys.readouterr().err
    assert stop.value.code == 2
    assert told.startswith("error: ")
    assert told.count("\n") == 1
    assert says in told
    assert not (tmp_path / "part.stl").exists()
