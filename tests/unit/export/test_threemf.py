from __future__ import annotations

import re
import shutil
import subprocess
import zipfile
from dataclasses import replace

import lib3mf
import numpy as np
import pytest
import trimesh

from perfqr_cad.export import threemf


def read_strictly(path):
    """The model by the format's own library, every departure from the specification an error."""
    model = lib3mf.get_wrapper().CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    reader.ReadFromFile(str(path))
    assert [reader.GetWarning(i) for i in range(reader.GetWarningCount())] == []
    return model


def meshes(model):
    objects, found = model.GetMeshObjects(), []
    while objects.MoveNext():
        mesh = objects.GetCurrentMeshObject()
        vertices = [tuple(v.Coordinates) for v in mesh.GetVertices()]
        faces = [tuple(t.Indices) for t in mesh.GetTriangleIndices()]
        found.append((mesh, trimesh.Trimesh(vertices, faces, process=False)))
    return found


def colours(model):
    groups, found = model.GetBaseMaterialGroups(), {}
    while groups.MoveNext():
        group = groups.GetCurrentBaseMaterialGroup()
        for number in group.GetAllPropertyIDs():
            c = group.GetDisplayColor(number)
            found[group.GetName(number)] = (c.Red, c.Green, c.Blue, c.Alpha)
    return found


def test_one_part(plate, tmp_path):
    threemf.write(plate, tmp_path / "part.3mf")
    model = read_strictly(tmp_path / "part.3mf")
    [(mesh, body)] = meshes(model)
    assert mesh.GetName() == "test-part"
    assert mesh.IsManifoldAndOriented()
    assert body.volume == pytest.approx(plate.solid.triangles.volume_mm3, rel=1e-6)
    assert body.bounds == pytest.approx(np.array([[-10, -5, 0], [10, 5, 2]]))
    assert model.GetUnit() == lib3mf.ModelUnit.MilliMeter
    assert model.GetBuildItems().Count() == 1


def test_a_backing_is_a_second_shell_and_colour_of_the_same_mesh(plate, tmp_path):
    threemf.write(plate.with_backing(), tmp_path / "two.3mf")
    model = read_strictly(tmp_path / "two.3mf")
    [(mesh, body)] = meshes(model)
    assert mesh.IsManifoldAndOriented()
    part, backing = sorted(body.split(only_watertight=True), key=lambda shell: -shell.bounds[0, 2])
    assert (part.volume, backing.volume) == pytest.approx((plate.solid.triangles.volume_mm3, 200.0), rel=1e-6)
    assert backing.bounds[:, 2] == pytest.approx([0, 1])
    assert part.bounds[:, 2] == pytest.approx([1, 3])
    assert colours(model) == {"test-part": (235, 235, 230, 255), "backing": (13, 13, 15, 255)}
    assert model.GetBuildItems().Count() == 1
    drawn = triangle_colours(model, mesh)
    assert [drawn[0], drawn[-1]] == [(235, 235, 230, 255), (13, 13, 15, 255)]
    assert drawn.count(drawn[0]) == len(plate.solid.triangles.faces)


def triangle_colours(model, mesh):
    """The colour of each triangle by the materials extension."""
    found = []
    for k in range(mesh.GetTriangleCount()):
        properties = mesh.GetTriangleProperties(k)
        c = model.GetColorGroupByID(properties.ResourceID).GetColor(properties.PropertyIDs[0])
        found.append((c.Red, c.Green, c.Blue, c.Alpha))
    return found


def test_one_body_needs_no_colours_and_no_extruders(plate, tmp_path):
    threemf.write(plate, tmp_path / "part.3mf")
    with zipfile.ZipFile(tmp_path / "part.3mf") as package:
        assert threemf.EXTRUDERS_PART not in package.namelist()
        assert b"colorgroup" not in package.read("3D/3dmodel.model")


