"""Reading codes whose truth is known from their making."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
import segno

from perfqr_cad.capture import read, recognition, symbologies
from perfqr_cad.capture.engines import MODEL_1
from perfqr_cad.capture.recognition import LEAST_AGREEMENT
from perfqr_cad.capture.seeds import Seed
from perfqr_cad.errors import CaptureError, SymbolError
from perfqr_cad.symbol import Matrix, encode, layout
from tests import pictures


def _matrix(sample: pictures.Sample, version: int, level: str = "m") -> np.ndarray:
    code = segno.make(sample.payload.decode(), version=version, error=level, micro=False, boost_error=False)
    return np.array(code.matrix, dtype=bool)


@pytest.mark.parametrize("sampling", ["soft", "gaussian"])
@pytest.mark.parametrize("version", [1, 2, 6, 7, 14, 25, 40])
def test_versions(version: int, sampling: recognition.Sampling) -> None:
    sample = pictures.plain(version, version, scale=3)
    found = read(sample.picture, sampling=sampling)
    assert found.recovery.payload.data == sample.payload
    assert np.array_equal(found.matrix.dark, _matrix(sample, version))
    assert not any(found.recovery.errors)


@pytest.mark.parametrize(
    "change",
    [
        pictures.inverted,
        pictures.mirrored,
        lambda sample: pictures.inverted(pictures.mirrored(sample)),
        lambda sample: replace(sample, picture=np.rot90(sample.picture).copy()),
        lambda sample: pictures.tilted(sample, 4, 45.0),
        lambda sample: pictures.degraded(sample, 1, 1.2, 15.0),
        lambda sample: pictures.curved(sample, 0.4),
    ],
    ids=["inverted", "mirrored", "both", "turned", "tilted", "blurred", "curved"],
)
def test_what_happens_to_pictures(change) -> None:
    sample = change(pictures.plain(3, 6, scale=8))
    found = read(sample.picture)
    assert found.recovery.payload.data == sample.payload
    assert np.array_equal(found.recovery.symbol.matrix.dark, _matrix(sample, 6))


def test_inverted_and_mirrored_are_reported() -> None:
    sample = pictures.plain(3, 4)
    assert [read(change).inverted for change in (sample.picture, 255 - sample.picture)] == [False, True]
    flipped = np.ascontiguousarray(sample.picture[:, ::-1])
    assert [read(change).mirrored for change in (sample.picture, flipped)] == [False, True]


def test_one_pixel_a_module_without_quiet_zone() -> None:
    sample = pictures.plain(5, 3, scale=1, border=4)
    assert read(sample.picture).recovery.payload.data == sample.payload
    tight = pictures.plain(5, 3, scale=4, border=0)
    assert read(tight.picture).recovery.payload.data == tight.payload


def test_the_homography_maps_modules_to_pixels() -> None:
    found = read(pictures.plain(5, 3, scale=10).picture)
    corner = found.homography @ [0, 0, 1]
    assert corner[:2] / corner[2] == pytest.approx([39.5, 39.5], abs=0.5)
    assert found.confidence.min() > 0.99


def test_colours_of_one_luminance_are_told_apart() -> None:
    """Red and blue that a grey camera cannot tell apart."""
    sample = pictures.plain(8, 4, "H", scale=8)
    dark = sample.picture == 0
    red, blue = np.array([200, 40, 0]), np.array([0, 60, 200])
    luma = np.array([0.299, 0.587, 0.114])
    blue = blue + (luma @ red - luma @ blue)
    picture = np.where(dark[..., None], red, np.clip(blue, 0, 255)).astype(np.uint8)
    grey = cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)
    assert abs(float(grey[dark].mean()) - float(grey[~dark].mean())) < 8
    assert read(picture).recovery.payload.data == sample.payload


def _damaged(wrong: int) -> np.ndarray:
    """A version 5-Q symbol with `wrong` inverted codewords in the first block."""
    symbol = encode("damage is counted by block", version=5, level="Q")
    places = layout(5, "Q")
    dark = symbol.matrix.dark.copy()
    for codeword in places.codewords_of_block(0)[::-1][:wrong]:
        rows, columns = places.modules[codeword].T
        dark[rows, columns] ^= True
    return np.where(np.kron(np.pad(dark, 4), np.ones((6, 6))) > 0, 0, 255).astype(np.uint8)


def test_errors_are_counted_by_block() -> None:
    found = read(_damaged(9))
    assert found.recovery.errors == (9, 0, 0, 0)
    assert found.recovery.capacity == (9, 9, 9, 9)


def test_damage_beyond_capacity_says_how_much_a_block_can_bear() -> None:
    with pytest.raises(CaptureError, match=r"cannot be read.*1 of 4 blocks.*can bear 9"):
        read(_damaged(14))


def test_greyed_codewords_are_erased() -> None:
    """Twelve codewords of a block, three beyond its capacity, painted in the grey between dark and light."""
    places = layout(5, "Q")
    picture = _damaged(0)
    for codeword in places.codewords_of_block(0)[:12]:
        for row, column in places.modules[codeword]:
            at = np.s_[(row + 4) * 6 : (row + 5) * 6, (column + 4) * 6 : (column + 5) * 6]
            picture[at] = 122 if picture[at][0, 0] else 132
    found = read(picture)
    assert found.recovery.payload.text == "damage is counted by block"
    assert found.recovery.errors[0] == 12
    assert found.recovery.erasures[0] > 0


@pytest.mark.parametrize("kind", ["noise", "flat", "photo", "stripes"])
def test_a_picture_without_a_code_is_an_error(kind: str) -> None:
    rng = np.random.default_rng(1)
    picture = {
        "noise": rng.integers(0, 255, (200, 200), dtype=np.uint8),
        "flat": np.full((300, 300), 128, np.uint8),
        "photo": np.array(pictures.photo(3)),
        "stripes": np.tile(np.repeat(np.array([0, 255], np.uint8), 6), (200, 20)),
    }[kind]
    with pytest.raises(CaptureError, match=r"no QR code found in the picture \(\d+ × \d+ pixels\)"):
        read(picture)


def test_a_symbol_that_contradicts_the_picture_is_refused() -> None:
    """All payload bits of the best fit drawn the other way round leave nothing to trust."""
    symbol = encode("x", version=1, level="H")
    likely = np.where(symbol.matrix.dark, 5.0, -5.0)
    place = Seed("test", np.zeros((4, 2)), (21,), None, True)
    assert recognition._trusted(likely, place).payload.text == "x"
    noise = np.random.default_rng(2).normal(0, 1, likely.shape)
    with pytest.raises(SymbolError):
        recognition._trusted(noise, place)
    assert 0.5 < LEAST_AGREEMENT < 0.7


def test_an_erased_reading_must_agree_with_the_decoder() -> None:
    symbol = encode("trust me not", version=2, level="L")
    places = layout(2, "L")
    likely = np.where(symbol.matrix.dark, 5.0, -5.0)
    rows, columns = places.modules[:6].reshape(-1, 2).T
    likely[rows, columns] *= -0.01
    seed = Seed("other", np.zeros((4, 2)), (25,), b"trust me not", True)
    assert any(recognition._trusted(likely, seed).erasures)
    with pytest.raises(SymbolError, match="otherwise than by other"):
        recognition._trusted(likely, replace(seed, payload=b"something else"))


def test_captures_are_closed_for_writing() -> None:
    found = read(pictures.plain(5, 3).picture)
    for array in (found.log_likelihood, found.rectified, found.homography, found.warp, found.confidence):
        assert not array.flags.writeable
    assert found.matrix == Matrix.from_array(found.log_likelihood > 0)


def test_a_page_bent_at_the_far_corner_is_read() -> None:
    """Its function patterns fit a flat grid well; the modules by the corner without a finder do not."""
    flat = np.kron(np.pad(encode("H15-03-34", level="L", version=1).matrix.dark, 4), np.ones((12, 12)))
    y, x = np.mgrid[: flat.shape[0], : flat.shape[1]].astype(np.float32)
    pulled = 14 * (np.clip((x - 48) / 252, 0, 1) * np.clip((y - 48) / 252, 0, 1)) ** 2
    bent = cv2.remap(255 - 255 * flat.astype(np.float32), x - pulled, y + pulled / 2, cv2.INTER_LINEAR)
    found = read(bent.astype(np.uint8))
    assert (found.recovery.payload.text, found.recovery.errors) == ("H15-03-34", (0,))
    assert np.abs(found.warp).max() > 0


def test_model_1_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nobody at hand writes such codes: the eyes of zxing-cpp are replaced, the damaged code is real."""
    dark = np.array(encode("not this", level="L", version=2).matrix.dark)
    dark[9:, 9:] = np.random.default_rng(1).integers(0, 2, (16, 16), bool)
    monkeypatch.setattr(
        symbologies,
        "look",
        lambda engine, _: [("Data Matrix", "no"), (MODEL_1, "old")] if engine == "other" else [],
    )
    with pytest.raises(CaptureError, match="no QR code but a QR code Model 1: 'old'; make a QR code"):
        read(np.kron(~np.pad(dark, 4), np.ones((6, 6), bool)))
