"""Decoders that tell where they see a code. They run in a process of their own: see `seeds`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.isolated import Message
from perfqr_cad.symbol import size_of


@dataclass(frozen=True)
class Sighting:
    """Where an engine sees a code, as plain values; the names are those of `seeds.Seed`."""

    places: list[list[float]]
    sizes: list[int]
    payload_hex: str | None
    oriented: bool


def engines() -> Callable[[Message], Message]:
    """The job of the process: `{"engine": ...}` and a grey picture are answered by the engine's sightings."""
    import cv2
    import zxingcpp

    cv2.setNumThreads(1)
    opencv: Any = cv2  # its stubs leave the contributed modules out
    wechat = opencv.wechat_qrcode_WeChatQRCode()
    model_2: Any = zxingcpp.BarcodeFormat.QRCodeModel2  # its stubs want the plural type
    look: dict[str, Callable[[NDArray[np.uint8]], Iterator[Sighting]]] = {
        "zxing-cpp": lambda image: _zxing(zxingcpp.read_barcodes(image, formats=model_2, return_errors=True)),
        "wechat": lambda image: _wechat(wechat, image),
        "opencv": lambda image: _opencv(cv2, image),
    }

    def answer(request: Message) -> Message:
        return Message([vars(seen) for seen in look[request.value["engine"]](request.arrays[0])])

    return answer


def _zxing(found: Any) -> Iterator[Sighting]:
    """Codes that it could not decode come last."""
    for code in sorted(found, key=lambda one: not one.valid):
        place = code.position
        points = (place.top_left, place.top_right, place.bottom_right, place.bottom_left)
        corners = [[float(point.x), float(point.y)] for point in points]
        extra: Any = code.extra or {}
        version = str(extra.get("Version", ""))
        sizes = [size_of(int(version))] if version.isdigit() else []  # "M3" and "R7x43": other symbologies
        yield Sighting(corners, sizes, bytes(code.bytes).hex() if code.valid else None, True)


def _wechat(detector: Any, image: NDArray[np.uint8]) -> Iterator[Sighting]:
    """Its Python face fails on payloads that are not UTF-8."""
    try:
        texts, places = detector.detectAndDecode(image)
    except UnicodeDecodeError:
        return
    for text, corners in zip(texts, places, strict=False):
        square = np.asarray(corners, np.float64).reshape(4, 2)
        yield Sighting(square.tolist(), [], text.encode().hex(), False)


def _opencv(cv2: Any, image: NDArray[np.uint8]) -> Iterator[Sighting]:
    """OpenCV's own detector; its straightened code tells the size."""
    try:
        text, corners, straight = cv2.QRCodeDetector().detectAndDecode(image)
    except (UnicodeDecodeError, cv2.error):  # on payloads that are not UTF-8, and on degenerate outlines
        return
    if corners is None:
        return
    size = 0 if straight is None else int(straight.shape[0])
    sizes = [size] if size >= 21 and size % 4 == 1 else []
    square = np.asarray(corners, np.float64).reshape(4, 2)
    yield Sighting(square.tolist(), sizes, text.encode().hex() or None, False)
