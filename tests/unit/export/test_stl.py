from __future__ import annotations

import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from perfqr_cad import export
from perfqr_cad.errors import DesignError
from perfqr_cad.export import stl
from perfqr_cad.geometry import Triangles


@pytest.fixture
def read(tmp_path):
    def read_back(design):
        stl.write(design, tmp_path / "part.stl")
        return trimesh.load_mesh(tmp_path / "part.stl")

    return read_back


def test_mesh_is_closed_with_the_part_s_volume(plate, read):
    mesh = read(plate)
    assert mesh.is_watertight
    assert mesh.body_count == 1
    assert mesh.volume == pytest.approx(plate.solid.triangles.volume_mm3, rel=1e-6)
    assert mesh.volume == pytest.approx(plate.solid.volume_mm3, rel=2e-3)
    assert mesh.extents == pytest.approx([20, 10, 2])


def test_normals_point_outward(plate, read):
    mesh = read(plate)
    front = np.isclose(mesh.triangles[..., 2].min(axis=1), mesh.bounds[1, 2])
    assert front.any()
    assert mesh.face_normals[front] == pytest.approx(np.tile([0, 0, 1], (front.sum(), 1)))


def test_stored_normals_agree_with_the_corners(plate, tmp_path):
    stl.write(plate, tmp_path / "part.stl")
    facets = np.frombuffer((tmp_path / "part.stl").read_bytes()[84:], stl.FACET)
    a, b, c = np.moveaxis(facets["corners"].astype(float), 1, 0)
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    assert facets["normal"] == pytest.approx(normal, abs=1e-6)


def test_same_bytes_again(plate, tmp_path):
    for name in ("a.stl", "b.stl"):
        stl.write(plate, tmp_path / name)
    assert (tmp_path / "a.stl").read_bytes() == (tmp_path / "b.stl").read_bytes()


def test_an_edge_below_single_precision_leaves_no_crack(plate, read):
    """Two vertices 1e-9 mm apart at 100 mm are one in single precision: their triangles must go."""
    box = trimesh.creation.box((10, 10, 10)).apply_translation([100, 100, 100])
    a, b = box.edges_unique[0]
    vertices = np.vstack([box.vertices, box.vertices[a] + 1e-9 * (box.vertices[b] - box.vertices[a])])
    new = len(vertices) - 1
    faces = [f for face in box.faces for f in _split(tuple(face), a, b, new)]
    mesh = Triangles(vertices, np.array(faces))
    assert mesh.closed
    assert len(mesh.faces) == 14
    back = read(replace(plate, solid=replace(plate.solid, triangles=mesh)))
    assert back.is_watertight
    assert len(back.faces) == 12


def _split(face, a, b, new):
    for k in range(3):
        p, q, r = face[k], face[(k + 1) % 3], face[(k + 2) % 3]
        if {p, q} == {a, b}:
            return [(p, new, r), (new, q, r)]
    return [face]


@pytest.mark.skipif(not shutil.which("prusa-slicer"), reason="prusa-slicer is not installed")
@pytest.mark.parametrize("name", ["part.stl", "part.3mf"])
def test_prusa_slicer_slices_without_a_warning(code, tmp_path, name):
    export.write(code.with_backing() if name == "part.3mf" else code, tmp_path / name)
    command = ["prusa-slicer", "--export-gcode", "--output", "part.gcode", name]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False, cwd=tmp_path)
    said = (done.stdout + done.stderr).lower()
    assert done.returncode == 0, said
    assert "warning" not in said
    assert "error" not in said
    assert (tmp_path / "part.gcode").stat().st_size > 10_000


def test_split_gives_each_body_a_file_where_it_lies(plate, tmp_path):
    records = export.write_outputs(
        plate.with_backing(), [tmp_path / "part.stl"], export.Options(split_stl=True)
    )
    assert [record.path.rsplit("/")[-1] for record in records] == ["part.stl", "part-backing.stl"]
    assert all(record.remarks == "" for record in records)
    part, backing = (trimesh.load_mesh(record.path) for record in records)
    assert part.bounds[:, 2] == pytest.approx([0, 2])
    assert backing.bounds[:, 2] == pytest.approx([-1, 0])
    assert backing.is_watertight
    assert backing.volume == pytest.approx(200.0, rel=1e-6)


def test_without_split_the_backing_is_left_out_and_named(plate, tmp_path):
    [record] = export.write_outputs(plate.with_backing(), [tmp_path / "part.stl"])
    assert record.leaves_out == ("the backing",)
    assert [path.name for path in tmp_path.iterdir()] == ["part.stl"]


def test_bodies_of_one_name_get_files_of_their_own(plate, tmp_path):
    solid = plate.with_backing().solid
    twice = replace(solid, extras=(solid.extras[0], replace(solid.extras[0], name="backing/")))
    names = [path.name for path in stl.further(replace(plate, solid=twice), tmp_path / "a.stl")]
    assert names == ["a-backing.stl", "a-backing-2.stl"]


def test_a_name_that_splitting_would_take_twice_is_refused(plate, tmp_path):
    wanted = [tmp_path / "a.stl", tmp_path / "a-backing.stl"]
    with pytest.raises(DesignError, match=r"a-backing\.stl would be written twice"):
        export.write_outputs(plate.with_backing(), wanted, export.Options(split_stl=True))
    assert not list(tmp_path.iterdir())