def test_what_lies_below_the_bed_is_lifted_and_nothing_else(plate, tmp_path):
    for shift, low in ((-5.0, 0.0), (5.0, 5.0)):
        triangles = plate.solid.triangles
        moved = replace(triangles, vertices=triangles.vertices + np.array([0, 0, shift]))
        threemf.write(replace(plate, solid=replace(plate.solid, triangles=moved)), tmp_path / "part.3mf")
        [(_, body)] = meshes(read_strictly(tmp_path / "part.3mf"))
        assert body.bounds[:, 2] == pytest.approx([low, low + 2])


@pytest.fixture
def sliced(tmp_path):
    """What PrusaSlicer's command line lays of a file: mm³ and the lowest layer, by tool."""

    def slice_it(path):
        command = ["prusa-slicer", "--nozzle-diameter", "0.4,0.4", "--filament-diameter", "1.75,1.75"]
        command += ["--use-relative-e-distances", "--skirts", "0", "--layer-height", "0.2"]
        command += ["--first-layer-height", "0.2", "--fill-density", "100%", "--fill-pattern", "rectilinear"]
        command += ["--export-gcode", "-o", str(tmp_path / "p.gcode"), str(path)]
        done = subprocess.run(command, capture_output=True, text=True, timeout=200, check=False)
        assert done.returncode == 0, done.stderr
        laid, lowest, tool, z = {}, {}, 0, 0.0
        for line in (tmp_path / "p.gcode").read_text().splitlines():
            if match := re.match(r"T(\d)", line):
                tool = int(match[1])
            elif match := re.match(r"G1 Z([.\d]+)", line):
                z = float(match[1])
            elif match := re.match(r"G1 X\S+ Y\S+ E([.\d]+)", line):
                laid[tool] = laid.get(tool, 0.0) + float(match[1]) * np.pi * (1.75 / 2) ** 2
                lowest[tool] = min(lowest.get(tool, np.inf), z)
        return laid, lowest

    return slice_it


@pytest.mark.skipif(not shutil.which("prusa-slicer"), reason="prusa-slicer is not installed")
def test_prusaslicer_prints_two_colours_one_upon_the_other(plate, tmp_path, sliced):
    threemf.write(plate.with_backing(), tmp_path / "two.3mf")
    laid, lowest = sliced(tmp_path / "two.3mf")
    assert laid == pytest.approx({0: plate.solid.triangles.volume_mm3, 1: 200.0}, rel=0.05)
    assert lowest == pytest.approx({0: 1.2, 1: 0.2})


@pytest.mark.skipif(not shutil.which("prusa-slicer"), reason="prusa-slicer is not installed")
def test_without_its_extruders_all_is_printed_by_one_tool(plate, tmp_path, sliced):
    """The check above can fail."""
    threemf.write(plate.with_backing(), tmp_path / "two.3mf")
    with (
        zipfile.ZipFile(tmp_path / "two.3mf") as two,
        zipfile.ZipFile(tmp_path / "one.3mf", "w") as one,
    ):
        for name in set(two.namelist()) - {threemf.EXTRUDERS_PART}:
            one.writestr(name, two.read(name))
    laid, _ = sliced(tmp_path / "one.3mf")
    assert set(laid) == {0}


def test_same_bytes_again_and_no_clock(plate, tmp_path):
    for name in ("a.3mf", "b.3mf"):
        threemf.write(plate, tmp_path / name)
    assert (tmp_path / "a.3mf").read_bytes() == (tmp_path / "b.3mf").read_bytes()
    with zipfile.ZipFile(tmp_path / "a.3mf") as package:
        assert {info.date_time for info in package.infolist()} == {(1980, 1, 1, 0, 0, 0)}
        assert not re.search(rb"20\d\d-\d\d-\d\d", package.read("3D/3dmodel.model"))


def test_strict_reader_refuses_what_is_wrong(plate, tmp_path):
    """The check above can fail: an index out of range is noticed."""
    threemf.write(plate, tmp_path / "good.3mf")
    with (
        zipfile.ZipFile(tmp_path / "good.3mf") as good,
        zipfile.ZipFile(tmp_path / "bad.3mf", "w") as bad,
    ):
        for name in good.namelist():
            bad.writestr(name, good.read(name).replace(b'v1="0"', b'v1="999999"'))
    with pytest.raises(lib3mf.ELib3MFException):
        read_strictly(tmp_path / "bad.3mf")
