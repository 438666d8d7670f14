"""Any picture file becomes grey or RGB bytes, or a one-line error, within bounded memory."""

from __future__ import annotations

import gzip
import io
import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
import segno
from PIL import Image

from perfqr_cad.capture import load_image, read
from perfqr_cad.capture.pictures.decoding import MAX_PIXELS, WORK_PIXELS
from perfqr_cad.errors import CaptureError

TEXT = "any picture"


def _code(scale: int = 4) -> Image.Image:
    target = io.BytesIO()
    segno.make(TEXT, error="m", micro=False).save(target, kind="png", scale=scale)
    return Image.open(io.BytesIO(target.getvalue())).convert("L")


def _saved(image: Image.Image, kind: str, **settings: object) -> bytes:
    target = io.BytesIO()
    image.save(target, kind, **settings)
    return target.getvalue()


def _payload(source: bytes | np.ndarray) -> str | None:
    return read(source).recovery.payload.text


@pytest.mark.parametrize("mode", ["1", "L", "P", "RGB", "RGBA", "LA"])
@pytest.mark.parametrize("kind", ["PNG", "TIFF"])
def test_modes(mode: str, kind: str) -> None:
    assert _payload(_saved(_code().convert(mode), kind)) == TEXT


@pytest.mark.parametrize("kind", ["JPEG", "TIFF"])
def test_cmyk(kind: str) -> None:
    assert _payload(_saved(_code().convert("CMYK"), kind)) == TEXT


@pytest.mark.parametrize("kind", ["PNG", "TIFF"])
def test_sixteen_bits(kind: str) -> None:
    deep = np.array(_code()).astype(np.uint16) * 100 + 3000
    assert _payload(_saved(Image.fromarray(deep), kind)) == TEXT


def test_palette_gif_with_transparency() -> None:
    assert _payload(_saved(_code().convert("P"), "GIF", transparency=255)) == TEXT


@pytest.mark.parametrize(("dark", "light"), [("black", None), (None, "white"), ("#0a0", None)])
def test_transparent_png(dark: str | None, light: str | None) -> None:
    target = io.BytesIO()
    segno.make(TEXT, error="m", micro=False).save(target, kind="png", scale=4, dark=dark, light=light)
    assert _payload(target.getvalue()) == TEXT


@pytest.mark.parametrize("packed", [False, True])
def test_svg(packed: bool) -> None:
    target = io.BytesIO()
    segno.make(TEXT, error="m", micro=False).save(target, kind="svg")
    assert _payload(gzip.compress(target.getvalue()) if packed else target.getvalue()) == TEXT


@pytest.mark.parametrize("dtype", [bool, np.uint8, np.uint16, np.float32, np.float64])
def test_arrays(dtype: type) -> None:
    share = np.array(_code()) / 255.0
    top = {np.uint8: 255, np.uint16: 65535}.get(dtype, 1)
    assert _payload((share * top).astype(dtype)) == TEXT
    assert _payload(np.repeat((share * top).astype(dtype)[..., None], 3, axis=2)) == TEXT


def test_turned_by_exif() -> None:
    marked = Image.Exif()
    marked[0x0112] = 6
    loaded = load_image(_saved(Image.new("L", (60, 40)), "JPEG", exif=marked))
    assert loaded.shape == (60, 40)


def test_a_large_picture_is_reduced(tmp_path: Path) -> None:
    path = tmp_path / "large.png"
    Image.new("1", (10_000, 10_000)).save(path)
    loaded = load_image(path)
    assert loaded.shape[0] * loaded.shape[1] <= WORK_PIXELS


def _png_that_claims(width: int, height: int) -> bytes:
    def chunk(kind: bytes, body: bytes) -> bytes:
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    header = struct.pack(">IIBBBBB", width, height, 1, 0, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", header)
        + chunk(b"IDAT", zlib.compress(b"\0" * 99))
        + chunk(b"IEND", b"")
    )


@pytest.mark.parametrize("side", [10_001, 60_000])
def test_a_decompression_bomb_is_refused_before_it_is_decoded(side: int) -> None:
    with pytest.raises(CaptureError, match=str(MAX_PIXELS)):
        load_image(_png_that_claims(side, side))


BAD = {
    "empty": b"",
    "text": b"not a picture",
    "truncated": _saved(_code(), "PNG")[:200],
    "truncated JPEG": _saved(_code().convert("RGB"), "JPEG")[:600],
    "one pixel": _saved(Image.new("L", (1, 1)), "PNG"),
    "SVG without a size": b'<svg xmlns="http://www.w3.org/2000/svg"></svg>',
    "unfinished SVG": b'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9"><rect',
    "endless SVG": b'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 1 1000000000"></svg>',
    "broken SVGZ": b"\x1f\x8b\x08\x00nonsense",
}


@pytest.mark.parametrize("name", BAD)
def test_bad_files_are_one_line_errors(name: str) -> None:
    with pytest.raises(CaptureError) as caught:
        load_image(BAD[name])
    assert "\n" not in str(caught.value)
    assert ":" in str(caught.value)


def test_a_missing_file_names_itself(tmp_path: Path) -> None:
    with pytest.raises(CaptureError, match=r"nowhere\.png"):
        load_image(tmp_path / "nowhere.png")


@pytest.mark.parametrize("shape", [(5,), (30, 30, 2), (2, 30, 30, 3), (0, 30)])
def test_arrays_that_are_no_pictures(shape: tuple[int, ...]) -> None:
    with pytest.raises(CaptureError):
        load_image(np.zeros(shape, np.uint8))


@pytest.mark.parametrize(
    "start", [b"%!PS-Adobe-3.0 EPSF-3.0\n", b"%PDF-1.7\n", b"\n  %PDF-1.4", b"\x04%!PS", b"\xc5\xd0\xd3\xc6"]
)
def test_what_is_a_program_asks_to_be_drawn(start: bytes) -> None:
    with pytest.raises(CaptureError, match=r"PostScript or PDF, .*: draw it as PNG, .* Ghostscript: gs -o"):
        load_image(start + b"0 0 moveto showpage\n")


def test_a_format_that_pillow_knows_by_name_alone() -> None:
    header = b"GRIB\0\0\0\x01" + bytes(40)
    with pytest.raises(CaptureError, match="is a GRIB file, which cannot be drawn: save it as PNG"):
        load_image(header)
