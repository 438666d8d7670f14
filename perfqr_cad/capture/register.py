"""Fits the grid to the function patterns of the picture: inverse compositional Lucas-Kanade.

The template is what ISO/IEC 18004 §6.3 fixes before any data is known: finders, separators, timing,
alignment patterns and version information. Baker and Matthews,
"Lucas-Kanade 20 Years On", IJCV 56 (2004), §3.2.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from perfqr_cad.capture.grid import Floats, Grid, look_up
from perfqr_cad.symbol import Role, layout

SPACING = 3  # template samples along a module
WORK_MODULE_PX = 6.0  # pixels a module in the working copy of the picture
MARGIN_MODULES = 4.0  # of the working copy around the symbol
# Of the fit, coarse to fine: known modules, blur in modules, iterations.
STAGES = (("finders", 1.0, 8), ("all", 0.8, 8), ("all", 0.5, 6))
CONVERGED = 2e-4  # step in units of half a symbol
NORMALISE_MODULES = 7  # window in which brightness and contrast are evened out: a finder
CONTRAST_FLOOR = 0.3  # of the whole symbol's contrast: below it a window is not amplified further


@dataclass(frozen=True, eq=False)
class FunctionTemplate:
    """Known modules sampled: points (m, 2) in modules, values (m,) −1 dark to +1 light, jacobian (m, 8)."""

    points: NDArray[np.float64]
    values: NDArray[np.float64]
    jacobian: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Workspace:
    """A copy of the part of the picture around a grid, at `WORK_MODULE_PX` a module.

    image, smooth (h, w) float32, the second blurred as the template of the last stage is
    transform (3, 3) from pixels of the picture to pixels of the copy
    """

    image: NDArray[np.float32]
    smooth: NDArray[np.float32]
    transform: Floats


def workspace(picture: NDArray[np.uint8], grid: Grid) -> Workspace:
    """The neighbourhood of the grid, resampled and evened out."""
    scale = min(WORK_MODULE_PX / max(grid.module_px, 1e-6), 8.0)
    margin = MARGIN_MODULES * grid.module_px
    height, width = picture.shape[:2]
    low = np.floor(np.clip(grid.corners.min(axis=0) - margin, 0, [width - 1, height - 1])).astype(int)
    high = np.ceil(np.clip(grid.corners.max(axis=0) + margin, 1, [width, height])).astype(int)
    crop = picture[low[1] : max(high[1], low[1] + 1), low[0] : max(high[0], low[0] + 1)]
    size = (max(1, round(crop.shape[1] * scale)), max(1, round(crop.shape[0] * scale)))
    resized = cv2.resize(crop, size, interpolation=cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR)
    sx, sy = size[0] / crop.shape[1], size[1] / crop.shape[0]
    # cv2.resize keeps the outer edges of the picture: x' + 0.5 = (x − low + 0.5) · s
    transform = np.array([[sx, 0, (0.5 - low[0]) * sx - 0.5], [0, sy, (0.5 - low[1]) * sy - 0.5], [0, 0, 1]])
    image = _evened(resized.astype(np.float32))
    return Workspace(image, _blurred(image, STAGES[-1][1]), transform)


def _blurred(image: NDArray[np.float32], modules: float) -> NDArray[np.float32]:
    return np.asarray(cv2.GaussianBlur(image, (0, 0), modules * WORK_MODULE_PX / 2), np.float32)


def _evened(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """Local mean 0 and local contrast 1, so that shade and glare do not outweigh the patterns."""
    side = int(NORMALISE_MODULES * WORK_MODULE_PX) | 1
    mean = cv2.blur(image, (side, side))
    spread = np.sqrt(np.maximum(cv2.blur(image * image, (side, side)) - mean * mean, 0.0))
    floor = CONTRAST_FLOOR * float(image.std()) + 1e-3
    return np.asarray(np.clip((image - mean) / np.maximum(spread, floor), -2.5, 2.5), np.float32)


def register(space: Workspace, grid: Grid) -> tuple[Grid, float]:
    """The flat grid, in the picture's pixels, that fits the function patterns best, and how well it does.

    The second value is the correlation in −1..1; it is negative for an inverted code.
    """
    inside = grid.moved(space.transform)
    # An inverted code fits as well when the picture is taken as its negative.
    sign = -1.0 if correlation(space, grid) < 0 else 1.0
    for modules, blur, iterations in STAGES:
        image = _blurred(space.image, blur)
        inside = _descend(image * np.float32(sign), inside, template(grid.size, modules, blur), iterations)
    back = inside.moved(np.linalg.inv(space.transform))
    return back, correlation(space, back)


def correlation(space: Workspace, grid: Grid, modules: str = "all") -> float:
    """Correlation of the picture with the function patterns of the grid, −1..1."""
    if grid.module_px == 0:
        return 0.0
    known = template(grid.size, modules, STAGES[-1][1])
    seen = look_up(space.smooth, grid.moved(space.transform).pixels(known.points)[None])[0]
    return _normalised_product(seen, known.values)


def _normalised_product(a: Floats, b: Floats) -> float:
    a, b = a - a.mean(), b - b.mean()
    scale = float(np.sqrt(np.dot(a, a) * np.dot(b, b)))
    return float(np.dot(a, b)) / scale if scale > 0 else 0.0


def _descend(image: NDArray[np.float32], grid: Grid, known: FunctionTemplate, iterations: int) -> Grid:
    """Gauss-Newton on the eight parameters of the homography; brightness and contrast are fitted too."""
    unit = _unit_square(grid.size)
    weights = np.linalg.pinv(known.jacobian.T @ known.jacobian + 1e-6 * np.eye(8)) @ known.jacobian.T
    for _ in range(iterations):
        seen = look_up(image, grid.pixels(known.points)[None])[0].astype(np.float64)
        contrast = np.dot(seen - seen.mean(), known.values - known.values.mean()) / max(
            seen.var() * seen.size, 1e-9
        )
        if contrast <= 0:
            break
        residual = contrast * (seen - seen.mean()) + known.values.mean() - known.values
        step = weights @ residual
        step *= min(1.0, 0.25 / float(np.abs(step).max() + 1e-12))
        change = np.eye(3) + np.append(step, 0.0).reshape(3, 3)
        moved = grid.moved(np.eye(3))
        homography = grid.homography @ np.linalg.inv(unit) @ np.linalg.inv(change) @ unit
        grid = Grid(moved.size, homography / homography[2, 2], moved.warp)
        if np.abs(step).max() < CONVERGED:
            break
    return grid


def _unit_square(size: int) -> Floats:
    """(3, 3) map of module coordinates to −1..1, which conditions the fit."""
    return np.array([[2.0 / size, 0, -1], [0, 2.0 / size, -1], [0, 0, 1]])


@lru_cache(maxsize=64)
def template(size: int, modules: str, blur: float) -> FunctionTemplate:
    """The known modules of an n × n symbol ("all", or "finders" with their separators), blurred."""
    mask, dark = known_modules(size, modules)
    pad = 4
    colour = np.where(mask, np.where(dark, -1.0, 1.0), 0.0)
    # The quiet zone is light by standard, yet often missing: it counts as unknown.
    fine = np.kron(np.pad(colour, pad), np.ones((SPACING, SPACING))).astype(np.float32)
    smooth = cv2.GaussianBlur(fine, (0, 0), blur * SPACING / 2)
    down, right = np.gradient(smooth)
    rows, columns = np.nonzero(np.kron(np.pad(mask, pad), np.ones((SPACING, SPACING))))
    points = np.stack([columns + 0.5, rows + 0.5], axis=1) / SPACING - pad
    unit = points * (2.0 / size) - 1.0
    slope = np.stack([right[rows, columns], down[rows, columns]], axis=1) * (SPACING * size / 2.0)
    return FunctionTemplate(points, smooth[rows, columns].astype(np.float64), _jacobian(unit, slope))


def _jacobian(unit: Floats, slope: Floats) -> NDArray[np.float64]:
    """(m, 8) change of the template under I + [[a, b, c], [d, e, f], [g, h, 0]] at the identity."""
    x, y, one = unit[:, 0], unit[:, 1], np.ones(len(unit))
    gx, gy = slope[:, 0], slope[:, 1]
    radial = gx * x + gy * y
    return np.stack([gx * x, gx * y, gx * one, gy * x, gy * y, gy * one, -radial * x, -radial * y], axis=1)


@lru_cache(maxsize=64)
def known_modules(size: int, modules: str) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """(n, n) which modules have a colour fixed by the version alone, and which of them are dark."""
    at = layout((size - 17) // 4, "L")
    roles = {
        "finders": (Role.FINDER, Role.SEPARATOR),
        "all": (Role.FINDER, Role.SEPARATOR, Role.TIMING, Role.ALIGNMENT, Role.VERSION, Role.DARK),
    }[modules]
    return np.isin(at.roles, roles), at.function_dark
