"""What a picture lost on its way to a part."""

import numpy as np

from perfqr_cad import scan
from perfqr_cad.capture import Art
from perfqr_cad.pattern import PatternSpec, build
from perfqr_cad.scan import DecoderResult, Look
from perfqr_cad.scan.camera.flat import printed
from perfqr_cad.scan.likeness import likeness, similarity
from perfqr_cad.symbol import encode

TEXT = "https://example.com/a"


def halftone(dark: np.ndarray, scale: int, seed: int) -> Art:
    """Random dots with the right colour in the middle of every module."""
    dots = np.random.default_rng(seed).random((len(dark) * scale, len(dark) * scale)) < 0.5
    dots[scale // 2 :: scale, scale // 2 :: scale] = dark
    return Art("halftone", scale, dots)


def test_similarity_falls_with_noise_and_with_another_picture():
    rng = np.random.default_rng(0)
    picture = rng.integers(0, 255, (64, 64), np.uint8)
    near = np.clip(picture + rng.normal(0, 5, picture.shape), 0, 255).astype(np.uint8)
    assert similarity(picture, picture) == 1
    assert 0.9 < similarity(picture, near) < 1
    assert similarity(picture, 255 - picture) < 0


def test_what_reads_the_art_and_not_the_part_is_named():
    symbol = encode(TEXT, version=2, level="M")
    pattern = build(symbol, PatternSpec(size_mm=80.0))
    scene = scan.plate_scene(pattern, 1.6)
    results = {name: DecoderResult(name, (0.0,), (rate,), None) for name, rate in (("a", 1.0), ("b", 0.0))}
    plain = printed(symbol.matrix.dark, pattern.size_mm)
    near = likeness(scene, plain, Look(), pattern.size_mm, results)
    art = halftone(symbol.matrix.dark, 3, 1)
    far = likeness(scene, printed(art.dark, pattern.size_mm, scale=3), Look(), pattern.size_mm, results)
    assert 0.5 < near.ssim < 1
    assert far.ssim < near.ssim - 0.2
    assert near.lost(()) == ("a",)
    assert near.lost(("a",)) == ()
    assert "a read the art and not the part" in near.words(())
    assert near.as_dict(("a",))["lost"] == []


def test_the_certificate_of_a_picture_has_its_art():
    symbol = encode(TEXT, version=2, level="M")
    pattern = build(symbol, PatternSpec(size_mm=80.0))
    art = Art("plain", 1, symbol.matrix.dark)
    from perfqr_cad.solid import build as solid
    from perfqr_cad.surface import Plane

    plate = Plane(1.6)
    once = scan.Schedule((0.0,), (65.0,), size_px=640)
    found = scan.certify(
        solid(pattern, plate).triangles, plate, pattern, TEXT, schedule=once, decoders=["zbar"], art=art
    )
    assert found.likeness is not None
    assert found.likeness.readers == ("zbar",)
    assert found.as_dict()["art"]["rates"] == {"zbar": {"0": 1.0}}
    assert "SSIM" in found.render()
