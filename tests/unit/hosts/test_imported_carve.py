"""Codes in walls of foreign solids: sound, of the right volume, the right way round, or refused with a
reason.
"""

import math
from pathlib import Path

import numpy as np
import pytest
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeCylinder
from OCP.gp import gp_Pnt

from perfqr_cad import make
from perfqr_cad.errors import DesignError
from perfqr_cad.geometry.outline import Region
from perfqr_cad.hosts.step import ImportedFace
from perfqr_cad.hosts.step.prism import prism
from perfqr_cad.profile.walls import Walls
from perfqr_cad.scan.decoding.decoders import CORE, load
from perfqr_cad.solid.kernel import booleans as kernel
from perfqr_cad.solid.kernel import occ

from .imports import (
    SHARED,
    SKETCH,
    STRAIGHT,
    Sketch,
    ball,
    code,
    difference,
    few_holes,
    holes_area,
    seen,
    tray,
    tube,
    write_step,
)

FRONT = {"point": (0.0, -100.0, 15.0), "direction": (0.0, 1.0, 0.0)}


def carved(target: ImportedFace, walls: Walls = STRAIGHT):
    placement = target.placement(SKETCH.size_mm, walls.depth_mm)
    return target.solid(SKETCH, placement, walls), placement


def lost(target: ImportedFace, solid) -> float:
    return occ.volume(target.host.shape) - solid.volume_mm3


@pytest.mark.parametrize("wrap", [False, True])
@pytest.mark.parametrize(
    ("shape", "place"),
    [
        (tray(), FRONT),
        (tube(), {"point": (0.0, -100.0, 25.0), "direction": (0.0, 1.0, 0.0)}),
        (ball(), {"point": (0.0, -30.0, 0.0)}),
    ],
    ids=["tray", "tube", "ball"],
)
def test_holes_go_through_the_wall(shape, place, wrap: bool) -> None:
    target = ImportedFace.of(shape, wrap=wrap, **place)
    solid, placement = carved(target)
    assert solid.valid
    assert solid.solids == 1
    assert occ.count(solid.shape, occ.FACE) == len(target.host.faces) + 4 + 4 + 2
    assert lost(target, solid) == pytest.approx(holes_area(few_holes()) * 2.0, rel=0.08)
    assert solid.volume_mm3 == pytest.approx(solid.expected_volume_mm3, rel=1e-6)
    assert solid.triangles.closed
    assert solid.triangles.volume_mm3 == pytest.approx(solid.volume_mm3, rel=2e-3)
    assert placement.thickness_mm == pytest.approx(2.0, rel=0.05)


def test_a_flat_wall_is_exact() -> None:
    target = ImportedFace.of(tray(), **FRONT)
    solid, _ = carved(target)
    assert lost(target, solid) == pytest.approx(holes_area(few_holes()) * 2.0, rel=1e-9)


@pytest.mark.parametrize("which", [0, 1], ids=["square", "slot"])
def test_a_punch_agrees_with_the_boolean(which: int) -> None:
    # Not the round hole: the kernel's own cut of a cylinder by a cylinder is 0.3 % off.
    target = ImportedFace.of(tube(), point=(0.0, -30.0, 25.0))
    region = Region(few_holes().outer, few_holes().holes[which : which + 1])
    placement = target.placement(20.0)
    punched = target.solid(Sketch(region, 20.0), placement, STRAIGHT)
    brute = kernel.cut(target.host.shape, [prism(target.host.body, region.holes[0], placement, None)])
    by_boolean = kernel.volume_lost(target.host.shape, brute)
    assert kernel.volume_lost(target.host.shape, punched.shape) == pytest.approx(by_boolean, rel=1e-5)


def test_a_code_over_a_seam_is_cut_there_and_punched_elsewhere() -> None:
    target = ImportedFace.of(tube(), point=(100.0, 1.0, 25.0), direction=(-1.0, 0.0, 0.0))
    solid, _ = carved(target)
    assert solid.valid
    assert solid.volume_mm3 == pytest.approx(solid.expected_volume_mm3, rel=1e-6)


def test_draft_widens_the_back() -> None:
    target = ImportedFace.of(tray(), **FRONT)
    straight, placement = carved(target)
    flared = target.solid(SKETCH, placement, Walls(draft_deg=10.0, lip_mm=0.4))
    assert flared.volume_mm3 < straight.volume_mm3 - 1
    assert flared.valid


def test_pockets_in_a_block() -> None:
    block = BRepPrimAPI_MakeBox(gp_Pnt(-20, -20, 0), 40, 40, 30).Shape()
    with pytest.raises(DesignError, match=r"30 mm of material.*set depth"):
        ImportedFace.of(block, point=(0, 0, 30)).placement(20)
    target = ImportedFace.of(block, point=(0, 0, 30))
    solid, _ = carved(target, Walls(depth_mm=0.8))
    assert lost(target, solid) == pytest.approx(holes_area(few_holes()) * 0.8, rel=1e-9)
    curved = ImportedFace.of(tube(wall=20.0), point=(0, -30, 25))
    pocketed, _ = carved(curved, Walls(depth_mm=0.8))
    assert lost(curved, pocketed) == pytest.approx(holes_area(few_holes()) * 0.8, rel=1e-4)
    with pytest.raises(DesignError, match="break through the wall"):
        ImportedFace.of(tray(), **FRONT).placement(20, 3.0)


