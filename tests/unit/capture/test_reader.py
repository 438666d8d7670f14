"""Reading codes whose truth is known from their making."""

from __future__ import annotations

import numpy as np
import pytest
import segno

from perfqr_cad.capture import read
from perfqr_cad.errors import CaptureError


def test_reads_a_plain_code() -> None:
    code = segno.make("plain text", version=5, error="q", mask=3, micro=False)
    picture = np.where(np.kron(np.pad(np.array(code.matrix), 4), np.ones((7, 7))) > 0, 0, 255).astype(np.uint8)
    found = read(picture)
    assert found.recovery.payload.text == "plain text"
    assert np.array_equal(found.matrix.dark, np.array(code.matrix, dtype=bool))
    assert (found.art.kind, found.art.scale) == ("plain", 1)


def test_a_picture_without_a_code_is_an_error() -> None:
    noise = np.random.default_rng(1).integers(0, 255, (200, 200), dtype=np.uint8)
    with pytest.raises(CaptureError, match="no "):
        read(noise)
