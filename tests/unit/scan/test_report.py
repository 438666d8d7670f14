"""Limits by tilt, the certificate's section, advice and the heat map; `perfqr scan PART` on files."""

import importlib.util
import json
from pathlib import Path

import numpy as np
import pytest

from perfqr_cad import scan
from perfqr_cad.errors import AnalysisError, DesignError, KernelError
from perfqr_cad.geometry import Triangles
from perfqr_cad.scan import DecoderResult, ScanReport
from perfqr_cad.scan.advice import sentences

_spec = importlib.util.spec_from_file_location("plates", Path(__file__).with_name("plates.py"))
plates = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(plates)

TILTS = (0.0, 20.0, 30.0, 45.0)
ONCE = scan.Schedule((0.0,), (65.0,))


def result(name, rates, flat=(1.0, 1.0, 1.0, 1.0)) -> DecoderResult:
    return DecoderResult(name, TILTS, rates, flat)


def report(*results) -> ScanReport:
    return ScanReport("text", {r.name: r for r in results}, {"black": 1.0})


def test_the_limit_is_the_last_tilt_read_from_all_sides():
    assert result("a", (1.0, 1.0, 0.5, 1.0)).max_tilt_deg == 20
    assert result("a", (0.0, 1.0, 1.0, 1.0)).max_tilt_deg is None
    assert not result("a", (0.0, 1.0, 1.0, 1.0)).frontal
    assert result("a", (1.0,) * 4, None).flat_max_tilt_deg is None


def test_as_dict_is_json_and_names_the_readers():
    found = report(result("a", (1.0, 1.0, 0.5, 0.0)), result("b", (0.0, 0.0, 0.0, 0.0), None))
    assert found.readers == ("a",)
    section = json.loads(json.dumps(found.as_dict()))
    assert section["decoders"]["a"]["max_tilt_deg"] == 20
    assert section["decoders"]["b"]["flat_rates"] is None
    assert "a" in found.render()


def test_advice_names_what_falls_short_of_the_print():
    lines = sentences(report(result("zxing-cpp", (1.0, 0.0, 0.0, 0.0)), result("zbar", (1.0,) * 4)))
    assert any("zxing-cpp reads the part from all sides to 0°" in line for line in lines)
    assert any("dark ring" in line for line in lines)
    assert not any("zbar" in line for line in lines)
    assert sentences(report(result("zbar", (1.0,) * 4))) == ()
    neither = report(result("quirc", (0.0,) * 4, (0.0,) * 4))
    assert sentences(neither) == ("quirc does not read the flat print of this code either",)


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    import trimesh

    folder = tmp_path_factory.mktemp("part")
    made = plates.plate(plates.modules("perfqr", version=1), 30.0, 1.0)
    trimesh.Trimesh(made.vertices, made.faces).export(folder / "part.stl")
    certificate = {"payload": "perfqr", "files": [{"path": "elsewhere/part.stl"}]}
    (folder / "design.json").write_text(json.dumps(certificate))
    return folder


def test_part_from_a_design_json_and_from_its_mesh(folder):
    by_design = scan.part(folder / "design.json", schedule=ONCE, decoders=("zbar",))
    assert by_design.readers == ("zbar",)
    assert by_design.payload == "perfqr"
    found = scan.part(folder / "part.stl", schedule=ONCE, decoders=("zxing-cpp", "zbar"))
    assert found.payload == "perfqr"  # what both agree on
    assert found.decoders["zbar"].flat_rates == (1.0,)


def test_part_from_step_is_meshed_by_the_caller(folder):
    step = folder / "part.step"
    step.write_text("")
    asked = []

    def mesh_step(path):
        asked.append(path)
        return scan.load_mesh(folder / "part.stl")

    assert scan.part(step, "perfqr", mesh_step=mesh_step, schedule=ONCE, decoders=("zbar",)).readers == (
        "zbar",
    )
    assert asked == [step]


def test_a_plate_that_stands_is_filmed_from_its_front(folder, tmp_path):
    import trimesh

    standing = trimesh.load(folder / "part.stl").apply_transform(
        trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0])
    )
    standing.export(tmp_path / "standing.stl")
    found = scan.part(tmp_path / "standing.stl", schedule=ONCE, decoders=("zbar", "zxing-cpp"))
    assert found.payload == "perfqr"
    assert found.readers == ("zxing-cpp", "zbar") or found.readers == ("zbar", "zxing-cpp")
    assert "front (-y)" in found.warnings[-1]


