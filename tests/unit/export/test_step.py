"""The kernel's own reader opens what is written; the writer itself is tested with the kernel layer."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from perfqr_cad import export
from perfqr_cad.solid import build_region, read_step
from perfqr_cad.surface import Plane

from .conftest import curved_region


@pytest.fixture(scope="module")
def design():
    region, placement = curved_region(), Plane(2.0)
    solid = build_region(region, placement, name="Ünïque part", colour=(0.8, 0.1, 0.1))
    return SimpleNamespace(solid=solid, placement=placement, pattern=SimpleNamespace(region=region))


def test_name_colour_and_volume_come_back(design, tmp_path):
    export.write(design, tmp_path / "part.step")
    [part] = read_step(tmp_path / "part.step")
    assert part.name == "Ünïque part"
    assert part.colour == pytest.approx((0.8, 0.1, 0.1), abs=1e-3)
    assert design.solid.volume_mm3 == pytest.approx(design.pattern.region.area * 2, rel=1e-9)


def test_header_names_no_folder_and_no_clock(design, tmp_path):
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        export.write(design, tmp_path / folder / "part.stp")
    text = (tmp_path / "a" / "part.stp").read_text("ascii")
    assert text == (tmp_path / "b" / "part.stp").read_text("ascii")
    assert "AP242" in text
    assert str(tmp_path) not in text
    assert ".perfqr-" not in text
