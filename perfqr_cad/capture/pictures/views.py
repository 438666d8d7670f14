"""Grey pictures in which a code may be easier to find or to sample than in the luminance; cheap first."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import cv2
import numpy as np
from numpy.typing import NDArray

from perfqr_cad.capture.grid import Floats, Grid, look_up
from perfqr_cad.capture.pictures.image import Picture, luminance
from perfqr_cad.capture.register import known_modules

SEARCH_SIDE_PX = 1000  # longest side of the pictures that finders are looked for in first
SMALL_SIDE_PX = 300  # below it the picture is enlarged: at 1-2 px a module no profile can be measured
CHROMA_SPREAD = 12.0  # standard deviation of a colour difference that makes colour worth a look
TILE_PX = 64  # tiles of the local equalisation


def is_colourful(picture: Picture) -> bool:
    """Whether the colours of a picture differ by more than a camera's noise and white balance."""
    if picture.ndim == 2:
        return False
    small = _thinned(picture)
    return max(float((small[..., k] - small[..., 1]).std()) for k in (0, 2)) >= CHROMA_SPREAD


def greys(picture: Picture) -> list[Picture]:
    """Luminance, then the channels of a colour picture, the most contrasting first."""
    grey = luminance(picture)
    if picture.ndim == 2:
        return [grey]
    small = _thinned(picture)
    channels = sorted(range(3), key=lambda k: -float(small[..., k].std()))
    return [grey, *(np.ascontiguousarray(picture[..., k]) for k in channels)]


def _thinned(picture: Picture) -> NDArray[np.float32]:
    return picture[:: max(1, picture.shape[0] // 256), :: max(1, picture.shape[1] // 256)].astype(np.float32)


def searched(grey: Picture) -> Iterator[tuple[str, Picture, Floats]]:
    """Name, picture to search and the (3, 3) map from its pixels to those of `grey`."""
    side = max(grey.shape)
    if side < SMALL_SIDE_PX:
        yield "enlarged", *_resized(grey, float(np.ceil(2 * SMALL_SIDE_PX / side)))
    if side > SEARCH_SIDE_PX:
        yield "reduced", *reduced(grey)
    for blur in (1.5, 3.0):
        yield f"blurred {blur:g}", _blurred(grey, blur), np.eye(3)
    yield "halved", *_resized(grey, 0.5)
    yield "equalised", np.asarray(cv2.createCLAHE(4.0, _tiles(grey)).apply(grey), np.uint8), np.eye(3)
    for blur in (5.0, 8.0):
        yield f"blurred {blur:g}", _blurred(grey, blur), np.eye(3)
    yield "quartered", *_resized(grey, 0.25)


def reduced(grey: Picture) -> tuple[Picture, Floats]:
    """A picture of at most `SEARCH_SIDE_PX` a side, and the (3, 3) map from its pixels to those of `grey`."""
    return _resized(grey, min(1.0, SEARCH_SIDE_PX / max(grey.shape)))


def _blurred(grey: Picture, sigma_px: float) -> Picture:
    return np.asarray(cv2.GaussianBlur(grey, (0, 0), sigma_px), np.uint8)


def _tiles(grey: Picture) -> tuple[int, int]:
    return max(1, grey.shape[1] // TILE_PX), max(1, grey.shape[0] // TILE_PX)


def _resized(grey: Picture, factor: float) -> tuple[Picture, Floats]:
    height, width = grey.shape
    size = (max(1, round(width * factor)), max(1, round(height * factor)))
    kind = cv2.INTER_AREA if factor < 1 else cv2.INTER_CUBIC
    sx, sy = width / size[0], height / size[1]
    back = np.array([[sx, 0, 0.5 * sx - 0.5], [0, sy, 0.5 * sy - 0.5], [0, 0, 1]])
    return np.asarray(cv2.resize(grey, size, interpolation=kind), np.uint8), back


def projections(picture: Picture, grid: Grid, inverted: bool) -> Iterator[tuple[str, Picture]]:
    """Pictures to sample a found code in, dark on light: its luminance, then its most telling colour.

    That is the mixture of channels that parts its function patterns best (Fisher's linear discriminant).
    """
    sign: Callable[[Picture], Picture] = (lambda grey: 255 - grey) if inverted else (lambda grey: grey)
    yield "luminance", sign(luminance(picture))
    if picture.ndim == 3:
        yield "discriminant", _discriminant(picture, grid)


def _discriminant(picture: Picture, grid: Grid) -> Picture:
    known, dark = known_modules(grid.size, "all")
    rows, columns = np.nonzero(known)
    colours = look_up(picture, grid.pixels(np.stack([columns + 0.5, rows + 0.5], axis=1))[None])[0].astype(
        np.float64
    )
    is_dark = dark[rows, columns]
    light_ones, dark_ones = colours[~is_dark], colours[is_dark]
    scatter = np.cov(light_ones.T) + np.cov(dark_ones.T) + 4.0 * np.eye(3)  # 2 grey levels of camera noise
    axis = np.linalg.solve(scatter, light_ones.mean(axis=0) - dark_ones.mean(axis=0))
    shade = picture.astype(np.float32) @ axis.astype(np.float32)
    low, high = np.percentile(colours @ axis, [2, 98])
    span = max(float(high - low), 1e-9)
    return np.clip((shade - (low - 0.3 * span)) * (255.0 / (1.6 * span)), 0, 255).astype(np.uint8)
