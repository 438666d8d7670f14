"""Pictures as arrays: any file that Pillow opens, SVG by resvg, bytes, or an array; bounded in memory.

Limits. A picture of more than `MAX_PIXELS` is refused before it is decoded. Pictures of more than
`WORK_PIXELS` are reduced by averaging whole blocks, so that everything after this module works on
at most `WORK_PIXELS`. Peak memory stays below `MEMORY_BOUND_BYTES`.
"""

from __future__ import annotations

import gzip
import io
import math
import warnings
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageOps, UnidentifiedImageError

from perfqr_cad.errors import CaptureError

Picture = NDArray[np.uint8]  # (h, w) grey or (h, w, 3) RGB

MAX_PIXELS = 100_000_000  # 10,000 × 10,000: decoded at 4 bytes a pixel it takes 400 MB
WORK_PIXELS = 12_000_000  # a 12-megapixel photograph passes unreduced
MAX_FILE_BYTES = 256 * 2**20
MEMORY_BOUND_BYTES = 2**30  # picture decoded once (400 MB) + file + the working copies
SVG_SIDE_PX = 1600  # longest side of a rasterised SVG: 9 px a module at version 40
MAX_SVG_BYTES = 16 * 2**20
MAX_SVG_UNITS = 100_000.0  # longer drawings cost the renderer memory before they are scaled
MIN_SIDE_PX = 21  # version 1 at one pixel a module (ISO/IEC 18004 §5.1)
PALE = 200  # luminance; opaque pixels all above it are light art meant for a dark ground
LUMA = np.array([0.299, 0.587, 0.114], np.float32)  # ITU-R BT.601


def load_image(source: str | Path | bytes | NDArray[Any]) -> Picture:
    """The picture as uint8: (h, w) grey or (h, w, 3) RGB, transparency flattened, first frame, upright.

    `source` is a path, the bytes of a file, or an array: bool, uint8, uint16 or float in 0..1, of shape
    (h, w), (h, w, 1), (h, w, 3) or (h, w, 4).  Raises CaptureError.
    """
    if isinstance(source, np.ndarray):
        picture = _from_array(source)
    else:
        content, name = _content(source)
        picture = _from_svg(content, name) if _is_svg(content) else _from_file(content, name)
    height, width = picture.shape[:2]
    if min(height, width) < MIN_SIDE_PX:
        raise CaptureError(
            f"a picture of {width} × {height} px holds no code: the smallest has {MIN_SIDE_PX} modules a "
            "side; use a larger picture"
        )
    return picture


def luminance(picture: Picture) -> Picture:
    """(h, w) uint8 luminance (BT.601) of a grey or RGB picture."""
    if picture.ndim == 2:
        return picture
    return np.asarray(Image.fromarray(picture).convert("L"))


def _content(source: str | Path | bytes) -> tuple[bytes, str]:
    if isinstance(source, bytes):
        return source, "the picture"
    path = Path(source)
    try:
        size = path.stat().st_size
        if size > MAX_FILE_BYTES:
            raise CaptureError(f"{path} has {size} bytes, the limit is {MAX_FILE_BYTES}: reduce the picture")
        return path.read_bytes(), str(path)
    except OSError as error:
        raise CaptureError(
            f"{path} cannot be read ({error.strerror}): name an existing picture file"
        ) from error


def _from_file(content: bytes, name: str) -> Picture:
    try:
        with warnings.catch_warnings():
            # The size is checked here, before decoding, by the named limit; faulty metadata does no harm.
            warnings.simplefilter("ignore")
            with Image.open(io.BytesIO(content)) as image:
                _check_size(image.width, image.height, name)
                return _flatten(_upright_reduced(image))
    except Image.DecompressionBombError as error:
        raise CaptureError(f"{name} has more than {MAX_PIXELS} pixels: reduce the picture") from error
    except UnidentifiedImageError as error:
        raise CaptureError(
            f"{name} is no picture that can be opened: use PNG, JPEG, GIF, TIFF, WebP or SVG"
        ) from error
    # Pillow's decoders raise these for damaged files.
    except (OSError, SyntaxError, ValueError, EOFError, IndexError, MemoryError, OverflowError) as error:
        raise CaptureError(f"{name} is damaged ({_one_line(error)}): save the picture again") from error


