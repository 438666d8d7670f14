"""From a picture to a code: seeds, grid, samples, correction; the cheap ways first."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.capture.art import art_of, rectify
from perfqr_cad.capture.grid import Grid
from perfqr_cad.capture.image import load_image, luminance
from perfqr_cad.capture.model import Capture, Sampling
from perfqr_cad.capture.register import correlation, register, turned, workspace
from perfqr_cad.capture.sampling import global_threshold, levels, sample, soft_log_likelihood, vote_log_likelihood
from perfqr_cad.capture.seeds import Seed, opencv_seeds, wechat_seeds, zxing_seeds
from perfqr_cad.errors import CaptureError, SymbolError
from perfqr_cad.symbol import Matrix, recover, size_of


def read(source: str | Path | bytes | NDArray[Any], *, sampling: Sampling = "soft") -> Capture:
    """The QR code in a picture. CaptureError when there is none, or none that can be corrected."""
    picture = load_image(source)
    grey = luminance(picture)
    last = None
    for seed in _seeds(grey):
        for grid, fit in _grids(grey, seed):
            try:
                return _capture(grey, grid, fit, seed.engine, sampling)
            except SymbolError as e:
                last = e
    if last:
        raise CaptureError(f"the code in {_name(source)} is {last}") from last
    height, width = grey.shape
    raise CaptureError(
        f"no QR code found in {_name(source)} ({width} × {height} pixels): take a sharper, straighter or larger "
        "picture with all three finder patterns in it"
    )


def _name(source: str | Path | bytes | NDArray[Any]) -> str:
    return Path(source).name if isinstance(source, str | Path) else "the picture"


def _seeds(grey: NDArray[np.uint8]) -> Iterator[Seed]:
    yield from zxing_seeds(grey)
    yield from wechat_seeds(grey)
    yield from opencv_seeds(grey)


def _grids(grey: NDArray[np.uint8], seed: Seed) -> Iterator[tuple[Grid, float]]:
    sizes = seed.sizes or tuple(size_of(v) for v in range(1, 41))
    ranked = []
    for size in sizes:
        grid = Grid.from_corners(size, seed.corners)
        if grid.module_px == 0:
            continue
        space = workspace(grey, grid)
        for quarter in range(1 if seed.oriented else 4):
            for mirrored in (False, True):
                t = turned(grid, quarter, mirrored)
                ranked.append((abs(correlation(space, t)), t, space))
    ranked.sort(key=lambda one: -one[0])
    for _, grid, space in ranked[:4]:
        yield register(space, grid)


def _capture(grey, grid: Grid, fit: float, engine: str, sampling: Sampling) -> Capture:
    inverted = fit < 0
    image = 255 - grey if inverted else grey
    samples = sample(image, grid)
    light, dark = levels(samples)
    soft = soft_log_likelihood(samples, light, dark) if sampling == "soft" else vote_log_likelihood(samples, global_threshold(image))
    recovery = recover(Matrix.from_array(soft > 0), log_likelihood=soft)
    art = art_of(image, grid, soft > 0, light, dark)
    return Capture(
        matrix=recovery.observed,
        log_likelihood=soft,
        recovery=recovery,
        art=art,
        rectified=rectify(image, grid, 12),
        homography=grid.homography,
        warp=grid.warp,
        confidence=1 / (1 + np.exp(-np.abs(soft))),
        engine=engine,
        inverted=inverted,
        mirrored=np.linalg.det(grid.homography) < 0,
    )
