"""From the bytes of a picture file to pixels. It runs in a process of its own: see `image`."""

from __future__ import annotations

import io
import math
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageFile, ImageOps, UnidentifiedImageError

from perfqr_cad.errors import CaptureError
from perfqr_cad.isolated import Message

Picture = NDArray[np.uint8]  # (h, w) grey or (h, w, 3) RGB

MAX_PIXELS = 100_000_000  # 10,000 × 10,000: decoded at 4 bytes a pixel it takes 400 MB
MAX_SIDE_PX = 30_000  # OpenCV maps pictures of less than 32,767 pixels a side
WORK_PIXELS = 12_000_000  # a 12-megapixel photograph passes unreduced
MIN_SIDE_PX = 21  # version 1 at one pixel a module (ISO/IEC 18004 §5.1)
PALE = 200  # luminance; opaque pixels all above it are light art meant for a dark ground
LEADING_BYTES = 256  # in which blanks may stand before a program begins
BYTE_ORDER_MARK = b"\xef\xbb\xbf"  # of UTF-8
LUMA = np.array([0.299, 0.587, 0.114], np.float32)  # ITU-R BT.601
# PostScript, the same as old printer drivers begin it, PDF, and EPS with a preview.
PROGRAMS = (b"%!PS", b"\x04%!PS", b"%PDF", b"\xc5\xd0\xd3\xc6")


def decoder() -> Callable[[Message], Message]:
    """The job of the process: `{"name": ...}` and a file's bytes are answered by its picture."""
    Image.init()  # every format that Pillow knows

    def answer(request: Message) -> Message:
        return Message(None, (decoded(request.arrays[0].tobytes(), request.value["name"]),))

    return answer


def decoded(content: bytes, name: str) -> Picture:
    """The picture in a file's bytes. CaptureError if it is none, damaged, too large or too small."""
    if content[:LEADING_BYTES].removeprefix(BYTE_ORDER_MARK).lstrip().startswith(PROGRAMS):
        raise CaptureError(
            f"{name} is PostScript or PDF, a program that would have to be run: draw it as PNG, for example "
            "with Ghostscript: gs -o code.png -sDEVICE=png16m -r300 -dEPSCrop FILE"
        )
    try:
        with warnings.catch_warnings():
            # The size is checked here, before decoding, by the named limit; faulty metadata does no harm.
            warnings.simplefilter("ignore")
            with Image.open(io.BytesIO(content)) as image:
                if isinstance(image, ImageFile.StubImageFile):
                    raise CaptureError(
                        f"{name} is a {image.format} file, which cannot be drawn: save it as PNG"
                    )
                check_size(image.width, image.height, name)
                return flatten(_upright_reduced(image))
    except Image.DecompressionBombError as error:
        raise CaptureError(f"{name} has more than {MAX_PIXELS} pixels: reduce the picture") from error
    except UnidentifiedImageError as error:
        raise CaptureError(
            f"{name} is no picture that can be opened: use PNG, JPEG, GIF, TIFF, WebP or SVG"
        ) from error
    # Pillow's decoders raise these for damaged files.
    except (OSError, SyntaxError, ValueError, EOFError, IndexError, OverflowError) as error:
        raise CaptureError(f"{name} is damaged ({one_line(error)}): save the picture again") from error


def check_size(width: int, height: int, name: str) -> None:
    """CaptureError for a picture that is too large, or too small for any code."""
    if width * height > MAX_PIXELS:
        raise CaptureError(
            f"{name} has {width} × {height} = {width * height} pixels, the limit is "
            f"{MAX_PIXELS}: reduce the picture"
        )
    if max(width, height) > MAX_SIDE_PX:
        raise CaptureError(
            f"{name} has {width} × {height} pixels, the limit a side is {MAX_SIDE_PX}: crop the picture"
        )
    if min(width, height) < MIN_SIDE_PX:
        raise CaptureError(
            f"{name} has {width} × {height} pixels, which hold no code: the smallest has {MIN_SIDE_PX} "
            "modules a side; use a larger picture"
        )


def _upright_reduced(image: Image.Image) -> Image.Image:
    """First frame, at most `WORK_PIXELS` large, turned as its EXIF orientation says."""
    image.draft(
        "RGB" if image.mode != "L" else "L",
        (image.width // reduction(image), image.height // reduction(image)),
    )
    image.load()
    if image.mode in ("I", "F") or image.mode.startswith("I;16"):
        image = Image.fromarray(eight_bits(np.asarray(image)))
    if image.mode in ("1", "P", "PA") or image.info.get("transparency") is not None:
        image = image.convert("RGBA" if "transparency" in image.info or image.mode == "PA" else "RGB")
    factor = reduction(image)
    reduced = image.reduce(factor) if factor > 1 else image
    return ImageOps.exif_transpose(reduced)


def reduction(image: Image.Image) -> int:
    """Pixels a side of the blocks that are averaged, so that `WORK_PIXELS` are left at the most."""
    return max(1, math.ceil(math.sqrt(image.width * image.height / WORK_PIXELS)))


def flatten(image: Image.Image) -> Picture:
    """RGB or grey array; transparent parts lie on white, or on black when all that is opaque is pale."""
    if image.mode == "L":
        return np.array(image)
    if "A" not in image.mode and "a" not in image.mode:
        return np.array(image.convert("RGB"))
    layered = np.array(image.convert("RGBA"))
    return _over_ground(layered)


def _over_ground(layered: Picture) -> Picture:
    opacity = layered[..., 3:].astype(np.float32) / 255.0
    colour = layered[..., :3].astype(np.float32)
    opaque = colour[layered[..., 3] > 127] @ LUMA
    pale = opaque.size > 0 and opaque.size < opacity.size and float(np.percentile(opaque, 10)) > PALE
    ground = 0.0 if pale else 255.0
    return np.rint(colour * opacity + ground * (1.0 - opacity)).astype(np.uint8)


def eight_bits(values: NDArray[Any]) -> Picture:
    """uint8 from bool, 8-bit, 16-bit (÷ 257), wider integers and floats (0..1, else stretched)."""
    if values.dtype == np.uint8:
        return values
    if values.dtype == np.bool_:
        return values.astype(np.uint8) * np.uint8(255)
    numbers = np.nan_to_num(values.astype(np.float32))
    if values.dtype.kind in "iu":
        top = 255.0 if numbers.max(initial=0) <= 255 else 65535.0
        scaled = numbers * (255.0 / top)
    elif numbers.min(initial=0) >= 0.0 and numbers.max(initial=0) <= 1.0:
        scaled = numbers * 255.0
    else:
        low, high = float(numbers.min()), float(numbers.max())
        scaled = (numbers - low) * (255.0 / max(high - low, 1e-12))
    return np.clip(np.rint(scaled), 0, 255).astype(np.uint8)


def one_line(error: BaseException) -> str:
    """An exception's text on one line, for a message."""
    return " ".join(str(error).split())[:120] or type(error).__name__
