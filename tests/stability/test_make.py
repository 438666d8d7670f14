"""Requests drawn at random with a seed: each gives a sound part that says what it is, or a line of error."""

import math
import random
import string
from functools import lru_cache
from typing import Any

import pytest

from perfqr_cad import make
from perfqr_cad.errors import PerfQRError
from perfqr_cad.pipeline.design import Design

SEEDS = range(6)


def request_of(seed: int) -> dict[str, Any]:
    """Settings of every kind, most of them sensible, some at the edge of what can be made."""
    draw = random.Random(seed)
    alphabets = (string.digits, string.ascii_uppercase + "-./:", string.printable[:95], "äöü語ключ€")
    letters = draw.choice(alphabets)
    text = "".join(draw.choices(letters, k=draw.randint(1, 90)))
    return {
        "text": text,
        "level": draw.choice("LMQH"),
        "size_mm": draw.choice((None, None, 40.0, 80.0, 160.0)),
        "thickness_mm": draw.choice((0.8, 1.2, 1.6, 2.4, 4.0)),
        "nozzle_mm": draw.choice((0.25, 0.4, 0.6)),
        "style": draw.choice(("square", "square", "rounded", "dots", "diamond", "bars")),
        "tone": draw.choice(("normal", "normal", "normal", "inverted")),
        "finder": draw.choice(("panel", "recessed", "diagonal")),
        "draft_deg": draw.choice((0.0, 0.0, 8.0, 15.0)),
        "lip_mm": draw.choice((0.0, 0.4)),
        "support": draw.choice(("clamped", "simple", "two-sides", "corners")),
        "pressure_mpa": draw.choice((0.0, 1e-3, 1e-2)),
        "material": draw.choice(("PLA", "PETG", "steel")),
        "seed": seed,
    }


@lru_cache
def attempt(seed: int) -> Design | PerfQRError:
    """The design, or the error that the user is told."""
    try:
        return make(**request_of(seed))
    except PerfQRError as error:
        return error


@pytest.mark.parametrize("seed", SEEDS)
def test_a_random_request_gives_a_sound_part_or_one_line(seed: int) -> None:
    settings = request_of(seed)
    design = attempt(seed)
    if isinstance(design, PerfQRError):
        assert len(str(design).splitlines()) == 1, settings
        return
    certificate = design.certificate()
    assert certificate["payload"] == settings["text"]
    assert design.solid.valid, design.solid.problems
    assert certificate["connectivity"]["components"] == 1
    assert certificate["solid"]["solids"] == 1
    assert math.isfinite(certificate["readability"]["loss"])
    assert certificate["structure"]["max_stress_mpa"] > 0
    assert design.scan.readers


def test_half_of_them_are_made() -> None:
    assert sum(isinstance(attempt(seed), Design) for seed in SEEDS) >= len(SEEDS) / 2
