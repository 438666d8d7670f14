"""Codes in triangle meshes: read, mended or refused with counts, hollowed, carved, fitted."""

from pathlib import Path

import manifold3d
import numpy as np
import pytest
import trimesh
import zxingcpp

from perfqr_cad.errors import DesignError, KernelError
from perfqr_cad.geometry import Triangles
from perfqr_cad.hosts.mesh import MeshTarget, read_mesh
from perfqr_cad.hosts.mesh.hollow import hollowed
from perfqr_cad.hosts.mesh.repair import mend, self_crossings
from perfqr_cad.profile import Walls

from .imports import SHARED, SKETCH, STRAIGHT, code, few_holes, holes_area, seen


def triangles(mesh: trimesh.Trimesh) -> Triangles:
    return Triangles(mesh.vertices, mesh.faces)


def box(*extents: float) -> trimesh.Trimesh:
    return trimesh.creation.box(extents).subdivide().subdivide()


def bodies(mesh: Triangles) -> int:
    made = manifold3d.Manifold(manifold3d.Mesh64(np.array(mesh.vertices), np.array(mesh.faces, np.uint64)))
    assert made.status() == manifold3d.Error.NoError
    return len(made.decompose())


@pytest.mark.parametrize("kind", ["stl", "obj", "ply", "off"])
def test_formats(tmp_path: Path, kind: str) -> None:
    box(3, 4, 5).export(tmp_path / f"b.{kind}")
    assert mend(read_mesh(tmp_path / f"b.{kind}")).volume_mm3 == pytest.approx(60, rel=1e-6)


def test_3mf_units_places_and_components(tmp_path: Path) -> None:
    import zipfile

    solid = trimesh.creation.box((1, 1, 1))
    vertices = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in solid.vertices)
    faces = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in solid.faces)
    model = (
        '<model unit="inch" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><resources>'
        f'<object id="1"><mesh><vertices>{vertices}</vertices><triangles>{faces}</triangles></mesh></object>'
        '<object id="2"><components><component objectid="1" '
        'transform="2 0 0 0 1 0 0 0 1 0 0 0"/></components></object>'
        '</resources><build><item objectid="2" transform="1 0 0 0 1 0 0 0 1 5 0 0"/></build></model>'
    )
    with zipfile.ZipFile(tmp_path / "a.3mf", "w") as package:
        package.writestr("3D/3dmodel.model", model)
    mesh = read_mesh(tmp_path / "a.3mf")
    assert mesh.volume_mm3 == pytest.approx(2 * 25.4**3)
    assert mesh.vertices[:, 0].mean() == pytest.approx(5 * 25.4)


def test_files_that_are_no_meshes(tmp_path: Path) -> None:
    for name, data, says in (
        ("a.stl", b"", "cannot be read|no triangles"),
        ("a.txt", b"x", "no mesh this program reads"),
        ("a.3mf", b"x", "no readable 3MF"),
    ):
        (tmp_path / name).write_bytes(data)
        with pytest.raises(KernelError, match=says):
            read_mesh(tmp_path / name)
    with pytest.raises(KernelError, match="No such file"):
        read_mesh(tmp_path / "none.stl")


def test_small_damage_is_mended() -> None:
    mesh = box(10, 10, 10)
    faces = np.array(mesh.faces)
    faces[5] = faces[5][::-1]  # one triangle turned
    torn = Triangles(mesh.vertices, np.vstack([faces[1:], faces[7:8]]))  # one lost, one doubled
    mended = mend(torn)
    assert mended.closed
    assert mended.volume_mm3 == pytest.approx(1000)
    assert len(mended.faces) == len(mesh.faces) - 1 + 3  # one lost, a fan of three in its gap, none doubled
    inside_out = mend(Triangles(mesh.vertices, mesh.faces[:, ::-1]))
    assert inside_out.volume_mm3 == pytest.approx(1000)


def test_great_damage_is_refused_with_counts() -> None:
    mesh = box(10, 10, 10)
    lid = mesh.triangles_center[:, 2] > 4.9
    with pytest.raises(KernelError, match=r"open: 16 edges .* in 1 rims, the longest 40 mm"):
        mend(Triangles(mesh.vertices, mesh.faces[~lid]))
    fin = np.vstack([mesh.vertices, [[20.0, 0, 0]]])
    edge = mesh.faces[0][:2]
    sheet = np.array([[edge[0], edge[1], len(fin) - 1], [edge[1], edge[0], len(fin) - 1]])
    with pytest.raises(KernelError, match=r"(not a surface of a body|open).*edges"):
        mend(Triangles(fin, np.vstack([mesh.faces, sheet[:1]])))


def test_self_intersection_is_counted() -> None:
    assert self_crossings(triangles(box(10, 10, 10))) == 0
    mesh = trimesh.creation.icosphere(2, 10.0)
    pushed = np.array(mesh.vertices)
    pushed[np.argmax(pushed[:, 2])] = [0.7, 0.4, -25.0]  # the top drawn out through the bottom
    with pytest.raises(KernelError, match=r"cuts through itself at \d+ edges"):
        mend(Triangles(pushed, mesh.faces))


