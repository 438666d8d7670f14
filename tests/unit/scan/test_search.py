"""The surrogate ranks plates as their geometry says; the search finds the thin one."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from perfqr_cad import scan
from perfqr_cad.errors import AnalysisError, DesignError
from perfqr_cad.symbol import Matrix

_spec = importlib.util.spec_from_file_location("plates", Path(__file__).with_name("plates.py"))
plates = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(plates)

TEXT, SIZE, QUIET = "perfqr", 30.0, 4


@pytest.fixture(scope="module")
def dark() -> np.ndarray:
    return plates.modules(TEXT, version=1)


def legible(dark, thickness, tilt):
    scene = scan.Scene(scan.place(plates.plate(dark, SIZE, thickness)))
    return scan.legibility(scene, Matrix(dark), SIZE / (len(dark) + 2 * QUIET), tilt)


def test_thin_plates_and_small_tilts_are_more_legible(dark):
    assert (legible(dark, 0.5, 0.0).margins >= 0).all()
    assert legible(dark, 0.5, 40.0).score > legible(dark, 2.0, 40.0).score
    assert legible(dark, 2.0, 10.0).score > legible(dark, 2.0, 50.0).score


def test_a_light_bar_breaks_the_ring(dark):
    elsewhere, barred = dark.copy(), dark.copy()
    elsewhere[0, 1] = False
    barred[-7, 1] = False
    assert legible(barred, 1.0, 0.0).ring > 0.5 > legible(dark, 1.0, 0.0).ring
    assert legible(elsewhere, 1.0, 0.0).ring == pytest.approx(legible(dark, 1.0, 0.0).ring, rel=1e-3)


def test_a_symbol_that_is_too_large_is_refused(dark):
    scene = scan.Scene(scan.place(plates.plate(dark, SIZE, 1.0)))
    with pytest.raises(AnalysisError, match="does not fit"):
        scan.legibility(scene, Matrix(dark), SIZE, 0.0)


def test_search_finds_the_better_plate_and_skips_what_cannot_be_built(dark):
    def stage(settings):
        if settings["thickness"] < 0.4:
            raise DesignError("too thin")
        return scan.Scene(scan.place(plates.plate(dark, SIZE, settings["thickness"])))

    module_mm = SIZE / (len(dark) + 2 * QUIET)
    goal = scan.Goal(Matrix(dark), module_mm, TEXT, 40.0, ("zbar", "zxing-cpp"), azimuths_deg=(25.0, 205.0))
    best, trials = scan.improve(
        stage, {"thickness": 3.0}, {"thickness": (3.0, 0.6, 0.2)}, goal, weighs_most="thickness"
    )
    assert best.settings == {"thickness": 0.6}
    first = next(t for t in trials if t.settings == {"thickness": 3.0} and t.rate is not None)
    assert (best.rate or 0) > (first.rate or 0)
    assert [t.problem for t in trials if t.settings["thickness"] == 0.2] == ["too thin"]