def _check_size(width: int, height: int, name: str) -> None:
    if width * height > MAX_PIXELS:
        raise CaptureError(
            f"{name} has {width} × {height} = {width * height} pixels, the limit is "
            f"{MAX_PIXELS}: reduce the picture"
        )


def _upright_reduced(image: Image.Image) -> Image.Image:
    """First frame, at most `WORK_PIXELS` large, turned as its EXIF orientation says."""
    image.draft(
        "RGB" if image.mode != "L" else "L",
        (image.width // _reduction(image), image.height // _reduction(image)),
    )
    image.load()
    if image.mode in ("I", "F") or image.mode.startswith("I;16"):
        image = Image.fromarray(_eight_bits(np.asarray(image)))
    if image.mode in ("1", "P", "PA") or image.info.get("transparency") is not None:
        image = image.convert("RGBA" if "transparency" in image.info or image.mode == "PA" else "RGB")
    factor = _reduction(image)
    reduced = image.reduce(factor) if factor > 1 else image
    return ImageOps.exif_transpose(reduced)


def _reduction(image: Image.Image) -> int:
    return max(1, math.ceil(math.sqrt(image.width * image.height / WORK_PIXELS)))


def _flatten(image: Image.Image) -> Picture:
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


def _eight_bits(values: NDArray[Any]) -> Picture:
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


def _from_array(values: NDArray[Any]) -> Picture:
    if (
        values.ndim not in (2, 3)
        or (values.ndim == 3 and values.shape[2] not in (1, 3, 4))
        or values.size == 0
    ):
        raise CaptureError(
            f"an array of shape {values.shape} is no picture: give (h, w), (h, w, 3) or (h, w, 4)"
        )
    _check_size(values.shape[1], values.shape[0], "the array")
    picture = _eight_bits(values)
    if picture.ndim == 3 and picture.shape[2] == 1:
        picture = picture[..., 0]
    image = Image.fromarray(np.ascontiguousarray(picture))
    factor = _reduction(image)
    return _flatten(image.reduce(factor) if factor > 1 else image)


def _is_svg(content: bytes) -> bool:
    head = content[:2] == b"\x1f\x8b" or b"<svg" in content[:4096].lower()
    return head and not content.startswith((b"\x89PNG", b"\xff\xd8"))


def _from_svg(content: bytes, name: str) -> Picture:
    import resvg_py

    text = _svg_text(content, name)
    width, height = _svg_proportions(text, name)
    scale = SVG_SIDE_PX / max(width, height)
    try:
        png = resvg_py.svg_to_bytes(
            svg_string=text,
            width=max(1, round(width * scale)),
            height=max(1, round(height * scale)),
            skip_system_fonts=True,
        )
    except ValueError as error:
        raise CaptureError(
            f"{name} is no SVG that can be drawn ({_one_line(error)}): save it again"
        ) from error
    return _from_file(png, name)


def _svg_text(content: bytes, name: str) -> str:
    try:
        if content[:2] == b"\x1f\x8b":
            with gzip.GzipFile(fileobj=io.BytesIO(content)) as packed:
                content = packed.read(MAX_SVG_BYTES + 1)
        if len(content) > MAX_SVG_BYTES:
            raise CaptureError(f"{name} has over {MAX_SVG_BYTES} bytes of SVG, the limit: simplify it")
        return content.decode("utf-8-sig")
    except (OSError, EOFError, UnicodeDecodeError) as error:
        raise CaptureError(f"{name} is a damaged SVG ({_one_line(error)}): save it again") from error


def _svg_proportions(text: str, name: str) -> tuple[float, float]:
    """Width and height of the drawing in its own units, from the view box or the two attributes."""
    try:
        for _, root in ET.iterparse(io.StringIO(text), events=("start",)):
            sizes = root.get("viewBox", "").replace(",", " ").split()[2:4] or [
                root.get("width"),
                root.get("height"),
            ]
            width, height = (float(str(size).rstrip("%ptxmcinPTXMCIN")) for size in sizes)
            if 0 < width <= MAX_SVG_UNITS and 0 < height <= MAX_SVG_UNITS:
                return width, height
            break
    except (ET.ParseError, ValueError):
        pass
    raise CaptureError(
        f"{name} has no size between 0 and {MAX_SVG_UNITS:g} units: give the SVG a viewBox or "
        "width and height"
    )


def _one_line(error: BaseException) -> str:
    return " ".join(str(error).split())[:120] or type(error).__name__
