"""A few seeds of the storm, and that its judges see faults at all."""

import json
from pathlib import Path
from typing import Any

import pytest
import trimesh

from perfqr_cad.pipeline.request import SETTINGS

from .drawn import Asked, draw
from .judges import Outcome, faults, remedies
from .storm import run

SEEDS = (1, 2, 3, 5, 8)
PLATE = Asked(0, "plate", True, {"text": "A"})


@pytest.mark.parametrize("seed", SEEDS)
def test_what_comes_out_is_sound_or_one_true_line(seed: int, tmp_path: Path) -> None:
    result = run(seed, tmp_path)
    assert not result.faults, [(fault.what, fault.asked.line()) for fault in result.faults]


def test_every_setting_is_drawn(tmp_path: Path) -> None:
    drawn = {field for seed in range(400) for field in draw(seed, tmp_path).settings}
    assert drawn == {declared.field for declared in SETTINGS}


@pytest.mark.parametrize(
    ("code", "said", "seen"),
    [
        (1, "Traceback (most recent call last):\nValueError: x", "exit code 1"),
        (2, "error: one\nerror: two", "2 lines"),
        (2, "size is wrong", "1 lines"),
        (2, "", "0 lines"),
    ],
)
def test_a_refusal_that_is_none_is_a_fault(code: int, said: str, seen: str, tmp_path: Path) -> None:
    assert seen in faults(PLATE, Outcome(code, said, tmp_path))[0]


def test_what_a_refusal_leaves_is_a_fault(tmp_path: Path) -> None:
    assert not faults(PLATE, Outcome(2, "error: no", tmp_path))
    (tmp_path / ".perfqr-x").mkdir()
    assert faults(PLATE, Outcome(2, "error: no", tmp_path)) == ["a refusal leaves .perfqr-x"]


def test_the_judges_see_what_is_wrong_with_a_part(tmp_path: Path) -> None:
    box = trimesh.creation.box((10, 10, 2))
    box.faces = box.faces[1:]
    box.export(tmp_path / "part.stl")
    (tmp_path / "part.svg").write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="9mm" height="9mm" viewBox="0 0 9 9"/>'
    )
    found = " ".join(faults(PLATE, Outcome(0, "", _certified(tmp_path, kept=False))))
    for seen in ("not kept: web", "not watertight", "volume", "payload 'B'", "reads [] in the SVG"):
        assert seen in found


def test_a_certificate_with_an_infinite_figure_is_a_fault(tmp_path: Path) -> None:
    for name in ("part.stl", "part.svg"):
        (tmp_path / name).touch()
    (tmp_path / "design.json").write_text('{"loss": Infinity}')
    assert faults(PLATE, Outcome(0, "", tmp_path)) == ["certificate: Infinity is no JSON"]


@pytest.mark.parametrize(
    ("message", "changes"),
    [
        ("weak: use --bars 2 --thickness 3, which was tried", [{"bars": 2, "thickness_mm": 3.0}]),
        ("unread (--accept-unread writes it): tried without success: --size 60", [{"accept_unread": True}]),
        ("a caption needs a frame to stand on: give --frame 8, say", [{"frame_mm": 8.0}]),
        ("unread: use no --depth, for through-holes, which was tried", [{"depth_mm": None}]),
        ("take a larger --size or a finer nozzle", []),
    ],
)
def test_remedies_are_read_from_a_refusal(message: str, changes: list[dict[str, Any]]) -> None:
    assert remedies(message) == changes


def _certified(folder: Path, kept: bool) -> Path:
    asked = {"svg": "filled", "accept_unread": False, "tone": "normal", "mirror": False}
    certificate = {
        "payload": "B",
        "promises": [{"name": "web", "kept": kept}],
        "solid": {"solids": 1, "volume_mm3": 500.0},
        "request": asked,
    }
    (folder / "design.json").write_text(json.dumps(certificate))
    return folder
