from __future__ import annotations

import json
import struct

import pytest
import trimesh

from perfqr_cad.export import glb


def test_another_reader_sees_the_part_in_metres(plate, tmp_path):
    glb.write(plate, tmp_path / "part.glb")
    scene = trimesh.load(tmp_path / "part.glb")
    [mesh] = scene.geometry.values()
    assert mesh.is_watertight
    assert mesh.volume * 1e9 == pytest.approx(plate.solid.triangles.volume_mm3, rel=1e-5)
    assert mesh.extents * 1e3 == pytest.approx([20, 10, 2])


def test_backing_has_its_own_name_and_colour(plate, tmp_path):
    glb.write(plate.with_backing(), tmp_path / "two.glb")
    scene = trimesh.load(tmp_path / "two.glb")
    assert set(scene.geometry) == {"test-part", "backing"}
    data = (tmp_path / "two.glb").read_bytes()
    length = struct.unpack_from("<I", data, 12)[0]
    materials = json.loads(data[20 : 20 + length])["materials"]
    found = [m["pbrMetallicRoughness"]["baseColorFactor"] for m in materials]
    # Linear light, as glTF asks for, of sRGB 0.92, 0.90 and 0.05, 0.06.
    assert found[0] == pytest.approx([0.8276, 0.8276, 0.7874, 1.0], abs=2e-4)
    assert found[1] == pytest.approx([0.0039, 0.0039, 0.0048, 1.0], abs=2e-4)
    assert struct.unpack_from("<I", data, 8)[0] == len(data)


def test_same_bytes_again(plate, tmp_path):
    for name in ("a.glb", "b.glb"):
        glb.write(plate, tmp_path / name)
    assert (tmp_path / "a.glb").read_bytes() == (tmp_path / "b.glb").read_bytes()
