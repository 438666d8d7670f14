"""Colours, exposure and the camera's faults."""

from dataclasses import replace

import numpy as np
import pytest

from perfqr_cad.errors import AnalysisError
from perfqr_cad.scan import Look, Optics, View
from perfqr_cad.scan.camera.camera import Camera, facing_up
from perfqr_cad.scan.camera.layers import Shot
from perfqr_cad.scan.camera.photo import EXPOSURE, develop, develop_colour
from perfqr_cad.scan.colours import BACKGROUNDS, contrast, contrast_warning

CLEAN = Optics(defocus_px=0, noise=0, jpeg_quality=None)


def half(size: int = 64) -> Shot:
    """Material on the left, ground on the right, both fully lit."""
    cover = np.zeros((size, size), np.float32)
    cover[:, : size // 2] = 1
    return Shot(cover, 1 - cover, cover, np.eye(3))


def test_white_is_exposed_and_gamma_encoded():
    picture = develop(half(), Look(optics=CLEAN), front=1.0)
    assert picture[5, 5] == pytest.approx(255 * EXPOSURE ** (1 / 2.2), abs=1)
    assert picture[5, 60] == pytest.approx(255 * (EXPOSURE * 0.04 / 0.85) ** (1 / 2.2), abs=1)


def test_the_same_seed_gives_the_same_bytes():
    look = Look()
    first, again, other = (develop(half(), look, front=1.0, seed=s) for s in (1, 1, 2))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


def test_noise_has_the_asked_size():
    look = Look(optics=replace(CLEAN, noise=0.05, gamma=1.0))
    white = develop(half(256), look, front=1.0)[:, :100] / 255
    assert white.std() == pytest.approx(0.05 * np.sqrt(EXPOSURE), rel=0.15)


@pytest.mark.parametrize("fault", [{"defocus_px": 9.0}, {"motion_px": 9.0}])
def test_blur_keeps_the_light_and_softens_the_edge(fault):
    sharp = develop(half(), Look(optics=replace(CLEAN, gamma=1.0)), front=1.0).astype(float)
    soft = develop(half(), Look(optics=replace(CLEAN, gamma=1.0, **fault)), front=1.0).astype(float)
    assert soft.mean() == pytest.approx(sharp.mean(), abs=1)
    assert np.abs(np.diff(soft[30])).max() < 0.4 * np.abs(np.diff(sharp[30])).max()


def test_colour_ground_and_texture():
    look = Look(ground=BACKGROUNDS["red"], optics=CLEAN)
    right = develop_colour(half(), look, front=1.0)[5, 60]
    assert right[0] > 200
    assert right[1] == right[2] < 80
    texture = np.array([[0.0, 1.0], [1.0, 0.0]], np.float32)
    busy = develop(half(), Look(ground=(0.5,) * 3, optics=CLEAN, texture=texture, texture_mm=16.0), front=1.0)
    assert np.ptp(busy[:, 40:]) > 100
    assert np.ptp(busy[:, :30]) == 0


def test_contrast_warns_below_the_limit_and_when_reversed():
    assert contrast((0.85,) * 3, BACKGROUNDS["black"]) == pytest.approx((0.85 - 0.04) / (0.85 + 0.04))
    assert contrast_warning(0.5) == ()
    assert "darker ground" in contrast_warning(0.1)[0]
    assert "zbar" in contrast_warning(-0.6)[0]
    assert "use the inverted tone" in contrast_warning(-0.6)[0]
    assert "use the normal tone" in contrast_warning(-0.6, inverted=True)[0]
    assert "lighter ground" in contrast_warning(0.1, inverted=True)[0]


def test_camera_frames_the_target():
    camera = Camera(View(size_px=1000, fill=0.5), facing_up((1.0, 2.0, 3.0), 40.0))
    corners = camera.project(np.array([[-19.0, 22.0, 3.0], [21.0, -18.0, 3.0]]))
    assert corners == pytest.approx(np.array([[249.5, 249.5], [749.5, 749.5]]))
    tilted = Camera(View(50.0, 30.0), facing_up((1.0, 2.0, 3.0), 40.0))
    point = np.array([[4.0, -3.0, -2.0]])
    flat = tilted.homography(5.0) @ [3.0, -5.0, 1.0]
    assert tilted.project(point)[0] == pytest.approx(flat[:2] / flat[2])


def test_absurd_views_are_refused():
    with pytest.raises(AnalysisError, match="tilt 95"):
        View(95.0)
    with pytest.raises(AnalysisError, match="px"):
        View(size_px=3)