def test_several_bodies() -> None:
    left, right = box(10, 10, 10), box(12, 12, 12)
    right.apply_translation((6, 1, 2))
    assert bodies(mend(triangles(left).joined(triangles(right)))) == 1
    right.apply_translation((100, 0, 0))
    apart = triangles(left).joined(triangles(right))
    with pytest.raises(DesignError, match=r"2 separate bodies \(1728, 1000 mm³\)"):
        mend(apart)
    assert mend(apart, 2).volume_mm3 == pytest.approx(1000)
    void = box(6, 6, 6)
    assert mend(triangles(left).joined(triangles(void))).volume_mm3 == pytest.approx(1000 - 216)


def test_hollow_leaves_a_shell_of_the_given_thickness() -> None:
    sphere = triangles(trimesh.creation.icosphere(4, 20.0))
    shell = hollowed(sphere, 2.0)
    assert shell.closed
    assert shell.volume_mm3 == pytest.approx(4 / 3 * np.pi * (20**3 - 18**3), rel=0.02)
    with pytest.raises(DesignError, match="no part of the body is deeper"):
        hollowed(triangles(box(30, 30, 3)), 2.0)


def test_a_shell_is_carved_through_and_stays_one_body() -> None:
    target = MeshTarget.of(triangles(trimesh.creation.icosphere(4, 30.0)), hollow_mm=2.0, point=(0, 0, 30))
    placement = target.placement(SKETCH.size_mm)
    solid = target.solid(SKETCH, placement, STRAIGHT)
    assert solid.shape is None
    assert solid.triangles.closed
    removed = target.body.triangles.volume_mm3 - solid.volume_mm3
    assert removed == pytest.approx(holes_area(few_holes()) * placement.thickness_mm, rel=0.02)
    assert placement.thickness_mm == pytest.approx(2.0, abs=0.15)


def test_a_solid_mesh_asks_for_hollow_or_depth() -> None:
    mesh = triangles(box(40, 40, 40))
    with pytest.raises(DesignError, match=r"40 mm of material.*set depth.*hollow"):
        MeshTarget.of(mesh, point=(0, 0, 20)).placement(20)
    target = MeshTarget.of(mesh, point=(0, 0, 20))
    solid = target.solid(SKETCH, target.placement(20, 1.0), Walls(depth_mm=1.0))
    assert mesh.volume_mm3 - solid.volume_mm3 == pytest.approx(holes_area(few_holes()), rel=5e-3)


def test_the_flattest_spot_is_taken_and_a_bad_one_refused() -> None:
    mesh = triangles(trimesh.creation.capsule(height=60, radius=20, count=[48, 48]))
    target = MeshTarget.of(mesh)
    normal = target.placement(15, 0.5).normal([(0, 0)])[0]
    assert abs(normal[2]) < 0.2
    with pytest.raises(DesignError, match=r"use --size|no place"):
        MeshTarget.of(mesh, point=(0, 0, 100), direction=(0, 0, -1)).placement(39, 0.5)


def test_an_exact_panel_states_its_fit() -> None:
    target = MeshTarget.of(
        triangles(trimesh.creation.icosphere(5, 60.0)), hollow_mm=2.0, point=(0, 0, 60), exact=True
    )
    placement = target.placement(20)
    solid = target.solid(SKETCH, placement, STRAIGHT)
    assert solid.valid
    assert solid.shape is not None
    assert "fitted within 0.0" in solid.name
    area = SKETCH.size_mm**2 - holes_area(few_holes())
    assert solid.volume_mm3 == pytest.approx(area * placement.thickness_mm, rel=1e-3)


def test_the_code_reads_from_outside() -> None:
    pattern = code("PERFQR", 22.0)
    target = MeshTarget.of(triangles(trimesh.creation.icosphere(4, 30.0)), hollow_mm=1.5, point=(5, -29, 8))
    placement = target.placement(22.0)
    solid = target.solid(pattern, placement, STRAIGHT)
    found = zxingcpp.read_barcodes(seen(solid.triangles, placement, 22.0))
    assert [b.text for b in found] == ["PERFQR"]


@pytest.mark.skipif(not SHARED.is_dir(), reason="needs the shared meshes")
def test_the_bunny() -> None:
    target = MeshTarget(SHARED / "meshes" / "bunny.off", extent_mm=189.0, hollow_mm=3.0, up=(0, 1, 0))
    placement = target.placement(50.0)
    solid = target.solid(SKETCH, placement, STRAIGHT)
    assert bodies(solid.triangles) >= 1
    assert solid.triangles.closed
    assert max(np.ptp(solid.triangles.vertices, axis=0)) == pytest.approx(189.0, rel=1e-6)
