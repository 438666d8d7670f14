"""GS1 data marked by FNC1, as zxing-cpp reads it (ISO/IEC 18004 §7.4.8)."""

from __future__ import annotations

import numpy as np
import pytest
import zxingcpp

from perfqr_cad.content.gs1 import element_string
from perfqr_cad.symbol import encode, payload_of


@pytest.mark.parametrize("mode", [None, "mixed"])
@pytest.mark.parametrize(
    "written",
    ["(01)09506000134352", "(01)09506000134352(10)AB-1(21)7", "(10)a%b(21)A%7", "(10)A%1(17)271231"],
)
def test_zxing_knows_the_elements(written: str, mode) -> None:
    data = element_string(written)
    symbol = encode(data, fnc1=True, mode=mode)
    light = ~np.pad(symbol.matrix.dark, 4)
    picture = np.kron(light, np.ones((4, 4), bool)).astype(np.uint8) * 255
    (code,) = zxingcpp.read_barcodes(picture)
    assert (code.symbology_identifier, code.content_type) == ("]Q3", zxingcpp.ContentType.GS1)
    assert code.text == written
    assert (payload_of(symbol).fnc1, payload_of(symbol).text) == ("gs1", data)


def test_without_the_mark_it_is_plain_text() -> None:
    symbol = encode(element_string("(01)09506000134352"))
    assert payload_of(symbol).fnc1 is None
