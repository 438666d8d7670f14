"""The picture's own shapes: the symbol seen straight on, and the grid on which its art was drawn.

Plain    Modules are squares. For each of the 16 colourings of 2 × 2 neighbours the mean picture of all
         places so coloured is compared with blurred squares: noise and waviness average out, rounded
         corners, gaps and dots do not.
Halftone Each module is k × k squares. Squares drawn from one sample each explain the picture far better
         than those of every smaller k that does not divide k, and hardly worse than finer ones.
Freeform Anything else, sampled finely.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from perfqr_cad.capture.capture import Art
from perfqr_cad.capture.grid import Floats, Grid, look_up
from perfqr_cad.capture.register import known_modules

Floats32 = NDArray[np.float32]

VIEW_SCALE = 12  # samples along a module: a multiple of 2, 3, 4 and 6
FREEFORM_SCALE = 12
HALFTONE_SCALES = (2, 3, 4, 5, 6)
BLURS = (0.03, 0.06, 0.1, 0.16, 0.24, 0.34)  # σ of the picture's edges in modules, to choose from
BLUR_MODULES = 14  # side of the corner that the blur is measured in: the first finder and the timing lines
BLUR_SHARES = (1.0, 0.7, 1.4)  # the art's edges may be softer or harder than those of the function patterns
PLAIN_RESIDUAL = (
    0.06  # of the art's energy, in mean neighbourhoods; plain photographs reach 0.05, styled codes 0.08
)
BLURRED_MODULES = 0.2  # a picture blurred by more does not show whether corners are round:
BLURRED_RESIDUAL = 0.13  # squares are assumed
HALFTONE_RESIDUAL = 0.25  # of the art's energy: above it no k × k grid explains the picture
HALFTONE_GAIN = 0.6  # a true k leaves at most this part of the residual of every smaller grid
LEAST_SEEN = 4  # places that a 2 × 2 colouring must have to be averaged


def rectify(image: NDArray[np.uint8], grid: Grid, module_px: int) -> NDArray[np.uint8]:
    """(n·px, n·px) the symbol seen straight on, without its quiet zone, at `module_px` a module."""
    return np.rint(_straight(image, grid, module_px)).astype(np.uint8)


def art_of(
    image: NDArray[np.uint8], grid: Grid, dark: NDArray[np.bool_], light_level: Floats, dark_level: Floats
) -> Art:
    """The art of a symbol whose modules are `dark` (n, n) and whose levels of light and dark are (n, n)."""
    shade = _shade(image, grid, light_level, dark_level)
    known, _ = known_modules(grid.size, "all")
    blur = _blur_of(shade, dark, known)
    limit = BLURRED_RESIDUAL if blur >= BLURRED_MODULES else PLAIN_RESIDUAL
    if min(_plain_residual(shade, dark, known, blur * share) for share in BLUR_SHARES) <= limit:
        return Art("plain", 1, dark)
    scale = _halftone_scale(shade, known, blur)
    if scale is not None:
        return Art("halftone", scale, _drawn(shade, scale))
    return Art("freeform", FREEFORM_SCALE, _drawn(shade, FREEFORM_SCALE))


def _straight(image: NDArray[np.uint8], grid: Grid, scale: int) -> Floats32:
    steps = (np.arange(grid.size * scale) + 0.5) / scale
    x, y = np.meshgrid(steps, steps)
    return look_up(image, grid.pixels(np.stack([x, y], axis=-1)))


def _shade(image: NDArray[np.uint8], grid: Grid, light_level: Floats, dark_level: Floats) -> Floats32:
    """(n·s, n·s) shades from −½, the level of light there, to +½, that of dark."""
    seen = _straight(image, grid, VIEW_SCALE)
    light, dark = (
        cv2.resize(level.astype(np.float32), seen.shape[::-1], interpolation=cv2.INTER_LINEAR)
        for level in (light_level, dark_level)
    )
    return np.clip(((light + dark) / 2 - seen) / np.maximum(light - dark, 1.0), -0.5, 0.5).astype(np.float32)


def _drawn(shade: Floats32, scale: int) -> NDArray[np.bool_]:
    """The art on `scale` × `scale` submodules, each by the shade in its middle."""
    if scale == VIEW_SCALE:
        return shade > 0
    size = shade.shape[0] // VIEW_SCALE
    steps = (np.arange(size * scale) + 0.5) * (VIEW_SCALE / scale) - 0.5
    x, y = np.meshgrid(steps, steps)
    return look_up(shade, np.stack([x, y], axis=-1)) > 0


def _squares(dark: NDArray[np.bool_], scale: int, blur: float) -> Floats32:
    """Shades of squares of 1/scale module, blurred as the picture is."""
    size = dark.shape[0] // scale
    at = ((np.arange(size * VIEW_SCALE) + 0.5) / VIEW_SCALE * scale).astype(np.intp)
    flat = np.where(dark[np.ix_(at, at)], 0.5, -0.5).astype(np.float32)
    return np.asarray(cv2.GaussianBlur(flat, (0, 0), blur * VIEW_SCALE), np.float32)


def _blur_of(shade: Floats32, dark: NDArray[np.bool_], known: NDArray[np.bool_]) -> float:
    """The blur that makes the function patterns look as they do in the picture."""
    part = slice(BLUR_MODULES), slice(BLUR_MODULES)
    side = BLUR_MODULES * VIEW_SCALE
    seen, dark, area = shade[:side, :side], dark[part], _enlarged(known[part])
    return min(BLURS, key=lambda blur: float(np.mean((seen - _squares(dark, 1, blur))[area] ** 2)))


def _enlarged(modules: NDArray[np.bool_]) -> NDArray[np.bool_]:
    return np.repeat(np.repeat(modules, VIEW_SCALE, axis=0), VIEW_SCALE, axis=1)


def _plain_residual(shade: Floats32, dark: NDArray[np.bool_], known: NDArray[np.bool_], blur: float) -> float:
    """Energy of the mean differences from blurred squares, by the colours of 2 × 2 neighbours."""
    free = ~known
    places = free[:-1, :-1] & free[:-1, 1:] & free[1:, :-1] & free[1:, 1:]
    colouring = dark[:-1, :-1] * 8 + dark[:-1, 1:] * 4 + dark[1:, :-1] * 2 + dark[1:, 1:]
    seen, ideal = _junctions(shade), _junctions(_squares(dark, 1, blur))
    difference = energy = 0.0
    for kind in range(16):
        chosen = places & (colouring == kind)
        count = int(np.count_nonzero(chosen))
        if count >= LEAST_SEEN:
            model = ideal[chosen].mean(axis=0)
            difference += count * float(np.sum((seen[chosen].mean(axis=0) - model) ** 2))
            energy += count * float(np.sum(model**2))
    return difference / max(energy, 1e-9)


def _junctions(shade: Floats32) -> Floats32:
    """(n − 1, n − 1, s, s) squares of one module about each point where four modules meet."""
    half, size = VIEW_SCALE // 2, shade.shape[0] // VIEW_SCALE
    inner = shade[half:-half, half:-half]
    return inner.reshape(size - 1, VIEW_SCALE, size - 1, VIEW_SCALE).transpose(0, 2, 1, 3)


def _halftone_scale(shade: Floats32, known: NDArray[np.bool_], blur: float) -> int | None:
    """The k of k × k submodules, or None when no grid explains the picture."""
    free = _enlarged(~known)
    energy = float(np.mean(shade[free] ** 2)) + 1e-9
    left = {
        scale: min(
            float(np.mean((shade - _squares(_drawn(shade, scale), scale, blur * share))[free] ** 2)) / energy
            for share in BLUR_SHARES
        )
        for scale in HALFTONE_SCALES
    }
    for scale, residual in left.items():
        smaller = [left[other] for other in HALFTONE_SCALES if other < scale]
        following = [left[other] for other in HALFTONE_SCALES if other == scale + 1]
        if residual <= HALFTONE_RESIDUAL and all(
            residual <= HALFTONE_GAIN * one for one in smaller + following
        ):
            return scale
    return None
