"""Decoders that tell where they see a code. They run in a process of their own: see `seeds`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.isolated import IsolationError, Limits, Message, kept
from perfqr_cad.symbol import size_of

MODEL_1 = "QR Code Model 1"  # AIM identifier ]Q0; of 1994, without alignment patterns and laid out otherwise
LIMITS = Limits(cpu_s=5.0)  # one engine at one photograph of 12 megapixels takes 1 s; at noise, minutes


@dataclass(frozen=True)
class Sighting:
    """Where an engine sees a code, as plain values; the names are those of `seeds.Seed`."""

    places: list[list[float]]
    sizes: list[int]
    payload_hex: str | None
    oriented: bool


def look(engine: str, image: NDArray[np.uint8]) -> list[Any]:
    """What an engine sees in a grey picture (H, W), as plain values; nothing if it crashes or does not end.

    "zxing-cpp", "wechat" and "opencv" see QR codes (the fields of `Sighting`); "other" sees codes of other
    symbologies (name, text).
    """
    try:
        return kept(f"{__name__}:{engines.__name__}", limits=LIMITS).ask({"engine": engine}, image).value
    except IsolationError:
        return []


def engines() -> Callable[[Message], Message]:
    """The job of the process: `{"engine": ...}` and a grey picture are answered by the engine's sightings."""
    import cv2
    import zxingcpp

    cv2.setNumThreads(1)
    opencv: Any = cv2  # its stubs leave the contributed modules out
    wechat = opencv.wechat_qrcode_WeChatQRCode()
    model_2: Any = zxingcpp.BarcodeFormat.QRCodeModel2  # its stubs want the plural type
    others = _others(zxingcpp.BarcodeFormat)
    see: dict[str, Callable[[NDArray[np.uint8]], Iterator[Any]]] = {
        "zxing-cpp": lambda image: _zxing(zxingcpp.read_barcodes(image, formats=model_2, return_errors=True)),
        "wechat": lambda image: _wechat(wechat, image),
        "opencv": lambda image: _opencv(cv2, image),
        "other": lambda image: (
            (MODEL_1 if code.symbology_identifier == "]Q0" else str(code.format), code.text)
            for code in zxingcpp.read_barcodes(image, formats=zxingcpp.BarcodeFormats(others))
        ),
    }

    def answer(request: Message) -> Message:
        seen = see[request.value["engine"]](request.arrays[0])
        return Message([vars(one) if isinstance(one, Sighting) else one for one in seen])

    return answer


def _others(known: Any) -> list[Any]:
    """Symbologies with check characters: what lacks them (ITF, Codabar, …) is also "read" in stripes and
    noise."""
    return [known.AllMatrix, known.AllRetail, known.Code128, known.Code93, known.Code39]


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
