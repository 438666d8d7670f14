"""A claim to be read names ground and light."""

import numpy as np

from perfqr_cad import scan
from perfqr_cad.pattern import PatternSpec, build
from perfqr_cad.scan import GROUNDS, Ground, Look, View
from perfqr_cad.scan.grounds import GroundResult, in_words
from perfqr_cad.symbol import encode


def result(ground: Ground, **rates: tuple[float, float]) -> GroundResult:
    return GroundResult(ground, (0.0, 20.0), dict(rates))


def test_words_tell_apart_what_is_read_well_in_part_and_never():
    dark, grey, white = (
        Ground(name, (value,) * 3) for name, value in (("dark", 0), ("grey", 0.2), ("white", 1))
    )
    found = (
        result(dark, a=(1, 1), b=(1, 1)),
        result(grey, a=(1, 1), b=(1, 0.5)),
        result(white, a=(1, 0), b=(0, 0)),
    )
    said = in_words(found, 2)
    assert said.startswith("reads on dark; in part on grey (1 of 2); not before white: add a backing")
    assert found[1].read_by() == ("a",)
    assert found[1].read_by(0.0) == ("a", "b")
    assert found[2].as_dict()["reflectance"] == [1, 1, 1]
    assert found[2].as_dict()["rates"]["a"] == {"0": 1, "20": 0}


def test_contrast_falls_from_black_to_a_bright_room():
    pattern = build(encode("https://example.com/a", version=2), PatternSpec(size_mm=60.0))
    scene = scan.plate_scene(pattern, 1.6, draft_deg=15.0, lip_mm=0.2)
    spread = {}
    for ground in (Ground("black", (0.04,) * 3), *GROUNDS):
        picture = scene.photo(View(size_px=400), ground.look(Look()))
        middle = picture[90:310, 90:310]
        spread[ground.name] = float(np.quantile(middle, 0.95)) - float(np.quantile(middle, 0.05))
    order = ("black", "dark wood", "a white wall 5 mm behind", "a bright room far behind")
    falling = [spread[name] for name in order]
    assert falling == sorted(falling, reverse=True)
    assert falling[-1] < 0.4 * falling[0]


def test_a_see_through_part_is_read_on_black_and_not_before_a_bright_room():
    from perfqr_cad.solid import build as solid
    from perfqr_cad.surface import Plane

    text = "https://example.com/a"
    pattern = build(encode(text, version=2), PatternSpec(size_mm=60.0))
    plate = Plane(1.6)
    views = scan.Schedule((0.0,), (65.0,), size_px=640, grounds=GROUNDS[-1:], ground_tilts_deg=(0.0,))
    found = scan.certify(
        solid(pattern, plate).triangles, plate, pattern, text, schedule=views, decoders=["zbar"]
    )
    assert found.readers == ("zbar",)
    assert found.grounds[0].read_by() == ()
    section = found.as_dict()
    assert section["ground"]["reflectance"] == [0.04, 0.04, 0.04]
    assert "not before a bright room" in section["reads_on"]
    known = scan.Schedule((0.0,), (65.0,), size_px=640, grounds=GROUNDS, ground_known=True)
    again = scan.certify(
        solid(pattern, plate).triangles, plate, pattern, text, schedule=known, decoders=["zbar"]
    )
    assert again.grounds == ()


def test_the_phone_takes_light_off_what_it_stands_over():
    pattern = build(encode("https://example.com/a", version=2), PatternSpec(size_mm=60.0))
    scene = scan.plate_scene(pattern, 1.6)
    flat = scan.printed(pattern.symbol.matrix.dark, 60.0)
    for subject in (scene, flat):
        light, shaded = (
            float(subject.photo(View(size_px=300), Look(phone=phone)).mean()) for phone in (False, True)
        )
        assert 0.8 * light < shaded < 0.98 * light
