"""The slider between the art and the plain code."""

import numpy as np
import pytest

from perfqr_cad.capture import Art
from perfqr_cad.capture.clearer import clearer
from perfqr_cad.errors import DesignError
from perfqr_cad.pipeline.request import Request
from perfqr_cad.symbol import encode

SYMBOL = encode("HELLO", level="H")


@pytest.mark.parametrize("scale", [1, 3, 4, 16])
def test_each_step_is_nearer_to_the_plain_code(scale):
    art = Art("freeform", scale, np.random.default_rng(scale).random((SYMBOL.size * scale,) * 2) < 0.5)
    plain = np.kron(SYMBOL.matrix.dark, np.ones((scale, scale), bool))
    wrong = [np.count_nonzero(clearer(art, SYMBOL, share).dark ^ plain) for share in (0, 0.3, 0.6, 0.9, 1)]
    assert wrong == sorted(wrong, reverse=True)
    assert wrong[0] == np.count_nonzero(art.dark ^ plain)
    assert wrong[-1] == 0


def test_what_is_no_share_is_refused():
    Request(image="a.png", legibility="auto")
    Request(image="a.png", legibility="0.5")
    for wrong in ("1.5", "much", "nan"):
        with pytest.raises(DesignError, match="neither auto nor a number"):
            Request(image="a.png", legibility=wrong)
    with pytest.raises(DesignError, match="no effect without"):
        Request(text="a", legibility="0.5")
