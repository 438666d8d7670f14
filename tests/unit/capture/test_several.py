"""Pictures with several codes, and with codes of other symbologies, are told for what they are."""

from __future__ import annotations

import io
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import segno
import zxingcpp

from perfqr_cad.capture import read
from perfqr_cad.capture.several import LISTED_CODES, LISTED_LETTERS, in_reading_order, overlap
from perfqr_cad.errors import CaptureError
from perfqr_cad.symbol import encode, layout
from tests import pictures

FORMAT: Any = zxingcpp.BarcodeFormat


def _sheet(rows: list[list[str]], scale: int = 5, step_px: int = 200) -> np.ndarray:
    """Codes of the texts on a white sheet; each row's second hangs a little lower."""
    sheet = np.full((len(rows) * step_px + 20, max(map(len, rows)) * step_px), 255, np.uint8)
    for row, texts in enumerate(rows):
        for column, text in enumerate(texts):
            code = segno.make(text, error="m", micro=False)
            light = 255 - 255 * np.kron(np.pad(np.array(code.matrix), 4), np.ones((scale, scale), np.uint8))
            top, left = row * step_px + 15 * (column % 2), column * step_px
            sheet[top : top + light.shape[0], left : left + light.shape[1]] = light
    return sheet


def _payload(picture: np.ndarray, which: int | None = None) -> str | None:
    return read(picture, which).recovery.payload.text


def test_several_codes_are_listed_in_reading_order_and_chosen_by_number() -> None:
    texts = [["one", "two", "three"], ["four", "five", "six"]]
    sheet = _sheet(texts)
    with pytest.raises(CaptureError) as refused:
        read(sheet)
    assert str(refused.value) == (
        "the picture holds 6 QR codes: 1 'one', 2 'two', 3 'three', 4 'four', 5 'five', 6 'six'; "
        "choose one with --which N, 1 to 6"
    )
    assert [_payload(sheet, number) for number in range(1, 7)] == texts[0] + texts[1]


@pytest.mark.parametrize(("flip", "enlarged"), [(255, 1), (0, 6)], ids=["inverted", "large"])
def test_inverted_and_large_sheets(flip: int, enlarged: int) -> None:
    sheet = np.kron(_sheet([["left", "right"]]) ^ np.uint8(flip), np.ones((enlarged, enlarged), np.uint8))
    assert [_payload(sheet, number) for number in (1, 2)] == ["left", "right"]


def test_equal_codes_at_two_places_are_two() -> None:
    with pytest.raises(CaptureError, match="holds 2 QR codes: 1 'same', 2 'same'; choose"):
        read(_sheet([["same", "same"]]))


def test_a_code_that_decoders_give_up_on_counts() -> None:
    """Twelve codewords of a block that bears nine errors, in grey: erasures mend it."""
    places = layout(5, "Q")
    picture = np.where(np.pad(encode("greyed", version=5, level="Q").matrix.dark, 4), 0, 255).astype(np.uint8)
    for row, column in places.modules[places.codewords_of_block(0)[:12]].reshape(-1, 2) + 4:
        picture[row, column] = 122 if picture[row, column] else 132
    greyed = np.kron(picture, np.ones((6, 6), np.uint8))
    both = np.hstack([greyed, _sheet([["plain"]], step_px=greyed.shape[0] - 20)])
    assert [code.text for code in zxingcpp.read_barcodes(both)] == ["plain"]
    with pytest.raises(CaptureError, match="holds 2 QR codes: 1 'greyed', 2 'plain'"):
        read(both)


def test_many_and_long_payloads_are_shortened() -> None:
    texts = [
        [f"https://example.com/a/long/way/to/the/thing/{row}{column}" for column in range(5)]
        for row in range(3)
    ]
    with pytest.raises(CaptureError) as refused:
        read(_sheet(texts, scale=4))
    message = str(refused.value)
    assert message.count("'") == 2 * LISTED_CODES
    assert "and 3 more; choose one with --which N, 1 to 15" in message
    assert texts[0][0][: LISTED_LETTERS - 1] + "…" in message
    assert texts[0][0] not in message


