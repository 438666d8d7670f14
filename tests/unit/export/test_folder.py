"""A whole folder of a real small part, twice."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from typing import Any

import pytest

from perfqr_cad import export
from perfqr_cad.export.picture import view
from perfqr_cad.export.report import page
from perfqr_cad.pattern import Pattern, PatternSpec, build
from perfqr_cad.solid import Solid
from perfqr_cad.solid import build as build_solid
from perfqr_cad.surface import Plane
from perfqr_cad.symbol import encode


@dataclass(frozen=True)
class Made:
    pattern: Pattern
    placement: Plane
    solid: Solid
    stress: None = None
    reinforcement: None = None
    scan: None = None

    def certificate(self) -> dict[str, Any]:
        return {"payload": "FOLDER", "solid": {"volume_mm3": self.solid.volume_mm3}, "files": []}


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    pattern = build(encode("FOLDER", version=1, level="M"), PatternSpec(size_mm=40.0))
    placement = Plane(1.2)
    made = Made(pattern, placement, build_solid(pattern, placement, name="folder part"))
    root = tmp_path_factory.mktemp("parts")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(view, "WIDTH_PX", 240)
        patch.setattr(view, "HEIGHT_PX", 180)
        patch.setattr(page, "PICTURE_PX", (240, 180))
        records = [export.write_outputs(made, [f"{root / name}/"]) for name in ("first", "deeper/second")]
    return root / "first", root / "deeper" / "second", records


def test_a_folder_gets_everything_and_nothing_else(folders):
    first, second, records = folders
    assert sorted(p.name for p in first.iterdir()) == sorted(export.FILES)
    assert sorted(p.name for p in second.iterdir()) == sorted(export.FILES)
    assert [record.path for record in records[0]] == [(first / name).as_posix() for name in export.FILES]


def test_two_folders_hold_the_same_bytes(folders):
    first, second, _ = folders
    for name in export.FILES:
        assert (first / name).read_bytes() == (second / name).read_bytes(), name


def test_no_file_knows_its_folder(folders):
    first, _, _ = folders
    needle = str(first.parent).encode()
    assert [name for name in export.FILES if needle in (first / name).read_bytes()] == []


def test_certificate_names_every_other_file_with_its_hash(folders):
    first, _, _ = folders
    listed = json.loads((first / "design.json").read_text("utf-8"))["files"]
    assert [entry["path"] for entry in listed] == [n for n in export.FILES if n != "design.json"]
    for entry in listed:
        data = (first / entry["path"]).read_bytes()
        assert (entry["bytes"], entry["sha256"]) == (len(data), hashlib.sha256(data).hexdigest())
