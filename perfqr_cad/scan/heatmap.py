"""The report's heat map: one row per decoder, one column per tilt."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from perfqr_cad.scan.report import DecoderResult

_CELL, _LABEL, _HEAD, _GAP = (46, 30), 130, 44, 24  # (width, height) of a cell, and margins, in pixels
_INK = (40, 40, 40)
# Missed, half read and read, distinguishable by lightness alone.
_SCALE = np.array([[165, 45, 40], [240, 200, 120], [60, 140, 110]], float)


def draw(results: Sequence[DecoderResult]) -> NDArray[np.uint8]:
    """Picture (H, W, 3) uint8, red first: rates of the part, and beside them those of the flat print."""
    tilts = results[0].tilts_deg
    block = len(tilts) * _CELL[0]
    height = _HEAD + len(results) * _CELL[1] + 10
    picture = np.full((height, _LABEL + 2 * block + _GAP + 10, 3), 255, np.uint8)
    sides = ((_LABEL, "part", [r.rates for r in results]),
             (_LABEL + block + _GAP, "flat print", [r.flat_rates for r in results]))  # fmt: skip
    for row, result in enumerate(results):
        _write(picture, result.name, 8, _HEAD + row * _CELL[1] + 20)
    for left, title, rates in sides:
        _write(picture, title, left, 16)
        for column, tilt in enumerate(tilts):
            _write(picture, f"{tilt:g}", left + column * _CELL[0] + 12, 36)
            for row, rate in enumerate(rates):
                if rate is not None:
                    _cell(picture, left + column * _CELL[0], _HEAD + row * _CELL[1], rate[column])
    return picture


def _cell(picture: NDArray[np.uint8], x: int, y: int, rate: float) -> None:
    colour = [int(np.interp(rate, (0, 0.5, 1), _SCALE[:, c])) for c in range(3)]
    cv2.rectangle(picture, (x + 1, y + 1), (x + _CELL[0] - 2, y + _CELL[1] - 2), colour, cv2.FILLED)
    _write(picture, f"{100 * rate:.0f}", x + 8, y + 20, (255, 255, 255) if rate != 0.5 else _INK)


def _write(
    picture: NDArray[np.uint8], text: str, x: int, y: int, colour: tuple[int, int, int] = _INK
) -> None:
    cv2.putText(picture, text, (x, y), cv2.FONT_HERSHEY_SIMPLEX, 0.45, colour, 1, cv2.LINE_AA)
