"""A plate drawn from its pattern shows what its solid shows."""

import numpy as np
import pytest

from perfqr_cad import scan
from perfqr_cad.errors import DesignError
from perfqr_cad.pattern import Pattern, PatternSpec, build
from perfqr_cad.profile import Walls
from perfqr_cad.scan import Look, Optics, View
from perfqr_cad.solid import build as build_solid
from perfqr_cad.surface import Plane
from perfqr_cad.symbol import encode

CLEAN = Look(optics=Optics(defocus_px=0, noise=0, jpeg_quality=None))
VIEW = View(30.0, 25.0, size_px=500)


@pytest.fixture(scope="module")
def pattern() -> Pattern:
    return build(encode("perfqr", version=1), PatternSpec(size_mm=40.0, finder="recessed"))


@pytest.mark.parametrize(("draft", "lip"), [(0.0, 0.0), (10.0, 0.4)])
def test_a_drawn_plate_looks_like_its_solid(pattern, draft, lip):
    placement = Plane(1.6)
    solid = build_solid(pattern, placement, Walls(draft_deg=draft, lip_mm=lip))
    filmed = scan.Scene(scan.place(solid.triangles, placement, edge_mm=pattern.size_mm)).photo(VIEW, CLEAN)
    drawn = scan.plate_scene(pattern, 1.6, draft_deg=draft, lip_mm=lip).photo(VIEW, CLEAN)
    upright = scan.plate_scene(pattern, 1.6).photo(VIEW, CLEAN)
    off = np.abs(drawn.astype(float) - filmed).mean()
    assert off < (0.3 if draft == 0 else 1.0)
    if draft > 0:
        assert off < 0.4 * np.abs(upright.astype(float) - filmed).mean()


def test_the_banks_of_pinched_slots_do_not_flare_and_others_do(pattern):
    solid = build_solid(pattern, Plane(1.6), Walls(draft_deg=15.0, lip_mm=0.2))
    assert solid.notes == ()
    behind = solid.triangles.vertices[np.abs(solid.triangles.vertices[:, 2]) < 1e-9, :2]
    assert {bar.pinched for bar in pattern.recessed} == {True, False}
    for bar in pattern.recessed:
        for corner in bar.corners():
            off = np.hypot(*(behind - corner).T).min()
            assert off < 1e-6 if bar.pinched else off > 0.05


@pytest.mark.parametrize("draft", [0.0, 15.0])
def test_the_bar_of_the_traced_ring_looks_dark(pattern, draft):
    flush = build(pattern.symbol, PatternSpec(size_mm=40.0, finder="panel"))

    def ring(which: Pattern, tilt: float) -> float:
        scene = scan.plate_scene(which, 1.6, draft_deg=draft, lip_mm=0.2)
        return scan.legibility(scene, which.symbol.matrix, which.module_mm, tilt).ring

    for tilt in (10.0, 30.0):
        assert ring(flush, tilt) > 0.8
        assert ring(pattern, tilt) < 0.5


def test_a_recessed_bar_lies_behind_the_front(pattern):
    sections = scan.plate_scene(pattern, 1.6).sections
    assert sections is not None
    front, back = sections.material[0], sections.material[-1]
    bars = sum(bar.width_mm * bar.height_mm for bar in pattern.recessed)
    assert bars > 0
    assert back.sum(dtype=float) > front.sum(dtype=float)
    assert np.all(back >= front)


def test_a_lip_of_the_whole_thickness_cannot_flare(pattern):
    with pytest.raises(DesignError, match="shorten it"):
        scan.plate_scene(pattern, 0.4, draft_deg=10.0, lip_mm=0.4)
