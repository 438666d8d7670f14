"""First guesses of where a code lies, by decoders that know how to look for one and by our own search."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import cv2
import numpy as np
import zxingcpp
from numpy.typing import NDArray

from perfqr_cad.capture.finders import triples
from perfqr_cad.capture.grid import Floats, project
from perfqr_cad.capture.image import Picture
from perfqr_cad.capture.views import greys, reduced, searched
from perfqr_cad.symbol import size_of

SEEDS_TRIED = 150  # bounds the time spent on a picture without a readable code
SAME_PLACE = 0.12  # of a symbol's side: seeds nearer than this are one
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


def seeds_in(picture: Picture) -> Iterator[tuple[Picture, Seed]]:
    """Guesses by decoders and by our own search, each with the grey view that shows it; cheapest first."""
    views = greys(picture)
    for decoder in (zxing_seeds, _finder_seeds, wechat_seeds, opencv_seeds):
        yield from ((views[0], seed) for seed in decoder(views[0]))
    for view in views[1:]:
        for decoder in (zxing_seeds, _finder_seeds):
            yield from ((view, seed) for seed in decoder(view))
    for view in views:
        for name, image, back in searched(view):
            for decoder in (zxing_seeds, _finder_seeds):
                for seed in decoder(image):
                    engine, places = f"{seed.engine}, {name}", project(back, seed.places)
                    yield view, replace(seed, engine=engine, places=places)


def glimpses(grey: Picture) -> Iterator[Seed]:
    """Guesses that cost little in a picture of any size."""
    yield from zxing_seeds(grey)
    small, back = reduced(grey)
    for decoder in (wechat_seeds, _finder_seeds):
        for seed in decoder(small):
            yield replace(seed, places=project(back, seed.places))


def distinct(guesses: Iterator[tuple[Picture, Seed]]) -> Iterator[tuple[Picture, Seed]]:
    """Seeds that are not where another of their view was already, `SEEDS_TRIED` of them at the most."""
    seen: list[tuple[int, Floats]] = []
    for view, seed in guesses:
        place = np.append(seed.places.mean(axis=0), np.ptp(seed.places, axis=0))
        near = SAME_PLACE * float(place[2:].max())
        kind = id(view) + len(seed.places)
        if any(kind == other and np.abs(place - old).max() < near for other, old in seen):
            continue
        seen.append((kind, place))
        yield view, seed
        if len(seen) >= SEEDS_TRIED:
            return


def _finder_seeds(image: Picture) -> Iterator[Seed]:
    for triple in triples(image):
        yield Seed("finders", triple.centres, triple.sizes, None, True)


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
