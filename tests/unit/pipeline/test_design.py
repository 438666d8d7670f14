"""The pipeline as a Python user meets it."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from pathlib import Path

import pytest

import perfqr_cad
from perfqr_cad import DesignError, Request, make, progress
from perfqr_cad.pipeline.chain import scan_part
from perfqr_cad.pipeline.design import Design
from perfqr_cad.structure import SolidCheck


@pytest.fixture(scope="module")
def design() -> Design:
    return make(text="HELLO 123", size_mm=40, draft_deg=0)


def digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def test_the_certificate_agrees_with_the_design(design: Design) -> None:
    certificate = design.certificate()
    assert certificate["payload"] == "HELLO 123"
    symbol = certificate["symbol"]
    assert [symbol[name] for name in ("version", "level", "mask", "modules")] == [
        1,
        "M",
        design.symbol.mask,
        21,
    ]
    assert symbol["choice"]["standard_padding"] is False
    assert symbol["choice"]["corners"] < symbol["choice"]["ordinary"]["corners"]
    assert certificate["connectivity"]["components"] == 1
    assert len(certificate["connectivity"]["bridges"]) == len(design.pattern.bridges)
    assert certificate["solid"]["module_mm"] == pytest.approx(40 / 29)
    front = sum(region.area for region in design.pattern.front)
    bars = design.pattern.region.area - front
    volume = front * 1.6 + bars * design.pattern.spec.bar_height_mm
    assert certificate["solid"]["volume_mm3"] == pytest.approx(volume, rel=1e-9)
    assert 0 < certificate["structure"]["safety_factor"] < 1  # a fingertip on a ring; docs/strength.md
    assert certificate["files"] == []


def test_the_summary_names_payload_and_readers(design: Design) -> None:
    summary = design.summary()
    assert "HELLO 123" in summary
    assert all(reader in summary for reader in design.scan.readers)


def test_the_summary_tells_of_the_check_in_three_dimensions(design: Design) -> None:
    check = SolidCheck(0.012, 0.01, 0.34, 0.3, 1000, "cholmod")
    lines = replace(design, verified=check).summary().splitlines()
    assert "in 3-D    0.34 MPa, deflection 0.012 mm, the walls taken as upright" in lines
    assert not any(line.startswith("in 3-D") for line in design.summary().splitlines())


def test_the_same_request_gives_the_same_bytes(design: Design, tmp_path: Path) -> None:
    again = make(text="HELLO 123", size_mm=40, draft_deg=0)
    for name in ("part.step", "part.stl", "part.svg"):
        design.write(tmp_path / name)
        first = digest(tmp_path / name)
        again.write(tmp_path / name)
        assert digest(tmp_path / name) == first


def test_steps_are_announced() -> None:
    steps: list[str] = []
    with progress.listening(steps.append):
        make(text="HELLO 123", size_mm=40)
    assert [s for s in steps if s in ("symbol", "pattern", "structure", "solid")] == [
        "symbol",
        "pattern",
        "structure",
        "solid",
    ]


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"text": "a", "image": "b.png"}, "text and image are given together"),
        ({}, "nothing to encode"),
        ({"text": ""}, "empty"),
        ({"text": "a", "thickness_mm": float("nan")}, "finite"),
        ({"text": "a", "thickness_mm": -1.0}, "outside"),
        ({"text": "a", "version": 41}, "outside"),
    ],
)
def test_a_request_that_cannot_be_meant(settings: dict, message: str) -> None:
    with pytest.raises(DesignError, match=message):
        Request(**settings)


def test_an_unknown_setting_is_named() -> None:
    with pytest.raises(DesignError, match="no setting 'size'"):
        make(text="a", size=60)


def test_walls_that_do_not_fit_are_refused_before_the_long_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("perfqr_cad.structure.reinforce", lambda *_, **__: pytest.fail("too late"))
    with pytest.raises(DesignError, match="pockets of 2 mm leave no floor"):
        make(text="HELLO", depth_mm=2.0)


def test_the_public_face_is_complete() -> None:
    for name in perfqr_cad.__all__:
        assert getattr(perfqr_cad, name) is not None
    with pytest.raises(AttributeError):
        _ = perfqr_cad.nothing


def test_a_tag_with_everything_around_the_code() -> None:
    plain = {"text": "HELLO 123", "size_mm": 40.0}
    around = {"frame_mm": 9.0, "corner_radius_mm": 4.0, "hole_mm": ((3.0,),), "caption": "No. 7"}
    tag = make(**plain, **around, backing_mm=1.0, gap_mm=0.5)
    assert tag.solid.valid
    low, high = tag.solid.bbox_mm
    assert high[0] - low[0] == pytest.approx(58)
    assert high[2] == pytest.approx(1.6 + 0.4)  # raised letters
    (plate,) = tag.solid.extras
    assert (plate.bbox_mm[0][2], plate.bbox_mm[1][2]) == pytest.approx((-1.5, -0.5))
    assert len(tag.pattern.region.holes) == len(make(**plain).pattern.region.holes) + 4


def test_a_written_assembly_is_scanned_with_its_backing(tmp_path: Path) -> None:
    backed = make(text="HELLO 123", size_mm=40, backing_mm=1.0)
    backed.write(tmp_path / "backed.step")
    report = scan_part(tmp_path / "backed.step", "HELLO 123")
    assert {"zbar", "wechat", "opencv"} <= set(report.readers)
    assert any("behind the plate" in warning for warning in report.warnings)


def test_a_frame_is_not_for_somebody_elses_part() -> None:
    class Wall:
        behind = None

    with pytest.raises(DesignError, match="frame_mm, caption: "):
        make(text="HELLO 123", target=Wall(), frame_mm=5.0, caption="X")  # pyright: ignore[reportArgumentType]


def test_the_mask_is_the_one_that_hangs_together_unless_it_is_asked_for() -> None:
    free = make(text="HELLO 123", size_mm=40)
    areas = [make(text="HELLO 123", size_mm=40, mask=mask).pattern.changed_area_mm2 for mask in (0, 7)]
    assert free.pattern.changed_area_mm2 <= min(areas)
