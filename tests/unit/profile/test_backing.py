"""A plate behind the part: it follows the wall, and is written as a body of its own."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from perfqr_cad.errors import DesignError
from perfqr_cad.pattern import Pattern, PatternSpec, Surround
from perfqr_cad.pattern import build as build_pattern
from perfqr_cad.profile import Backing
from perfqr_cad.solid import back, build, read_step, write_step
from perfqr_cad.surface import Cone, Cylinder, HeightField, Placement, Plane, Sphere
from perfqr_cad.symbol import encode

PLACEMENTS: dict[str, Placement] = {
    "plane": Plane(2.0),
    "cylinder": Cylinder(40.0, 2.0),
    "sphere": Sphere(60.0, 2.0),
    "cone": Cone(60.0, 8.0, 2.0),
    "field": HeightField.of(lambda x, y: -(x * x + y * y) / 300, 30.0, 2.0),
}


@pytest.fixture(scope="module")
def pattern() -> Pattern:
    return build_pattern(encode("HELLO", version=1), PatternSpec(surround=Surround(5.0, corner_hole_mm=2.0)))


@pytest.mark.parametrize("name", PLACEMENTS)
@pytest.mark.parametrize("gap", [0.0, 1.5])
def test_it_follows_the_wall(pattern: Pattern, name: str, gap: float) -> None:
    plate = back(pattern, PLACEMENTS[name], Backing(1.0, gap))
    assert plate.problems == ()
    assert plate.triangles.closed
    assert plate.faces == 2 + 4 + (4 if name == "plane" else 8)
    if name == "plane":
        (low, high) = plate.bbox_mm
        assert (low[2], high[2]) == pytest.approx((-gap - 1.0, -gap))
        area = pattern.extent_mm**2 - 4 * 3.141592653589793
        assert plate.volume_mm3 == pytest.approx(area * 1.0, rel=1e-9)


def test_step_holds_both_bodies(pattern: Pattern, tmp_path: Path) -> None:
    wall = PLACEMENTS["plane"]
    solid = replace(build(pattern, wall, name="part"), extras=(back(pattern, wall, Backing()),))
    write_step(solid, tmp_path / "two.step")
    parts = {p.name: p for p in read_step(tmp_path / "two.step")}
    assert set(parts) == {"part", "backing"}
    assert parts["backing"].colour == pytest.approx(Backing().colour, abs=0.01)


def test_a_wall_too_tight_for_it_is_refused(pattern: Pattern) -> None:
    with pytest.raises(DesignError, match="meets itself"):
        back(pattern, Cylinder(40.0, 2.0), Backing(10.0, 30.0))


@pytest.mark.parametrize("wrong", [{"thickness_mm": 0.0}, {"gap_mm": -1.0}])
def test_absurd_backings_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(DesignError):
        replace(Backing(), **wrong)
