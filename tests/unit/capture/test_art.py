"""The grid of the art is found by itself, at any resolution."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
import segno

from perfqr_cad.capture import Art, read
from perfqr_cad.capture.register import known_modules
from tests import pictures


def _halftone(scale: int, seed: int) -> np.ndarray:
    """Submodules at random, but for the middle ones and the function patterns, which belong to the code."""
    code = np.array(segno.make(pictures.text(seed, 16), version=5, error="h", micro=False).matrix, dtype=bool)
    art = np.random.default_rng(seed).random((len(code) * scale,) * 2) < 0.5
    plain = np.kron(code, np.ones((scale, scale), bool))
    middle = np.zeros((scale, scale), bool)
    inner = slice((scale - 1) // 2, scale // 2 + 1)
    middle[inner, inner] = True
    keep = np.tile(middle, code.shape)
    keep |= np.kron(known_modules(len(code), "all")[0], np.ones((scale, scale), bool))
    return np.where(keep, plain, art)


def _picture(dark: np.ndarray, px: int, border: int) -> np.ndarray:
    return np.where(np.kron(np.pad(dark, border), np.ones((px, px))) > 0, 0, 255).astype(np.uint8)


@pytest.mark.parametrize("scale", [3, 4, 5])
def test_submodules_are_counted_and_kept(scale: int) -> None:
    dark = _halftone(scale, scale)
    art = read(_picture(dark, 4, 4 * scale)).art
    assert (art.kind, art.scale) == ("halftone", scale)
    assert np.array_equal(art.dark, dark)


@pytest.mark.parametrize("module_px", [3.0, 7.0, 12.4, 25.0])
def test_resolution_does_not_change_the_art(module_px: float) -> None:
    sample = pictures.halftone(5, 3)
    side = round(sample.picture.shape[0] * module_px / 3)
    kind = cv2.INTER_NEAREST if module_px == 3.0 else cv2.INTER_LINEAR
    art = read(cv2.resize(sample.picture, (side, side), interpolation=kind)).art
    truth = sample.picture[12:-12, 12:-12, 0] < 128
    assert (art.kind, art.scale, art.modules) == ("halftone", 3, truth.shape[0] // 3)
    assert np.array_equal(art.dark, truth)


@pytest.mark.parametrize("scale", [1, 2, 3, 8])
def test_plain_codes_are_plain(scale: int) -> None:
    found = read(pictures.plain(scale, 4, scale=scale).picture)
    assert (found.art.kind, found.art.scale) == ("plain", 1)
    assert np.array_equal(found.art.dark, found.matrix.dark)


@pytest.mark.parametrize("seed", [0, 1, 3])
def test_rounded_modules_are_freeform(seed: int) -> None:
    sample = pictures.styled(seed)
    found = read(sample.picture)
    assert found.art.kind == "freeform"
    assert found.art.dark.shape == (found.matrix.size * found.art.scale,) * 2


def test_a_blurred_plain_photograph_is_plain() -> None:
    sample = pictures.degraded(pictures.tilted(pictures.plain(1, 3, scale=8), 3, 20.0, 500), 1, 1.0, 5.0)
    assert read(sample.picture).art.kind == "plain"


def test_rectified_at_a_chosen_resolution() -> None:
    sample = pictures.plain(2, 3, scale=5)
    found = read(pictures.tilted(sample, 2, 25.0).picture, rectified_module_px=7)
    assert found.rectified.shape == (29 * 7, 29 * 7)
    shade = found.rectified.reshape(29, 7, 29, 7).mean(axis=(1, 3))
    assert np.array_equal(shade < (shade.max() + shade.min()) / 2, found.recovery.symbol.matrix.dark)


def test_art_is_closed_for_writing() -> None:
    art = Art("plain", 1, np.zeros((21, 21), bool))
    with pytest.raises(ValueError, match="read-only"):
        art.dark[0, 0] = True
