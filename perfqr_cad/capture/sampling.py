"""From grid to modules: the paper's Gaussian points, and a soft sampling with log-likelihoods.

Both look at the centre third of each module only, "the centre region that contains the correct
information" (paper §4.2 and Fig. 5): in a halftone code the rest of the module belongs to the picture.
"""

from __future__ import annotations

from dataclasses import dataclass
from statistics import NormalDist

import cv2
import numpy as np
from numpy.typing import NDArray

from perfqr_cad.capture.grid import Floats, Grid, look_up
from perfqr_cad.capture.register import known_modules

CENTRE = 1.0 / 3.0  # width of the centre region in modules (paper §4.2: l_c ≥ l_m / 3)
POINTS = 5  # sampling points along each axis
NEIGHBOURHOOD_MODULES = 3.0  # σ of the window in which the levels of dark and light are learned
PRIOR_WEIGHT = 0.15  # of the levels of the whole symbol against those of the neighbourhood
LEVEL_STEPS = 3  # alternations of classifying and averaging
NOISE_FLOOR = 0.12  # standard deviation of a module's value in units of the contrast, at the least
MAX_LOG_LIKELIHOOD = 12.0  # a chance of 6e-6 that a clear module lies: dirt, a logo


@dataclass(frozen=True, eq=False)
class ModuleSamples:
    """Values of the modules: `mean` (n, n) over the Gaussian points, `votes` (n, n, p) at each of them."""

    mean: NDArray[np.float64]
    votes: NDArray[np.float32]


def offsets() -> tuple[Floats, Floats]:
    """Sampling points (p, 2) about the centre of a module, in modules, and their weights (p,).

    One point for each of `POINTS` equal shares of a normal distribution that lies to 95 % inside the
    centre third, on both axes: the Gaussian points of Fig. 5, the same on every run.
    """
    normal = NormalDist(0.0, CENTRE / 4)
    axis = np.array([normal.inv_cdf((k + 0.5) / POINTS) for k in range(POINTS)])
    x, y = np.meshgrid(axis, axis)
    return np.stack([x.ravel(), y.ravel()], axis=1), np.full(POINTS * POINTS, 1.0 / POINTS**2)


def sample_modules(image: NDArray[np.uint8], grid: Grid) -> ModuleSamples:
    """The values of all modules of a grey image."""
    about, weights = offsets()
    column, row = np.meshgrid(np.arange(grid.size) + 0.5, np.arange(grid.size) + 0.5)
    points = np.stack([column, row], axis=-1).reshape(-1, 1, 2) + about
    votes = look_up(image, grid.pixels(points)).reshape(grid.size, grid.size, -1)
    return ModuleSamples((votes @ weights.astype(np.float32)).astype(np.float64), votes)


def global_threshold(image: NDArray[np.uint8]) -> float:
    """Middle between the means of the two classes into which Otsu's method parts a picture."""
    split, _ = cv2.threshold(image, 0, 255, cv2.THRESH_BINARY | cv2.THRESH_OTSU)
    count = np.bincount(image.ravel(), minlength=256)
    grey, below = np.arange(256), np.arange(256) <= split
    means = [
        float(np.dot(count[part], grey[part])) / max(int(count[part].sum()), 1) for part in (below, ~below)
    ]
    return sum(means) / 2


def vote_log_likelihood(samples: ModuleSamples, threshold: float) -> NDArray[np.float64]:
    """(n, n) ln(P(dark)/P(light)) from the share of dark Gaussian points, Laplace-smoothed."""
    count = samples.votes.shape[2]
    dark = np.count_nonzero(samples.votes < threshold, axis=2)
    return np.log((dark + 0.5) / (count - dark + 0.5))


def soft_log_likelihood(
    samples: ModuleSamples, light: NDArray[np.float64], dark: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(n, n) ln(P(dark)/P(light)): place between the levels of dark and light nearby, over the noise."""
    value = samples.mean
    contrast = np.maximum(light - dark, 1e-3)
    middle = (light + dark) / 2
    place = (middle - value) / contrast  # −½ on the level of light, +½ on that of dark
    noise = max(NOISE_FLOOR, float(np.std(np.abs(place) - 0.5)))
    return np.clip(place / noise**2, -MAX_LOG_LIKELIHOOD, MAX_LOG_LIKELIHOOD)


def levels(samples: ModuleSamples) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(n, n) levels of light and dark, from the function patterns and, step by step, all modules nearby."""
    value = samples.mean
    known, is_dark = known_modules(value.shape[0], "all")
    light = _plane(value, known & ~is_dark)
    dark = _plane(value, known & is_dark)
    for _ in range(LEVEL_STEPS):
        seems_dark = np.where(known, is_dark, value < (light + dark) / 2)
        light = _around(value, ~seems_dark, light)
        dark = _around(value, seems_dark, dark)
    return light, dark


def _plane(value: NDArray[np.float64], chosen: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Linear trend of the chosen modules over the whole symbol: lighting is seldom even."""
    rows, columns = np.nonzero(chosen)
    size = value.shape[0]
    base = np.stack([np.ones(len(rows)), rows / size - 0.5, columns / size - 0.5], axis=1)
    ridge = np.diag([0.0, 1.0, 1.0]) * len(rows) * 1e-3
    slope = np.linalg.solve(base.T @ base + ridge, base.T @ value[rows, columns])
    row, column = np.mgrid[:size, :size] / size - 0.5
    return slope[0] + slope[1] * row + slope[2] * column


def _around(
    value: NDArray[np.float64], chosen: NDArray[np.bool_], trend: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Mean of the chosen modules nearby, drawn towards the trend where there are few."""
    weight = cv2.GaussianBlur(chosen.astype(np.float64), (0, 0), NEIGHBOURHOOD_MODULES)
    excess = cv2.GaussianBlur(np.where(chosen, value - trend, 0.0), (0, 0), NEIGHBOURHOOD_MODULES)
    return trend + excess / (weight + PRIOR_WEIGHT)
