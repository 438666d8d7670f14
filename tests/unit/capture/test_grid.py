"""Grids: projection, warp, registration on the function patterns, bent pages."""

from __future__ import annotations

import numpy as np
import pytest
import segno

from perfqr_cad.capture.finders import triples
from perfqr_cad.capture.grid import Grid, project
from perfqr_cad.capture.pictures.image import luminance
from perfqr_cad.capture.register import correlation, known_modules, register, workspace
from perfqr_cad.capture.sampling import levels, sample_modules, soft_log_likelihood
from perfqr_cad.capture.seeds import Seed
from perfqr_cad.capture.warp import bent
from tests import pictures


def _corners(px: float, size: int, border: int = 4) -> np.ndarray:
    """Outer corners of a code drawn at `px` a module, in pixels whose centres are integers."""
    return (np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) * size + border) * px - 0.5


def _truth(picture: pictures.Sample, version: int) -> np.ndarray:
    code = segno.make(picture.payload.decode(), version=version, error="m", micro=False, boost_error=False)
    return np.array(code.matrix, dtype=bool)


def test_corners_and_projection() -> None:
    corners = np.array([[10.0, 20], [110, 25], [105, 130], [8, 118]])
    grid = Grid.from_corners(25, corners)
    assert grid.corners == pytest.approx(corners, abs=1e-3)
    centre = np.array([[12.5, 12.5]])
    assert grid.pixels(centre) == pytest.approx(project(grid.homography, centre))


def test_a_warp_moves_points_by_modules() -> None:
    warp = np.zeros((3, 3, 2))
    warp[1, 1] = (0.5, -0.25)
    grid = Grid(20, np.diag([4.0, 4, 1]), warp)
    assert grid.pixels(np.array([[10.0, 10]])) == pytest.approx(np.array([[42.0, 39]]))
    assert grid.pixels(np.array([[0.0, 0]])) == pytest.approx(np.array([[0.0, 0]]))


def test_a_crossed_outline_has_no_module_width() -> None:
    assert Grid.from_corners(21, np.array([[0.0, 0], [10, 10], [10, 0], [0, 10]])).module_px == 0


@pytest.mark.parametrize("version", [1, 7, 25, 40])
def test_registration_undoes_a_false_start(version: int) -> None:
    sample = pictures.plain(version, version, scale=5)
    size = 17 + 4 * version
    start = _corners(5, size) + np.array([[3.0, -2], [-2, 3], [3, 3], [-3, 1]])
    grid = Grid.from_corners(size, start)
    fitted, fit = register(workspace(sample.picture, grid), grid)
    assert fit > 0.9
    assert np.abs(fitted.corners - _corners(5, size)).max() < 0.4


def test_correlation_is_negative_for_a_negative() -> None:
    sample = pictures.plain(1, 3)
    grid = Grid.from_corners(29, _corners(4, 29))
    assert correlation(workspace(sample.picture, grid), grid) > 0.9
    assert correlation(workspace(255 - sample.picture, grid), grid) < -0.9
    noise = np.random.default_rng(0).integers(0, 255, sample.picture.shape, dtype=np.uint8)
    assert abs(correlation(workspace(noise, grid), grid)) < 0.3


def test_function_patterns_cover_what_the_version_fixes() -> None:
    known, dark = known_modules(45, "all")  # version 7
    assert np.all(known[:8, :8])
    assert np.all(known[6])
    assert not known[20, 12]
    assert not dark[7, 3]


@pytest.mark.parametrize(("version", "bend"), [(7, 0.5), (10, 0.4)])
def test_a_bent_page_is_sampled_right(version: int, bend: float) -> None:
    picture = pictures.curved(pictures.plain(version, version, scale=8), bend, 900)
    grey, size = luminance(picture.picture), 17 + 4 * version
    centres = next(iter(triples(grey))).centres
    grid = Grid.from_corners(size, Seed("test", centres, (), None, True).corners(size))
    space = workspace(grey, grid)

    def wrong(shape: Grid) -> int:
        samples = sample_modules(grey, shape)
        seen = soft_log_likelihood(samples, *levels(samples)) > 0
        return int(np.count_nonzero(seen != _truth(picture, version)))

    assert wrong(bent(space, grid)) == 0
    assert wrong(grid) > 0
