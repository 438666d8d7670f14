"""A few seeds of the storm, and that its judges see faults at all."""

import json
from pathlib import Path
from typing import Any

import pytest
import trimesh

from perfqr_cad.pipeline.request import SETTINGS

from . import storm
from .drawn import Asked, draw
from .judges import Outcome, faults, remedies
from .storm import Fault, run, shortest

SEEDS = (1, 2, 3, 4, 5, 7, 9, 10, 11, 17)
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
    seen = (
        "not kept: web",
        "not watertight",
        "volume",
        "payload 'B'",
        "area",
        "in the front face",
        "in the SVG",
    )
    assert not [what for what in seen if what not in found]


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
        ("a caption needs a frame to stand on: use --frame 8 or another width", [{"frame_mm": 8.0}]),
        ("unread: use no --depth, for through-holes, which was tried", [{"depth_mm": None}]),
        ("take a larger --size or a finer nozzle", []),
    ],
)
def test_remedies_are_read_from_a_refusal(message: str, changes: list[dict[str, Any]]) -> None:
    assert remedies(message) == changes


def test_a_remedy_that_does_not_help_is_a_fault(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    refusal = Outcome(2, "error: too small: use --size 40", tmp_path)
    monkeypatch.setattr(storm, "send", lambda asked, folder: refusal)
    result = run(2, tmp_path)
    assert "{'size_mm': 40.0}" in result.faults[0].what
    assert "does not help" in result.faults[0].what


def test_a_remedy_that_helps_is_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def send(asked: Asked, folder: Path) -> Outcome:
        given = float(asked.settings.get("frame_mm", 0.0))
        return Outcome(2, f"error: too narrow: use --frame {min(given + 1, 3):g}", tmp_path)

    monkeypatch.setattr(storm, "send", send)
    monkeypatch.setattr(storm, "draw", lambda seed, pictures: PLATE)
    assert "does not help" in run(0, tmp_path).faults[0].what  # the third time it says what it said before
    monkeypatch.setattr(storm, "faults", lambda asked, outcome: [])
    made = Outcome(0, "", tmp_path)
    monkeypatch.setattr(
        storm, "send", lambda asked, folder: made if "frame_mm" in asked.settings else send(asked, folder)
    )
    assert not run(0, tmp_path).faults


def test_a_reproducer_holds_only_what_is_needed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def send(asked: Asked, folder: Path) -> Outcome:
        wrong = asked.settings.get("mask") == 3
        return Outcome(1, "ValueError: mask 3", tmp_path) if wrong else Outcome(2, "error: x", tmp_path)

    monkeypatch.setattr(storm, "send", send)
    asked = Asked(4, "plate", True, {"text": "A", "mask": 3, "size_mm": 40.0, "mirror": True})
    found = shortest(Fault("exit code 1: ValueError: mask 3", asked), tmp_path)
    assert found.asked.settings == {"mask": 3}
    assert found.asked.line() == "python -m perfqr_cad make -t plate --mask=3 -o part.stl -o part.svg"


def _certified(folder: Path, kept: bool) -> Path:
    asked = {"svg": "filled", "finder": "panel", "tone": "normal", "mirror": False, "thickness_mm": 1.0}
    certificate = {
        "payload": "B",
        "promises": [{"name": "web", "kept": kept}],
        "solid": {"solids": 1, "volume_mm3": 500.0},
        "connectivity": {"area_mm2": 50.0},
        "scan": {"decoders": {"zxing-cpp": {"frontal": True}}},
        "request": asked,
    }
    (folder / "design.json").write_text(json.dumps(certificate))
    return folder
