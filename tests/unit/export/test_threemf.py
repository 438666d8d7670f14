from __future__ import annotations

import re
import zipfile

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


def test_backing_is_a_second_colour_of_the_same_object(plate, tmp_path):
    design = plate.with_backing()
    threemf.write(design, tmp_path / "two.3mf")
    model = read_strictly(tmp_path / "two.3mf")
    names = {mesh.GetName(): body for mesh, body in meshes(model)}
    assert set(names) == {"test-part", "backing"}
    assert names["backing"].volume == pytest.approx(200.0)
    assert names["backing"].bounds[1, 2] == pytest.approx(names["test-part"].bounds[0, 2])
    assert colours(model) == {"test-part": (235, 235, 230, 255), "backing": (13, 13, 15, 255)}
    assert model.GetBuildItems().Count() == 1
    components = model.GetComponentsObjects()
    assert components.MoveNext()
    assert components.GetCurrentComponentsObject().GetComponentCount() == 2


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
