"""Fig. 14 of the paper: walls of 2 mm end reading long before tilt alone does.

The paper's part is the Einstein code, a halftone of version 5, 12 cm wide and 2 mm thick; its telephone read
the part well to 20° and hardly beyond 30°, the flat print to 30° and not beyond 60°. With a drawn
stand-in and four engines instead of one telephone the same order appears: the part is lost first.
"""

from pathlib import Path

import pytest

from perfqr_cad.capture import Capture, read
from perfqr_cad.pattern import PatternSpec, build
from perfqr_cad.reproduce import stand_ins
from perfqr_cad.reproduce.exhibits import handheld, rate
from perfqr_cad.scan import FlatPrint, Look, Scene, printed
from perfqr_cad.scan.camera.preview import plate_scene

EINSTEIN = next(row for row in stand_ins.TABLE_1 if row.name == "Einstein")
VIEWS = 3


@pytest.fixture(scope="module")
def captured(tmp_path_factory) -> Capture:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(stand_ins, "SHARED", Path("nowhere"))  # the same picture everywhere
        return read(stand_ins.picture(EINSTEIN, tmp_path_factory.mktemp("art")))


@pytest.fixture(scope="module")
def part(captured) -> Scene:
    spec = PatternSpec(size_mm=EINSTEIN.size_mm, finder="panel")
    return plate_scene(build(captured.recovery.symbol, spec, captured.art), stand_ins.THICKNESS_MM)


@pytest.fixture(scope="module")
def paper(captured) -> FlatPrint:
    return printed(captured.art.dark, EINSTEIN.size_mm, scale=captured.art.scale)


def read_by_any(subject, captured, tilt_deg: float) -> float:
    views = handheld(tilt_deg, VIEWS, seed=14)
    return rate(subject, captured.recovery.payload.data, views, Look())["any"]


def test_the_part_is_read_to_20_degrees(part, captured):
    assert read_by_any(part, captured, 20.0) == 1


def test_the_part_is_lost_where_the_print_still_reads(part, paper, captured):
    assert read_by_any(part, captured, 55.0) < 0.5
    assert read_by_any(paper, captured, 50.0) == 1
