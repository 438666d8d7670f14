"""Dispatch by suffix, folders, refusals, and nothing half-written."""

from __future__ import annotations

import hashlib
import json
import stat
from importlib import import_module
from pathlib import Path

import pytest

from perfqr_cad import export
from perfqr_cad.errors import DesignError
from perfqr_cad.export import stl

LIGHT = ["part.stl", "part.svg", "part.json"]


def test_every_format_has_a_module():
    for suffix, module in export.FORMATS.items():
        assert callable(import_module(f"perfqr_cad.export.{module}").write), suffix


def test_one_file(plate, tmp_path):
    record = export.write(plate, tmp_path / "part.stl")
    data = (tmp_path / "part.stl").read_bytes()
    assert record == export.FileRecord(
        str(tmp_path / "part.stl"), "stl", len(data), hashlib.sha256(data).hexdigest()
    )
    assert [p.name for p in tmp_path.iterdir()] == ["part.stl"]


def test_suffix_is_read_without_case(plate, tmp_path):
    assert export.write(plate, tmp_path / "PART.STL").format == "stl"


@pytest.mark.parametrize("name", ["part.xyz", "part", "part."])
def test_unknown_suffix_names_the_known_ones(plate, tmp_path, name):
    with pytest.raises(DesignError, match=r"unknown format .*\.step .*\.stl") as caught:
        export.write(plate, tmp_path / name)
    assert "\n" not in str(caught.value)
    assert not list(tmp_path.iterdir())


def test_a_missing_folder_is_made(plate, tmp_path):
    export.check([tmp_path / "absent" / "part.stl"])
    assert not list(tmp_path.iterdir())
    assert export.write(plate, tmp_path / "absent" / "deeper" / "part.stl").bytes > 0


def test_a_name_is_a_file_or_a_folder(tmp_path):
    for outputs in (["a.svg", "a.svg/"], ["b/", "b/part.svg/c.dxf"]):
        with pytest.raises(DesignError, match="cannot be a file and a folder"):
            export.check([f"{tmp_path}/{output}" for output in outputs])


def test_a_name_too_long_is_refused_before_the_work(tmp_path):
    with pytest.raises(DesignError, match="name too long") as caught:
        export.check([tmp_path / ("n" * 300 + ".stl")])
    assert len(str(caught.value)) < 350
    assert not list(tmp_path.iterdir())


def test_a_file_in_the_place_of_the_folder_is_refused(plate, tmp_path):
    (tmp_path / "out").write_text("mine")
    for act in (lambda p: export.write_outputs(plate, [p]), lambda p: export.check([p])):
        with pytest.raises(DesignError, match="cannot write"):
            act(f"{tmp_path}/out/")
    assert (tmp_path / "out").read_text() == "mine"


def test_a_folder_in_the_place_of_the_file_is_refused(plate, tmp_path, light_folder):
    (tmp_path / "out" / "part.stl").mkdir(parents=True)
    with pytest.raises(DesignError, match="is a folder"):
        export.write_outputs(plate, [f"{tmp_path / 'out'}/"])
    assert [p.name for p in (tmp_path / "out").iterdir()] == ["part.stl"]


@pytest.mark.parametrize("folder", ["/proc", "/proc/absent"])
def test_a_folder_that_takes_no_files_is_refused(plate, folder):
    if not Path("/proc/self").exists():
        pytest.skip("no /proc on this system")
    with pytest.raises(DesignError, match="cannot write"):
        export.check([f"{folder}/"])
    with pytest.raises(DesignError, match="cannot write"):
        export.write_outputs(plate, [f"{folder}/"])


def test_check_leaves_nothing(tmp_path):
    export.check([f"{tmp_path}/new/deep/", tmp_path / "part.step", tmp_path / "no_suffix"])
    assert not list(tmp_path.iterdir())


def test_check_lets_a_file_into_a_folder_that_will_be_made(tmp_path):
    export.check([f"{tmp_path}/new/", tmp_path / "new" / "extra.glb"])


@pytest.fixture
def light_folder(monkeypatch):
    """A folder gets only the formats that need no kernel."""
    monkeypatch.setattr(export, "FILES", tuple(LIGHT))


def test_failure_half_way_leaves_nothing(plate, tmp_path, light_folder, monkeypatch):
    def disk_full(design, path):
        path.write_bytes(b"half")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(stl, "write", disk_full)
    with pytest.raises(DesignError, match="no space left on device"):
        export.write_outputs(plate, [f"{tmp_path}/b/"])
    assert not list(tmp_path.iterdir())


def test_failure_keeps_the_former_file(plate, tmp_path, monkeypatch):
    (tmp_path / "part.stl").write_text("former")
    monkeypatch.setattr(stl, "write", lambda design, path: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        export.write(plate, tmp_path / "part.stl")
    assert [p.read_text() for p in tmp_path.iterdir()] == ["former"]


def test_certificate_lists_the_other_files(plate, tmp_path):
    records = export.write_outputs(plate, [tmp_path / name for name in LIGHT])
    listed = json.loads((tmp_path / "part.json").read_text())["files"]
    assert [f["path"] for f in listed] == ["part.stl", "part.svg"]
    for entry in listed:
        data = (tmp_path / entry["path"]).read_bytes()
        assert (entry["bytes"], entry["sha256"]) == (len(data), hashlib.sha256(data).hexdigest())
    assert [Path(r.path) for r in records] == [tmp_path / name for name in LIGHT]


def test_certificate_sees_files_from_its_own_folder(plate, tmp_path):
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    export.write_outputs(plate, [tmp_path / "a" / "part.stl", tmp_path / "b" / "part.json"])
    assert json.loads((tmp_path / "b" / "part.json").read_text())["files"][0]["path"] == "../a/part.stl"


def test_files_take_the_usual_permissions(plate, tmp_path):
    plain = tmp_path / "plain"
    plain.write_text("")
    export.write(plate, tmp_path / "part.svg")
    assert stat.S_IMODE((tmp_path / "part.svg").stat().st_mode) == stat.S_IMODE(plain.stat().st_mode)
