"""Codes that are no QR code (Model 2), so that a picture of one can be told what it shows."""

from __future__ import annotations

from perfqr_cad.capture.engines import MODEL_1, look
from perfqr_cad.capture.pictures.image import Picture
from perfqr_cad.capture.pictures.views import greys, searched
from perfqr_cad.capture.several import shortened

_QR = ("QR Code", "QR Code Model 2")  # what zxing-cpp calls the codes that are read here
_AN = ("A", "E", "I", "r")  # Aztec, EAN-13, ISBN, rMQR


def other_code(picture: Picture, *, lookalikes: bool = False) -> str | None:
    """What code of another kind the picture shows, and its beginning; None when none is read.

    lookalikes  only of a kind that has the function patterns of a QR code: Model 1

    >>> import numpy as np
    >>> other_code(np.full((60, 60), 255, np.uint8)) is None
    True
    """
    for grey in greys(picture):
        for view in (grey, *(image for _, image, _ in searched(grey))):
            for kind, text in look("other", view):
                if kind not in _QR and (kind == MODEL_1 or not lookalikes):
                    article = "an" if kind.startswith(_AN) else "a"
                    return f"{article} {kind.replace(' Code', ' code')}: {shortened(text)}"
    return None
