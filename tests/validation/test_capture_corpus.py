"""The payloads of codes by third-party generators, and of the shared pictures when they are at hand.

Generators: QRtsy, pyqart, qrcode-artistic, qrcode[pil] and segno. Photographs: the black-box tests of
zxing (Apache-2.0), with their ground truth beside them.
"""

from __future__ import annotations

import csv
import re
from functools import cache
from pathlib import Path

import pytest
import zxingcpp

from perfqr_cad.capture import load_image, read
from perfqr_cad.capture.pictures.image import luminance
from perfqr_cad.errors import CaptureError
from perfqr_cad.symbol import readability
from tests import pictures

SHARED = Path(__file__).resolve().parents[3] / "shared" / "data"


@cache
def _corpus(seed: int) -> tuple[pictures.Sample, ...]:
    return tuple(pictures.corpus(seed))


def _manifest() -> list[dict[str, str]]:
    path = SHARED / "MANIFEST.csv"
    if not path.exists():
        return []
    with path.open(newline="") as rows:
        return [row for row in csv.DictReader(rows) if row["file"].startswith("art/")]


@pytest.mark.parametrize("row", _manifest(), ids=lambda row: row["file"])
def test_shared_art(row: dict[str, str]) -> None:
    found = read(SHARED / row["file"])
    symbol = found.recovery.symbol
    assert found.recovery.payload.data.startswith(row["payload_starts_with"].encode())
    assert (symbol.version, symbol.level, symbol.mask) == (
        int(row["version"]),
        row["level"],
        int(row["mask"]),
    )


MODEL_1 = ("zxingcpp-2-940.png", "zxingcpp-2-qr-model-1.png")  # codes of the standard's first edition


@pytest.mark.parametrize("path", sorted((SHARED / "photos").glob("*.png")), ids=lambda path: path.name)
def test_shared_photographs(path: Path) -> None:
    expected = path.with_suffix(".txt").read_bytes()
    if path.name in MODEL_1:
        begin = re.escape(expected.decode()[:16].strip())
        with pytest.raises(
            CaptureError, match=f"holds no QR code but a QR code Model 1: '{begin}.*of its text"
        ):
            read(path)
        return
    assert read(path).recovery.payload.data == expected.rstrip(b"\n")


@pytest.mark.parametrize("place", range(pictures.ARTISTIC_OF_CORPUS))
def test_generated_art(place: int) -> None:
    sample = _corpus(4)[place]
    assert sample.is_right(read(sample.picture).recovery.payload.data)


@pytest.mark.parametrize("place", range(pictures.ARTISTIC_OF_CORPUS, pictures.CORPUS_SIZE))
def test_distorted_pictures_are_never_read_wrong(place: int) -> None:
    sample = _corpus(1)[place]
    try:
        data = read(sample.picture).recovery.payload.data
    except CaptureError:
        pytest.skip("beyond reading")
    assert sample.is_right(data)


@pytest.mark.parametrize("place", range(8))
def test_unused_correction_is_that_of_zxing(place: int) -> None:
    """zxing-cpp reports UEC (ISO/IEC 15415); where it reads the same modules, ours is the same."""
    sample = _corpus(4)[place]
    found = read(sample.picture)
    codes = zxingcpp.read_barcodes(
        luminance(load_image(sample.picture)), formats=zxingcpp.BarcodeFormat.QRCode
    )
    if not codes or "UEC" not in codes[0].extra:
        pytest.skip("zxing-cpp does not read it or does not say")
    ours = readability(found.matrix, found.recovery.symbol).unused_correction
    assert ours >= float(codes[0].extra["UEC"]) - 0.02
