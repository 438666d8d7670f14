"""First guesses of where a code lies, from decoders that know how to look for one."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.capture.engines import Sighting, look
from perfqr_cad.capture.grid import Floats


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


def _seeds_of(engine: str, image: NDArray[np.uint8]) -> Iterator[Seed]:
    """What a decoder finds in a grey picture (H, W)."""
    for sighting in (Sighting(**fields) for fields in look(engine, image)):
        payload = None if sighting.payload_hex is None else bytes.fromhex(sighting.payload_hex)
        places = np.array(sighting.places, np.float64)
        yield Seed(engine, places, tuple(sighting.sizes), payload, sighting.oriented)


zxing_seeds = partial(_seeds_of, "zxing-cpp")  # codes that it could not decode included
wechat_seeds = partial(_seeds_of, "wechat")
opencv_seeds = partial(_seeds_of, "opencv")
