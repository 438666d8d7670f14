"""`mirror`: the upper face shows the code mirrored, and the part is read from below."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from shapely import contains_xy

from perfqr_cad import make
from perfqr_cad.errors import DesignError
from perfqr_cad.export.design_view import face
from perfqr_cad.geometry.mirror import mirrored
from perfqr_cad.pipeline.design import Design
from perfqr_cad.pipeline.targets import Sheet
from perfqr_cad.surface import Cylinder

SMALL: dict[str, Any] = {
    "text": "HELLO", "level": "L", "size_mm": 30.0, "thickness_mm": 1.0, "nozzle_mm": 0.3, "mask": 2,
}  # fmt: skip


@pytest.fixture(scope="module")
def plain() -> Design:
    return make(**SMALL, draft_deg=0.0)


@pytest.fixture(scope="module")
def turned() -> Design:
    return make(**SMALL, draft_deg=0.0, mirror=True)


def material_at(design: Design, height_mm: float) -> np.ndarray:
    """Centres (k, 2) of the triangles that lie flat at a height, mm."""
    corners = design.solid.triangles.vertices[design.solid.triangles.faces]
    return corners[(np.abs(corners[..., 2] - height_mm) < 1e-9).all(axis=1)].mean(axis=1)[:, :2]


def test_it_is_the_same_part_turned_over_and_reads_alike(plain: Design, turned: Design) -> None:
    assert turned.solid.valid
    assert turned.solid.volume_mm3 == pytest.approx(plain.solid.volume_mm3, rel=1e-12)
    assert turned.solid.triangles.volume_mm3 == pytest.approx(plain.solid.triangles.volume_mm3, rel=1e-9)
    assert np.array(turned.solid.bbox_mm) == pytest.approx(np.array(plain.solid.bbox_mm))
    assert turned.scan.readers == plain.scan.readers
    assert turned.stress.max_stress_mpa == pytest.approx(plain.stress.max_stress_mpa, rel=1e-6)


def test_the_upper_face_is_mirrored(plain: Design, turned: Design) -> None:
    top = material_at(turned, 1.0)
    assert len(top) > 100
    assert contains_xy(face(turned).polygon, top).all()
    assert not contains_xy(turned.pattern.polygon, top).all()  # which is drawn as the reader sees it
    assert contains_xy(plain.pattern.polygon, material_at(plain, 1.0)).all()


def test_files_for_cutters_show_the_upper_face(plain: Design, turned: Design, tmp_path: Path) -> None:
    for suffix in ("svg", "dxf", "scad"):
        for design, name in ((plain, "plain"), (turned, "turned")):
            design.write(tmp_path / f"{name}.{suffix}")
        assert (tmp_path / f"plain.{suffix}").read_text() != (tmp_path / f"turned.{suffix}").read_text()


def test_the_step_file_is_turned_too(turned: Design, tmp_path: Path) -> None:
    from build123d import import_step

    turned.write(tmp_path / "part.step")
    read = import_step(tmp_path / "part.step")
    assert read.volume == pytest.approx(turned.solid.volume_mm3, rel=1e-6)
    top = max(read.faces(), key=lambda found: found.center().Z)
    assert top.area == pytest.approx(face(turned).region.area, rel=1e-6)


def test_mirrored_outlines_keep_material_to_the_left(plain: Design) -> None:
    region = plain.pattern.region
    assert mirrored(region).area == pytest.approx(region.area, rel=1e-12)
    assert mirrored(region).outer.area > 0
    assert all(hole.area < 0 for hole in mirrored(region).holes)
    assert mirrored(mirrored(region)) == region


@pytest.mark.parametrize(
    ("asked", "says"),
    [
        ({"depth_mm": 0.5}, "pockets of 0.5 mm are not seen from behind"),
        ({"target": Sheet(Cylinder(40.0, 1.0))}, "read from its front"),
    ],
)
def test_what_is_read_from_its_front_alone_is_refused(asked: dict[str, Any], says: str) -> None:
    with pytest.raises(DesignError, match=says):
        make(**(SMALL | asked), mirror=True)
