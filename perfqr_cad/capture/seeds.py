"""First guesses of where a code lies, from decoders that know how to look for one."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any

import cv2
import numpy as np
import zxingcpp
from numpy.typing import NDArray

from perfqr_cad.capture.grid import Floats
from perfqr_cad.symbol import size_of

_MODEL_2: Any = zxingcpp.BarcodeFormat.QRCodeModel2  # its stubs want the plural type


@dataclass(frozen=True, eq=False)
class Seed:
    """A guess.

    places   (4, 2) px outer corners, clockwise from the top-left finder's if `oriented`; or (3, 2) centres of
             the top-left, top-right and bottom-left finders
    sizes    modules a side that come in question, likeliest first; empty when nothing is known
    payload  what the decoder itself read, or None
    oriented whether the first corner is known to be the top-left finder's
    """

    engine: str
    places: Floats
    sizes: tuple[int, ...]
    payload: bytes | None
    oriented: bool

    def corners(self, size: int) -> Floats:
        """(4, 2) outer corners of a symbol of `size` modules; from three finders as if seen from afar."""
        if len(self.places) == 4:
            return self.places
        corner, end, foot = self.places
        right, down = (end - corner) / (size - 7), (foot - corner) / (size - 7)
        origin = corner - 3.5 * (right + down)
        return np.stack([origin, origin + size * right, origin + size * (right + down), origin + size * down])

    @property
    def outline(self) -> Floats:
        """(4, 2) outer corners of the likeliest symbol."""
        return self.places if len(self.places) == 4 else self.corners(self.sizes[0])


def zxing_seeds(image: NDArray[np.uint8]) -> Iterator[Seed]:
    """What zxing-cpp finds in a grey picture, codes that it could not decode included."""
    found = zxingcpp.read_barcodes(image, formats=_MODEL_2, return_errors=True)
    for code in sorted(found, key=lambda one: not one.valid):
        place = code.position
        points = (place.top_left, place.top_right, place.bottom_right, place.bottom_left)
        corners = np.array([(point.x, point.y) for point in points], np.float64)
        extra: Any = code.extra or {}
        version = str(extra.get("Version", ""))
        sizes = (
            (size_of(int(version)),) if version.isdigit() else ()
        )  # "M3" and "R7x43" are other symbologies
        yield Seed("zxing-cpp", corners, sizes, bytes(code.bytes) if code.valid else None, True)


def wechat_seeds(image: NDArray[np.uint8]) -> Iterator[Seed]:
    """What the WeChat decoder finds. Its Python face fails on payloads that are not UTF-8."""
    try:
        texts, places = _wechat().detectAndDecode(image)
    except UnicodeDecodeError:
        return
    for text, corners in zip(texts, places, strict=False):
        yield Seed("wechat", np.asarray(corners, np.float64).reshape(4, 2), (), text.encode(), False)


def opencv_seeds(image: NDArray[np.uint8]) -> Iterator[Seed]:
    """What OpenCV's own detector finds; its straightened code tells the size."""
    try:
        found: Any = cv2.QRCodeDetector().detectAndDecode(image)
    except (UnicodeDecodeError, cv2.error):  # on payloads that are not UTF-8, and on degenerate outlines
        return
    text, corners, straight = found
    if corners is None:
        return
    size = 0 if straight is None else int(straight.shape[0])
    sizes = (size,) if size >= 21 and size % 4 == 1 else ()
    yield Seed("opencv", np.asarray(corners, np.float64).reshape(4, 2), sizes, text.encode() or None, False)


@cache
def _wechat() -> Any:
    opencv: Any = cv2  # its stubs leave the contributed modules out
    return opencv.wechat_qrcode_WeChatQRCode()
