"""Many parts: one sound solid, read where a code is carved, or one line that says why not."""

from pathlib import Path
from types import SimpleNamespace
from typing import cast

import pytest
from build123d import export_step
from OCP.BRepCheck import BRepCheck_Analyzer

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry.outline import Circle, Loop, Region
from perfqr_cad.hosts.step import ImportedFace
from perfqr_cad.pattern import Pattern, PatternSpec, build
from perfqr_cad.profile import Walls
from perfqr_cad.scan import Look, Scene, View, place
from perfqr_cad.scan.decoding.decoders import CORE, load
from perfqr_cad.solid import read_step, write_step
from perfqr_cad.solid.kernel import occ
from perfqr_cad.symbol import encode

from .hosts import CASES, Case

TEXT = "A"
SOUND = [name for name, case in CASES.items() if not case.says]
REFUSED = [name for name, case in CASES.items() if case.says]
FILMED = ("closed box", "dome over its pole", "two plates in one plane")


def target(case: Case, folder: Path) -> ImportedFace:
    path = folder / "host.step"
    export_step(case.make(), path)
    return ImportedFace(path, **case.place)


def holes(size_mm: float) -> Pattern:
    """A few holes, as much of a pattern as carving needs."""
    corner = size_mm / 2
    square = Loop.from_points([(-corner, -corner), (corner, -corner), (corner, corner), (-corner, corner)])
    rounds = [Loop((Circle((x, y), 1.5, ccw=False),)) for x, y in ((0.0, 0.0), (6.0, 5.0), (-5.0, 6.0))]
    slot = Loop.from_points([(-7.0, -6.0), (-7.0, -3.0), (7.0, -3.0), (7.0, -6.0)])
    region = Region(square, (*rounds, slot))
    spec = PatternSpec(size_mm=size_mm)
    return cast(
        "Pattern", SimpleNamespace(spec=spec, size_mm=size_mm, region=region, front=(region,), recessed=())
    )


@pytest.mark.parametrize("name", SOUND)
def test_a_part_takes_the_holes(name: str, tmp_path: Path) -> None:
    case = CASES[name]
    host = target(case, tmp_path)
    part = host.solid(
        holes(case.size_mm), host.placement(case.size_mm, case.depth_mm), Walls(depth_mm=case.depth_mm)
    )
    assert part.valid
    assert part.triangles.closed
    assert BRepCheck_Analyzer(part.shape).IsValid()
    assert part.triangles.volume_mm3 == pytest.approx(part.volume_mm3, rel=2e-3)
    write_step(part, tmp_path / "part.step")
    (back,) = read_step(tmp_path / "part.step", heal=False)
    assert occ.count(back.shape, occ.FACE) == part.faces


@pytest.mark.parametrize("name", FILMED)
def test_a_code_reads(name: str, tmp_path: Path) -> None:
    case = CASES[name]
    host = target(case, tmp_path)
    spec = PatternSpec(size_mm=case.size_mm, nozzle_mm=0.2, quiet_modules=2)
    code = build(encode(TEXT, version=1, level="L"), spec)
    placement = host.placement(case.size_mm)
    part = host.solid(code, placement, Walls())
    assert not part.notes  # bars lie behind the face, seams and joints or not
    picture = Scene(place(part.triangles, placement, edge_mm=case.size_mm)).photo(
        View(fill=0.6, size_px=600), Look()
    )
    readers = [decoder for decoder in CORE if TEXT.encode() in load(decoder)(picture)]
    assert len(readers) >= 2, readers  # as the chain asks of every part


@pytest.mark.parametrize("name", REFUSED)
def test_a_part_that_does_not_take_it_says_why(name: str, tmp_path: Path) -> None:
    case = CASES[name]
    with pytest.raises(DesignError, match=case.says) as caught:
        target(case, tmp_path).placement(case.size_mm)
    assert "\n" not in str(caught.value)
