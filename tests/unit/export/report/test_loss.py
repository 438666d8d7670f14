"""The curve of Fig. 9, on patterns whose wrong modules are known."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from perfqr_cad.export.report.loss import loss_curve
from perfqr_cad.pattern import Bridge
from perfqr_cad.symbol import Matrix, encode, layout, readability

MODULE_MM = 2.0


@pytest.fixture(scope="module")
def symbol():
    return encode("LOSS CURVE", version=2, level="M")


def drawn(symbol, wrong, bridges):
    dark = symbol.matrix.dark.copy()
    for row, column in wrong:
        dark[row, column] ^= True
    return SimpleNamespace(symbol=symbol, module_mm=MODULE_MM, observed=Matrix(dark), bridges=tuple(bridges))


def over(symbol, row, column):
    """A bar along a module, shorter and thinner than it."""
    x, y = (column + 0.5 - symbol.size / 2) * MODULE_MM, (symbol.size / 2 - row - 0.5) * MODULE_MM
    return Bridge((x - 0.8, y), (x + 0.8, y), 0.8, "connectivity", 1.0)


def data_modules(symbol, count):
    """Modules of `count` different codewords."""
    codeword = layout(symbol.version, symbol.level).codeword_of
    return [tuple(np.argwhere(codeword == k)[0].tolist()) for k in range(count)]


def test_each_bridge_pays_for_its_own_module(symbol):
    modules = data_modules(symbol, 3)
    pattern = drawn(symbol, modules, [over(symbol, *module) for module in modules])
    curve = loss_curve(pattern)
    expected = [readability(drawn(symbol, modules[:k], []).observed, symbol).total for k in range(4)]
    assert curve == pytest.approx(expected)
    assert curve[0] == 0
    assert curve == sorted(curve)


def test_damage_of_the_art_is_there_from_the_start(symbol):
    modules = data_modules(symbol, 2)
    pattern = drawn(symbol, modules, [over(symbol, *modules[1])])
    total = readability(pattern.observed, symbol).total
    art_only = readability(drawn(symbol, modules[:1], []).observed, symbol).total
    assert loss_curve(pattern) == pytest.approx([art_only, total])


def test_a_bridge_beside_a_wrong_module_does_not_pay(symbol):
    (row, column), *_ = data_modules(symbol, 1)
    pattern = drawn(symbol, [(row, column)], [over(symbol, row, column + 1)])
    curve = loss_curve(pattern)
    assert curve[0] == curve[1] > 0


def test_no_bridges_one_value(symbol):
    assert loss_curve(drawn(symbol, [], [])) == [0.0]