def test_every_body_of_a_file_is_in_the_scene_but_for_a_backing_that_a_design_names(folder, tmp_path):
    import trimesh

    plate = trimesh.load(folder / "part.stl")
    backing = trimesh.creation.box((31, 31, 1)).apply_translation([0, 0, plate.bounds[0, 2] - 0.5])
    trimesh.util.concatenate([plate, backing]).export(tmp_path / "part.stl")
    asked = {"schedule": ONCE, "decoders": ("zxing-cpp", "zbar")}
    bare = scan.part(tmp_path / "part.stl", "perfqr", **asked)
    assert "were filmed in the part's colour" in bare.warnings[-1]
    certificate = {"payload": "perfqr", "files": [{"path": "part.stl"}], "request": {"backing_mm": 1.0}}
    (tmp_path / "design.json").write_text(json.dumps(certificate))
    found = scan.part(tmp_path / "design.json", **asked)
    assert found.readers == ("zxing-cpp", "zbar")
    assert "ground's colour" in found.warnings[-1]
    alone = scan.part(folder / "part.stl", **asked)
    assert alone.warnings == ()


def test_nested_and_overlapping_bodies_are_unions(folder, tmp_path):
    """Bodies in a file may share space: what is filmed is what is printed."""
    import trimesh

    plate = trimesh.load(folder / "part.stl")
    low = plate.bounds[0]
    inside = trimesh.creation.box((2.0, 2.0, 0.4)).apply_translation(
        [low[0] + 1.5, low[1] + 1.5, low[2] + 0.5]
    )
    across = inside.copy().apply_translation([0.7, 0.0, 0.1])
    twice = trimesh.util.concatenate([plate, inside, across])
    views = [scan.View(tilt, 25.0, size_px=300) for tilt in (0.0, 30.0)]
    pictures = [
        [scan.Scene(scan.place(Triangles(mesh.vertices, mesh.faces))).photo(view) for view in views]
        for mesh in (plate, twice)
    ]
    for once, again in zip(*pictures, strict=True):
        assert np.abs(once.astype(int) - again).mean() < 0.5


def test_a_hollow_part_is_filmed_with_a_card_inside(folder, tmp_path):
    import trimesh

    lid = trimesh.load(folder / "part.stl").apply_translation([0, 0, 29.0])
    trough = trimesh.creation.box((30, 30, 29)).apply_translation([0, 0, 14.5])
    hollow = trough.difference(
        trimesh.creation.box((40, 28, 29)).apply_translation([0, 0, 15.5])
    )  # open at two sides
    trimesh.util.concatenate([hollow, lid]).export(tmp_path / "hollow.stl")
    found = scan.part(tmp_path / "hollow.stl", "perfqr", schedule=ONCE, decoders=("zxing-cpp", "zbar"))
    assert found.readers
    assert [w for w in found.warnings if "card" in w]


def test_what_is_no_part_is_refused(folder, tmp_path):
    with pytest.raises(DesignError, match="is no part"):
        scan.part(folder / "part.txt")
    with pytest.raises(DesignError, match="is no part"):
        scan.part(folder / "part.step")
    (tmp_path / "design.json").write_text("{}")
    with pytest.raises(DesignError, match="no certificate"):
        scan.part(tmp_path / "design.json")
    with pytest.raises(KernelError, match="cannot be read"):
        scan.part(tmp_path / "none.stl")


def test_a_plate_without_a_code_needs_a_text(tmp_path):
    import trimesh

    trimesh.creation.box((30, 30, 1)).export(tmp_path / "blank.stl")
    with pytest.raises(AnalysisError, match="read nothing"):
        scan.part(tmp_path / "blank.stl", schedule=ONCE, decoders=("zbar",))


def test_what_has_no_area_or_cannot_be_read_is_refused(tmp_path):
    import trimesh

    flat = trimesh.Trimesh([[0, 0, 0], [0, 0, 0], [0, 0, 0]], [[0, 1, 2]], process=False)
    flat.export(tmp_path / "flat.stl")
    with pytest.raises(KernelError, match="none with an area"):
        scan.part(tmp_path / "flat.stl", "x", schedule=ONCE, decoders=("zbar",))
    (tmp_path / "garbage.3mf").write_bytes(b"PK\x03\x04 nothing of the kind")
    with pytest.raises(KernelError, match=r"garbage\.3mf"):
        scan.part(tmp_path / "garbage.3mf", "x", schedule=ONCE, decoders=("zbar",))


def test_a_part_of_kilometres_is_filmed_with_few_sections(tmp_path):
    import trimesh

    trimesh.creation.box((1.9e7, 1.9e7, 1e6)).export(tmp_path / "huge.stl")
    with pytest.raises(AnalysisError, match="read nothing"):
        scan.part(tmp_path / "huge.stl", schedule=ONCE, decoders=("zbar",))


def test_an_open_mesh_is_no_plate(folder):
    closed = scan.load_mesh(folder / "part.stl")
    assert scan.place(closed).flat
    assert not scan.place(Triangles(closed.vertices, closed.faces[1:])).flat