def test_the_request_alone_says_how_deep_pockets_are() -> None:
    block = BRepPrimAPI_MakeBox(gp_Pnt(-20, -20, -10), 40, 40, 20).Shape()
    settings = {"text": "A", "level": "L", "size_mm": 24.0, "nozzle_mm": 0.3, "quiet_modules": 2}
    target = ImportedFace.of(block, point=(0, 0, 10))
    design = make(**settings, target=target, depth_mm=3.0)
    open_mm2 = 24.0**2 - sum(piece.area for piece in design.pattern.front)
    assert lost(target, design.solid) == pytest.approx(open_mm2 * 3.0, rel=1e-9)
    with pytest.raises(DesignError, match="set depth"):
        make(**settings, target=target)


def test_the_largest_face_that_fits_is_found() -> None:
    placement = ImportedFace.of(tray()).placement(40)
    assert placement.normal((0, 0))[0] == pytest.approx([0, 0, -1], abs=1e-9)
    with pytest.raises(DesignError, match=r"takes a code of 55 mm.*use --size 4"):
        ImportedFace.of(tray()).placement(55)


@pytest.mark.parametrize("edge_mm", [50, 300, 1000])
def test_a_code_lies_in_the_middle_of_a_square(edge_mm: int) -> None:
    plate = BRepPrimAPI_MakeBox(gp_Pnt(0, 0, 0), edge_mm, edge_mm, 2).Shape()
    for face in (None, 6):
        at = ImportedFace.of(plate, face=face).placement(44).point(np.zeros((1, 2)))[0]
        assert at[:2] == pytest.approx([edge_mm / 2, edge_mm / 2], abs=1e-6 * edge_mm)


def test_a_wrapped_code_is_refused_by_its_own_size() -> None:
    pipe = difference(BRepPrimAPI_MakeCylinder(29, 80).Shape(), BRepPrimAPI_MakeCylinder(28.4, 80).Shape())
    target = ImportedFace.of(pipe, point=(0, -29, 40), wrap=True)
    with pytest.raises(DesignError, match=r"a code of 64 mm does not work .*: use --size 5\d"):
        target.placement(64)
    with pytest.raises(DesignError, match=r"at most 50\.\d+ mm"):
        target.placement(55)
    target.placement(50)


def test_refusals_name_what_works() -> None:
    with pytest.raises(DesignError, match=r"hangs over.*nearest place.*use --size"):
        ImportedFace.of(tray(), point=(20.0, -25.0, 15.0)).placement(24)
    ribbed = difference(tray(2.0), BRepPrimAPI_MakeBox(gp_Pnt(-8, -25, 5), 4, 1.0, 20).Shape())
    with pytest.raises(DesignError, match="step, opening or rib"):
        ImportedFace.of(ribbed, **FRONT).placement(20)
    wedge = difference(tray(6.0), BRepPrimAPI_MakeBox(gp_Pnt(-26, -21, 6), 28, 4, 30).Shape())
    with pytest.raises(DesignError, match=r"uneven|lie behind"):
        ImportedFace.of(wedge, **FRONT).placement(26)
    with pytest.raises(DesignError, match="faces 1 to 11"):
        ImportedFace.of(tray(), face=12).placement(20)
    with pytest.raises(DesignError, match="meets no outer face"):
        ImportedFace.of(tray(), point=(0, -100, 15), direction=(0, -1, 0)).placement(20)
    with pytest.raises(DesignError, match=r"turns|bent"):
        ImportedFace.of(tube(14.0), point=(0, -14, 25)).placement(25)


def test_the_code_reads_from_outside_and_is_not_mirrored(tmp_path: Path) -> None:
    pattern = code("PERFQR", 22.0)
    path = write_step(tube(30.0, 0.8), tmp_path / "tube.step")
    for wrap in (False, True):
        target = ImportedFace(path, point=(0.0, -30.0, 25.0), wrap=wrap)
        placement = target.placement(22.0)
        image = seen(target.solid(pattern, placement, STRAIGHT).triangles, placement, 22.0)
        assert any(b"PERFQR" in load(decoder)(image) for decoder in CORE)
        top_left = placement.point([(-5.0, 5.0)])[0] - placement.point([(0.0, 0.0)])[0]
        e1, e2, n = placement.frame_at_centre.axes
        assert top_left @ e1 < 0 < top_left @ e2
        assert np.linalg.det([e1, e2, n]) == pytest.approx(1)


def test_a_wrap_on_a_cylinder_keeps_lengths() -> None:
    placement = ImportedFace.of(tube(), point=(0, -30, 25), wrap=True).placement(40)
    found = placement.distortion(40)
    assert found.area_worst < 1e-5
    assert found.shear_worst_deg < 1e-3
    end = placement.point([(15.0, 0.0)])[0]
    assert math.atan2(end[0], -end[1]) == pytest.approx(15.0 / 30.0, abs=1e-6)


@pytest.mark.skipif(not SHARED.is_dir(), reason="needs the shared parts")
@pytest.mark.parametrize(
    ("name", "point", "depth_mm"),
    [
        ("caxif_s1-c5_HEAD_FRONT.stp", (330.0, 0.0, 0.0), None),
        ("caxif_s1-c5_MAINBODY_FRONT.stp", None, None),
        ("myfreecad_vase.step", None, None),
        ("nist_ctc_01_asme1_rd.stp", None, 1.0),
        ("trimesh_featuretype.STEP", None, 1.0),
    ],
)
def test_shared_parts(name: str, point: tuple | None, depth_mm: float | None) -> None:
    target = ImportedFace(SHARED / "solids" / name, point=point)
    solid = target.solid(SKETCH, target.placement(20.0, depth_mm), Walls(depth_mm=depth_mm))
    assert solid.valid
    assert solid.triangles.closed
    assert solid.volume_mm3 == pytest.approx(solid.expected_volume_mm3, rel=1e-6)
