"""Between the art as given and the plain code: modules get their own colour from the middle outwards."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from perfqr_cad.capture.capture import Art
from perfqr_cad.symbol import Symbol


def clearer(art: Art, symbol: Symbol, share: float) -> Art:
    """The art with a disc about the centre of every module in the module's own colour.

    share   radius of the disc over the distance of a module's corner from its centre: 0 leaves the art as it
            is, 1 gives the plain code

    >>> from perfqr_cad.symbol import encode
    >>> symbol = encode("HELLO")
    >>> blank = Art("halftone", 3, np.zeros((3 * symbol.size,) * 2, bool))
    >>> discs = [clearer(blank, symbol, share).dark for share in (0, 0.5, 1)]
    >>> [int(disc.sum()) // int(symbol.matrix.dark.sum()) for disc in discs]
    [0, 5, 9]
    """
    if share <= 0:
        return art
    steps = (np.arange(art.scale) - (art.scale - 1) / 2) / art.scale
    inside = np.hypot(steps, steps[:, None]) <= share * np.sqrt(0.5) + 1e-9
    n = symbol.size
    own = np.kron(symbol.matrix.dark, np.ones((art.scale, art.scale), bool))
    dark = np.where(np.tile(inside, (n, n)), own, art.dark)
    return replace(art, dark=dark)
