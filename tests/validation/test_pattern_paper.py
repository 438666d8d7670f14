"""Figures 8 and 9 of the paper: what λ does, and what routes along module edges do better."""

import math
from itertools import pairwise

import numpy as np
import pytest

from perfqr_cad.capture import Art
from perfqr_cad.pattern import PatternSpec, build
from perfqr_cad.symbol import Role, encode, layout


@pytest.fixture(scope="module")
def patterns():
    """A dark halftone in which almost every light dot is an island, by each objective."""
    symbol = encode("figure 8", version=2, level="M")
    rng = np.random.default_rng(8)
    roles = layout(symbol.version, symbol.level).roles
    dark = np.kron(symbol.matrix.dark, np.ones((3, 3), bool))
    art = np.where(
        np.kron(np.isin(roles, (Role.DATA, Role.EC)), np.ones((3, 3), bool)),
        rng.random(dark.shape) > 0.25,
        dark,
    )
    art[1::3, 1::3] = symbol.matrix.dark
    return {
        o: build(symbol, PatternSpec(objective=o), Art("halftone", 3, art))
        for o in ("mst", "paper", "optimal")
    }


def test_loss_never_falls_along_the_connectors(patterns):
    for objective in ("mst", "paper"):
        losses = patterns[objective].losses
        assert len(losses) > 20
        assert all(a <= b for a, b in pairwise(losses))


def test_distance_alone_loses_more_than_equation_4(patterns):
    assert sum(patterns["mst"].readability.errors) > sum(patterns["paper"].readability.errors)


def test_optimal_is_no_worse_than_the_paper_on_its_own_measures(patterns):
    ours, theirs = patterns["optimal"], patterns["paper"]
    assert math.isfinite(ours.readability.total)
    assert sum(ours.readability.errors) == 0 <= sum(theirs.readability.errors)
    assert ours.readability.total <= theirs.readability.total
    assert ours.changed_area_mm2 < theirs.changed_area_mm2
    assert ours.optimality is not None
    assert ours.optimality.bound <= ours.optimality.objective
