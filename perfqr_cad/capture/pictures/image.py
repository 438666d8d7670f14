"""Pictures as arrays: any file that Pillow opens, SVG by resvg, bytes, or an array; bounded in memory.

Limits. A picture of more than `MAX_PIXELS` is refused before it is decoded. Pictures of more than
`WORK_PIXELS` are reduced by averaging whole blocks, so that everything after this module works on
at most `WORK_PIXELS`. Files are decoded in a process of their own (`decoding`), but for small PNG.
"""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from perfqr_cad.bounded import MIB, read_bytes
from perfqr_cad.capture.pictures import decoding, svg
from perfqr_cad.capture.pictures.decoding import (
    WORK_PIXELS,
    Picture,
    check_size,
    eight_bits,
    flatten,
    reduction,
)
from perfqr_cad.errors import CaptureError
from perfqr_cad.isolated import IsolationError, Limits, kept

MAX_FILE_BYTES = 256 * MIB
# Decoding 10,000 × 10,000 pixels takes up to 10 s; what is decoded is then searched for a code.
DECODER, DECODING = f"{decoding.__name__}:decoder", Limits(cpu_s=20.0)
DRAWER, DRAWING = f"{svg.__name__}:drawer", Limits(cpu_s=10.0)  # version 40 in halftone takes 2 s
PNG = struct.Struct(">8s4x4sII")  # signature, type of the first chunk, width, height (PNG §5.2, §11.2.1)
NOUN = "a picture file"


def load_image(source: str | Path | bytes | NDArray[Any]) -> Picture:
    """The picture as uint8: (h, w) grey or (h, w, 3) RGB, transparency flattened, first frame, upright.

    `source` is a path, the bytes of a file, or an array: bool, uint8, uint16 or float in 0..1, of shape
    (h, w), (h, w, 1), (h, w, 3) or (h, w, 4).  Raises CaptureError.
    """
    if isinstance(source, np.ndarray):
        return _from_array(source)
    if isinstance(source, bytes):
        return _from_file(source, "the picture")
    return _from_file(read_bytes(source, MAX_FILE_BYTES, CaptureError, NOUN), str(source))


def luminance(picture: Picture) -> Picture:
    """(h, w) uint8 luminance (BT.601) of a grey or RGB picture."""
    if picture.ndim == 2:
        return picture
    return np.asarray(Image.fromarray(picture).convert("L"))


def _from_file(content: bytes, name: str) -> Picture:
    if _is_small_png(content):  # its cost is bounded by its size, and starting a process costs as much
        return decoding.decoded(content, name)
    if svg.is_svg(content):
        return decoding.decoded(_isolated(DRAWER, DRAWING, content, name).tobytes(), name)
    return _isolated(DECODER, DECODING, content, name)


def _isolated(job: str, limits: Limits, content: bytes, name: str) -> NDArray[np.uint8]:
    """What a job in a process of its own makes of a file's bytes."""
    try:
        answer = kept(job, limits=limits).ask({"name": name}, np.frombuffer(content, np.uint8))
    except IsolationError as reason:
        raise CaptureError(f"{name} cannot be decoded ({reason}): save it as a plain PNG") from reason
    (found,) = answer.arrays
    return found


def _is_small_png(content: bytes) -> bool:
    if len(content) < PNG.size:
        return False
    signature, first, width, height = PNG.unpack_from(content)
    return signature == b"\x89PNG\r\n\x1a\n" and first == b"IHDR" and width * height <= WORK_PIXELS


def _from_array(values: NDArray[Any]) -> Picture:
    if (
        values.ndim not in (2, 3)
        or (values.ndim == 3 and values.shape[2] not in (1, 3, 4))
        or values.size == 0
    ):
        raise CaptureError(
            f"an array of shape {values.shape} is no picture: give (h, w), (h, w, 3) or (h, w, 4)"
        )
    check_size(values.shape[1], values.shape[0], "the array")
    picture = eight_bits(values)
    if picture.ndim == 3 and picture.shape[2] == 1:
        picture = picture[..., 0]
    image = Image.fromarray(np.ascontiguousarray(picture))
    factor = reduction(image)
    return flatten(image.reduce(factor) if factor > 1 else image)