@pytest.mark.parametrize("which", [0, 3, -1])
def test_a_number_that_no_code_has(which: int) -> None:
    with pytest.raises(CaptureError, match=rf"2 QR codes: .*; there is no number {which}: choose .* 1 to 2"):
        read(_sheet([["a", "b"]]), which)


def test_a_second_number_of_one_code() -> None:
    assert _payload(_sheet([["alone"]]), 1) == "alone"
    with pytest.raises(
        CaptureError, match="holds 1 QR code: 1 'alone'; there is no number 2: use no --which"
    ):
        read(_sheet([["alone"]]), 2)


@pytest.mark.parametrize(
    "make", [pictures.artistic, pictures.picture_dots, pictures.styled, pictures.coloured]
)
@pytest.mark.parametrize("seed", range(3))
def test_one_artistic_code_is_one(make: Callable[[int], pictures.Sample], seed: int) -> None:
    sample = make(seed)
    assert read(sample.picture).recovery.payload.data == sample.payload


@pytest.mark.parametrize(
    ("kind", "named"),
    [
        ("MicroQRCode", "a Micro QR code: 'AB-12'"),
        ("RMQRCode", "an rMQR code: 'AB-12'"),
        ("Aztec", "an Aztec: 'AB-12'"),
        ("DataMatrix", "a Data Matrix: 'AB-12'"),
        ("PDF417", "a PDF417: 'AB-12'"),
        ("MaxiCode", "a MaxiCode: 'AB-12'"),
        ("Code128", "a Code 128: 'AB-12'"),
    ],
)
def test_other_symbologies_are_named(kind: str, named: str) -> None:
    code = zxingcpp.create_barcode("AB-12", getattr(FORMAT, kind))
    picture = np.array(zxingcpp.write_barcode_to_image(code, scale=4, add_quiet_zones=True))
    with pytest.raises(CaptureError, match=f"the picture holds no QR code but {named}; make a QR code"):
        read(picture)


def test_a_micro_qr_code_in_a_file_beside_none() -> None:
    target = io.BytesIO()
    segno.make_micro("M123").save(target, kind="png", scale=10)
    with pytest.raises(CaptureError, match="holds no QR code but a Micro QR code: 'M123'; make a QR code"):
        read(target.getvalue())


def test_a_qr_code_beside_another_symbology_is_read() -> None:
    code = zxingcpp.create_barcode("beside", FORMAT.Aztec)
    aztec = np.array(zxingcpp.write_barcode_to_image(code, scale=5, add_quiet_zones=True))
    sheet = np.hstack([np.full((220, 200), 255, np.uint8), _sheet([["the one"]])])
    sheet[: aztec.shape[0], : aztec.shape[1]] = aztec
    assert _payload(sheet) == "the one"


SQUARE = np.array([[0.0, 0], [10, 0], [10, 10], [0, 10]])


@pytest.mark.parametrize(
    ("shift", "same"), [((1, 1), True), ((9.9, 0), False), ((11, 0), False), ((3, -3), True)]
)
def test_overlap(shift: tuple[float, float], same: bool) -> None:
    assert overlap(SQUARE, SQUARE + np.array(shift)) is same
    assert overlap(SQUARE[::-1], SQUARE + np.array(shift)) is same


def test_what_has_no_area_overlaps_nothing() -> None:
    assert not overlap(SQUARE, np.zeros((4, 2)))


def test_rows_of_tilted_sheets() -> None:
    """Turned by 5°, each row falls to the right by less than half a code."""
    turn = np.array([[np.cos(0.087), np.sin(0.087)], [-np.sin(0.087), np.cos(0.087)]])
    places = [(x, y) for y in (0, 15) for x in (0, 15, 30)]
    order = in_reading_order(places[::-1], lambda place: (SQUARE + np.array(place)) @ turn)
    assert order == places
