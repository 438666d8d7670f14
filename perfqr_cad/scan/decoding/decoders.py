"""The readers: one function per engine, `gray image -> payloads`, and what counts as the right payload.

Each engine is imported when it is first used. None of them is called in the user's process: see `panel`.
"""

from __future__ import annotations

import contextlib
import importlib.util
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.scan.decoding import node

Gray = NDArray[np.uint8]
Reader = Callable[[Gray], tuple[bytes, ...]]

# The four engines behind most readers in the field; the certificate always asks them.
CORE = ("zxing-cpp", "zbar", "wechat", "opencv")


def _zxing() -> Reader:
    import zxingcpp

    qr: Any = zxingcpp.BarcodeFormat.QRCode

    def read(image: Gray) -> tuple[bytes, ...]:
        return tuple(bytes(found.bytes) for found in zxingcpp.read_barcodes(image, formats=qr))

    return read


def _zbar() -> Reader:
    from pyzbar import pyzbar

    symbols = [pyzbar.ZBarSymbol.QRCODE]

    def read(image: Gray) -> tuple[bytes, ...]:
        return tuple(found.data for found in pyzbar.decode(image, symbols=symbols))

    return read


def _opencv_detector(make: Callable[[Any], Any]) -> Reader:
    import cv2

    cv2.setNumThreads(1)  # the panel runs one worker per core
    detector = make(cv2)

    def read(image: Gray) -> tuple[bytes, ...]:
        try:
            found = detector.detectAndDecode(image)[0]
        except (cv2.error, UnicodeDecodeError):  # raised on some views and on payloads that are not UTF-8
            return ()
        texts = (found,) if isinstance(found, str) else found
        return tuple(text.encode() for text in texts if text)

    return read


def _opencv() -> Reader:
    return _opencv_detector(lambda cv2: cv2.QRCodeDetector())


def _opencv_aruco() -> Reader:
    return _opencv_detector(lambda cv2: cv2.QRCodeDetectorAruco())


def _wechat() -> Reader:
    return _opencv_detector(lambda cv2: cv2.wechat_qrcode_WeChatQRCode())


def _quirc() -> Reader:
    import quirc  # pyright: ignore[reportMissingImports]  # an optional engine

    def read(image: Gray) -> tuple[bytes, ...]:
        return tuple(bytes(data.payload) for _, data in quirc.decode(image))

    return read


def _rxing() -> Reader:
    import rxing

    hints = {"POSSIBLE_FORMATS": ["QR_CODE"], "TRY_HARDER": True}

    def read(image: Gray) -> tuple[bytes, ...]:
        try:
            return (rxing.decode(image, hints).text.encode(),)
        except ValueError:  # its way of saying that no code was found
            return ()

    return read


def _through_node(script: str) -> Callable[[], Reader]:
    return lambda: node.reader(script)


# name -> (module that must be installed, None for an engine run by Node; constructor)
_ENGINES: dict[str, tuple[str | None, Callable[[], Reader]]] = {
    "zxing-cpp": ("zxingcpp", _zxing),
    "zbar": ("pyzbar", _zbar),
    "wechat": ("cv2", _wechat),
    "opencv": ("cv2", _opencv),
    "opencv-aruco": ("cv2", _opencv_aruco),
    "quirc": ("quirc", _quirc),
    "rxing": ("rxing", _rxing),
    "jsqr": (None, _through_node("jsqr")),
    "zbar-wasm": (None, _through_node("@undecaf/zbar-wasm")),
}
NAMES = tuple(_ENGINES)


def available() -> tuple[str, ...]:
    """Names of the engines that this machine can run, in the order of `NAMES`."""
    present = []
    for name, (module, _) in _ENGINES.items():
        if module is None:
            found = node.present("jsqr" if name == "jsqr" else "@undecaf/zbar-wasm")
        else:
            found = importlib.util.find_spec(module) is not None
        if found:
            present.append(name)
    return tuple(present)


def load(name: str) -> Reader:
    """The engine's reading function. KeyError if the name is not one of `NAMES`."""
    return _ENGINES[name][1]()


def accepted(payload: str | bytes) -> frozenset[bytes]:
    """The byte strings that count as reading `payload`.

    Engines return either the raw bytes of the symbol or its text in UTF-8. Bytes that are not UTF-8
    are ISO/IEC 8859-1 text (ISO/IEC 18004 §7.3.5, default interpretation).

    >>> accepted("ok") == {b"ok"}
    True
    >>> accepted("é") == {"é".encode(), "é".encode("latin-1")}
    True
    """
    raw = payload.encode() if isinstance(payload, str) else bytes(payload)
    try:
        text = raw.decode()
    except UnicodeDecodeError:
        return frozenset({raw, raw.decode("latin-1").encode()})
    if isinstance(payload, bytes):
        return frozenset({raw})
    with contextlib.suppress(UnicodeEncodeError):  # a text may have been written in either encoding
        return frozenset({raw, text.encode("latin-1")})
    return frozenset({raw})
