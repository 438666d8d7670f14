"""A plate is filmed and read; a wrong payload is never success."""

import importlib.util
from pathlib import Path

import pytest

from perfqr_cad import scan
from perfqr_cad.errors import KernelError
from perfqr_cad.geometry import Triangles

_spec = importlib.util.spec_from_file_location("plates", Path(__file__).with_name("plates.py"))
plates = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(plates)

TEXT = "perfqr"


@pytest.fixture(scope="module")
def triangles() -> Triangles:
    return plates.plate(plates.modules(TEXT, version=2), 40.0, 1.2)


def test_core_decoders_read_the_plate_from_above(triangles):
    report = scan.certify(triangles, None, None, TEXT, schedule=scan.Schedule((0.0,), (65.0,)))
    assert report.readers == ("zxing-cpp", "zbar", "wechat", "opencv")
    assert report.as_dict()["decoders"]["zbar"]["max_tilt_deg"] == 0


def test_wrong_payload_is_no_success(triangles):
    report = scan.certify(triangles, None, None, TEXT + "!", schedule=scan.Schedule((0.0,), (65.0,)))
    assert report.readers == ()
    assert {r.max_tilt_deg for r in report.decoders.values()} == {None}


def test_a_written_stl_is_filmed_too(triangles, tmp_path):
    import trimesh

    path = tmp_path / "part.stl"
    trimesh.Trimesh(triangles.vertices, triangles.faces).export(path)
    report = scan.certify(
        scan.load_mesh(path), None, None, TEXT, schedule=scan.Schedule((0.0,), (65.0,)), decoders=["zbar"]
    )
    assert report.readers == ("zbar",)


def test_missing_and_empty_meshes_are_refused(tmp_path):
    with pytest.raises(KernelError, match="No such file"):
        scan.load_mesh(tmp_path / "none.stl")
    (tmp_path / "empty.stl").write_bytes(b"")
    with pytest.raises(KernelError, match=r"empty\.stl"):
        scan.load_mesh(tmp_path / "empty.stl")
    with pytest.raises(KernelError, match="0 triangles"):
        scan.certify(Triangles([], []), None, None, TEXT)
