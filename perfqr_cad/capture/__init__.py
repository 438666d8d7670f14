"""From a picture of a QR code to its modules, its damage and its art.

`image` opens the file, `seeds` and `finders` guess a place, `register` and `warp` fit a grid,
`sampling` weighs the modules, `several` numbers the codes of one picture, `symbologies` names what is no QR
code, `art` tells the shapes. What modules mean is decided in `symbol`, not here.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from perfqr_cad.capture.capture import Art, Capture

if TYPE_CHECKING:
    from perfqr_cad.capture.image import load_image
    from perfqr_cad.capture.recognition import read

__all__ = ["Art", "Capture", "load_image", "read"]


def __getattr__(name: str) -> Any:
    """`read` and `load_image` bring OpenCV and Pillow with them, so they are imported on first use."""
    if name == "read":
        from perfqr_cad.capture.recognition import read

        return read
    if name == "load_image":
        from perfqr_cad.capture.image import load_image

        return load_image
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
