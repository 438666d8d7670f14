from __future__ import annotations

import re
import shutil
import subprocess
import zipfile
from dataclasses import replace
from xml.etree import ElementTree

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


needs_slicer = pytest.mark.skipif(not shutil.which("prusa-slicer"), reason="prusa-slicer is not installed")


@pytest.fixture
def sliced(tmp_path):
    """What PrusaSlicer's command line lays of a file: mm³ and lowest layer by tool, mm³ laid at each stop."""

    def slice_it(path, tools=2):
        command = ["prusa-slicer", "--nozzle-diameter", ",".join(["0.4"] * tools)]
        command += ["--filament-diameter", ",".join(["1.75"] * tools)]
        command += ["--use-relative-e-distances", "--skirts", "0", "--layer-height", "0.2"]
        command += ["--first-layer-height", "0.2", "--fill-density", "100%", "--fill-pattern", "rectilinear"]
        command += ["--export-gcode", "-o", str(tmp_path / "p.gcode"), str(path)]
        done = subprocess.run(command, capture_output=True, text=True, timeout=200, check=False)
        assert done.returncode == 0, done.stderr
        laid, lowest, stops, tool, z = {}, {}, [], 0, 0.0
        for line in (tmp_path / "p.gcode").read_text().splitlines():
            if match := re.match(r"T(\d)", line):
                tool = int(match[1])
            elif line.startswith("M600"):
                stops.append(sum(laid.values()))
            elif match := re.match(r"G1 Z([.\d]+)", line):
                z = float(match[1])
            elif match := re.match(r"G1 X\S+ Y\S+ E([.\d]+)", line):
                laid[tool] = laid.get(tool, 0.0) + float(match[1]) * np.pi * (1.75 / 2) ** 2
                lowest[tool] = min(lowest.get(tool, np.inf), z)
        return laid, lowest, stops

    return slice_it


@needs_slicer
def test_prusaslicer_prints_two_colours_one_upon_the_other(plate, tmp_path, sliced):
    threemf.write(plate.with_backing(), tmp_path / "two.3mf")
    laid, lowest, stops = sliced(tmp_path / "two.3mf")
    assert laid == pytest.approx({0: plate.solid.triangles.volume_mm3, 1: 200.0}, rel=0.05)
    assert lowest == pytest.approx({0: 1.2, 1: 0.2})
    assert stops == []


@needs_slicer
def test_without_its_extruders_all_is_printed_by_one_tool(plate, tmp_path, sliced):
    """The check above can fail."""
    threemf.write(plate.with_backing(), tmp_path / "two.3mf")
    without(threemf.EXTRUDERS_PART, tmp_path / "two.3mf", tmp_path / "one.3mf")
    laid, _, _ = sliced(tmp_path / "one.3mf")
    assert set(laid) == {0}


@needs_slicer
def test_one_nozzle_stops_once_where_the_part_begins(plate, tmp_path, sliced):
    """At the stop the backing is laid and nothing of the part. Without its list there is none."""
    threemf.write(plate.with_backing(), tmp_path / "one.3mf", colour_change=True)
    laid, _, stops = sliced(tmp_path / "one.3mf", tools=1)
    assert laid == pytest.approx({0: plate.solid.triangles.volume_mm3 + 200.0}, rel=0.05)
    assert stops == pytest.approx([200.0], rel=0.05)
    without(threemf.CHANGES_PART, tmp_path / "one.3mf", tmp_path / "none.3mf")
    assert sliced(tmp_path / "none.3mf", tools=1)[2] == []


def without(part, source, copy):
    """The package without one of its parts."""
    with zipfile.ZipFile(source) as whole, zipfile.ZipFile(copy, "w") as less:
        for name in set(whole.namelist()) - {part}:
            less.writestr(name, whole.read(name))


def test_the_list_of_parts_covers_the_mesh_and_names_an_extruder_each(plate, tmp_path):
    """What no slicer is needed for: ranges without gaps, each a closed body, and Orca's word."""
    two = plate.with_backing()
    threemf.write(two, tmp_path / "two.3mf")
    [(mesh, body)] = meshes(model := read_strictly(tmp_path / "two.3mf"))
    with zipfile.ZipFile(tmp_path / "two.3mf") as package:
        config = ElementTree.fromstring(package.read(threemf.EXTRUDERS_PART))
    [listed] = config.findall("object")
    assert listed.get("id") == str(mesh.GetModelResourceID())
    ranges = [(int(v.get("firstid")), int(v.get("lastid"))) for v in listed.findall("volume")]
    assert [ranges[0][0], ranges[-1][1]] == [0, len(body.faces) - 1]
    assert ranges[1][0] == ranges[0][1] + 1
    shells = [trimesh.Trimesh(body.vertices, body.faces[a : b + 1], process=False) for a, b in ranges]
    assert all(shell.is_watertight for shell in shells)
    assert [shell.volume for shell in shells] == pytest.approx(
        [two.solid.triangles.volume_mm3, 200.0], rel=1e-6
    )
    said = [{m.get("key"): m.get("value") for m in v.findall("metadata")} for v in listed.findall("volume")]
    assert [(one["name"], one["extruder"]) for one in said] == [("test-part", "1"), ("backing", "2")]
    [application] = [
        data.GetValue()
        for k in range(model.GetMetaDataGroup().GetMetaDataCount())
        if (data := model.GetMetaDataGroup().GetMetaData(k)).GetName() == "Application"
    ]
    assert "PrusaSlicer" in application
    assert not application.startswith("PrusaSlicer")


def test_a_change_of_colour_stands_above_the_lower_body_and_leaves_one_tool(plate, tmp_path):
    threemf.write(plate.with_backing(), tmp_path / "one.3mf", colour_change=True)
    read_strictly(tmp_path / "one.3mf")
    with zipfile.ZipFile(tmp_path / "one.3mf") as package:
        assert threemf.EXTRUDERS_PART not in package.namelist()
        [code] = ElementTree.fromstring(package.read(threemf.CHANGES_PART)).findall("code")
    assert 1.0 < float(code.get("print_z")) < 1.05
    assert (code.get("gcode"), code.get("color")) == ("M600", "#EBEBE6")


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
