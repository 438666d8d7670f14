"""Parts, loads and supports drawn at random with a seed: finite, balanced answers, or one line of error."""

import random

import numpy as np
import pytest

from perfqr_cad.errors import PerfQRError
from perfqr_cad.pattern import PatternSpec, build
from perfqr_cad.structure import Case, Finger, Pressure, StressField, Weight, analyse
from perfqr_cad.surface import Cylinder, Plane
from perfqr_cad.symbol import encode


def field_of(seed: int) -> StressField | PerfQRError:
    draw = random.Random(seed)
    thickness = draw.choice((0.8, 2.0))
    size = draw.choice((None, 60.0))
    try:
        spec = PatternSpec(
            size_mm=size,
            style=draw.choice(("square", "rounded", "dots")),
            finder=draw.choice(("panel", "recessed", "diagonal")),
        )
        pattern = build(encode(f"STRONG {seed}", version=1), spec)
        placement = draw.choice((Plane(thickness), Plane(thickness), Cylinder(pattern.size_mm, thickness)))
        load = draw.choice((Pressure(1e-5), Pressure(-1e-3), Weight(), Finger(5.0, at_mm=(3.0, 2.0))))
        support = draw.choice(("clamped", "simple", "two-sides", "corners"))
        return analyse(pattern, placement, Case.of(load, support=support), 1.5 * pattern.module_mm)
    except PerfQRError as error:
        return error


@pytest.mark.parametrize("seed", range(5))
def test_a_random_part_has_a_finite_balanced_answer_or_one_line(seed: int) -> None:
    field = field_of(seed)
    if isinstance(field, PerfQRError):
        assert len(str(field).splitlines()) == 1
        return
    assert np.isfinite(field.displacement_mm).all()
    assert np.isfinite(field.stress_mpa).all()
    assert 0.0 < field.max_stress_mpa <= field.sharp_peak_mpa * (1 + 1e-9)
    assert field.balance < 1e-7
