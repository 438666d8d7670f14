"""From a picture to a code. Guesses of its place come cheap ones first, to be fitted, sampled and corrected.

A guess becomes a capture only when its function patterns fit, every block is corrected within what the
standard allows, and the symbol so found agrees with what was seen. Decoders only lend their eyes: the
payload is always that of the modules sampled here, and must be theirs where they read one.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.capture.art import art_of, rectify
from perfqr_cad.capture.attempts import SEARCHED_PX, Effort, distinct, glimpses, seeds
from perfqr_cad.capture.capture import Capture, Sampling
from perfqr_cad.capture.grid import CORNERS, Floats, Grid
from perfqr_cad.capture.pictures.image import Picture, load_image, luminance
from perfqr_cad.capture.pictures.views import is_colourful, projections
from perfqr_cad.capture.register import Workspace, correlation, register, workspace
from perfqr_cad.capture.sampling import (
    global_threshold,
    levels,
    sample_modules,
    soft_log_likelihood,
    vote_log_likelihood,
)
from perfqr_cad.capture.seeds import Seed
from perfqr_cad.capture.several import choice, in_reading_order, overlap
from perfqr_cad.capture.symbologies import other_code
from perfqr_cad.capture.warp import bent
from perfqr_cad.errors import CaptureError, SymbolError
from perfqr_cad.symbol import Matrix, Recovery, format_candidates, layout, recover, size_of

RECTIFIED_MODULE_PX = 12
LEAST_LIKENESS = 0.25  # the same of the finders alone, before the grid is fitted
LEAST_FIT = 0.35  # correlation with the function patterns; noise and text stay below 0.3
FLAT_FIT = 0.93  # a page that fits so well flat, and is read so, is not bent
GOOD_FIT = 0.6  # from here on a failure says that the code is damaged, not that there is none
SIZES_TRIED = 3  # of those that fit best, for a seed that does not know its size
CORRECTIONS_TRIED = 8  # with SEEDS_TRIED it bounds the time spent on a picture without a readable code
LEAST_AGREEMENT = 0.6  # of the modules with the corrected symbol; by chance it is 0.5 ± 0.02
FORMAT_UNREADABLE = 15  # all bits of the format information


@dataclass(frozen=True, eq=False)
class _Found:
    """A grid whose modules were corrected to a symbol."""

    picture: Picture
    grid: Grid
    light: NDArray[np.float64]
    dark: NDArray[np.float64]
    log_likelihood: NDArray[np.float64]
    recovery: Recovery
    engine: str
    inverted: bool


def read(
    source: str | Path | bytes | NDArray[Any],
    which: int | None = None,
    *,
    sampling: Sampling = "soft",
    rectified_module_px: int = RECTIFIED_MODULE_PX,
) -> Capture:
    """The QR code in a picture.

    source    what `load_image` takes
    which     of several codes in the picture, from 1 in reading order: by rows from the top, from the left
    sampling  "soft": shades against the levels of dark and light nearby; "gaussian": the majority of the
              paper's Gaussian points in the picture binarised by one threshold (§4.2)

    CaptureError says whether no code was found, one that is damaged beyond its capacity, or several of which
    none was chosen.

    >>> import numpy as np
    >>> from perfqr_cad.symbol import encode
    >>> light = ~np.pad(encode("HELLO").matrix.dark, 4)
    >>> capture = read(np.kron(light, np.ones((6, 6), bool)))
    >>> capture.recovery.payload.text, capture.art.kind
    ('HELLO', 'plain')
    """
    picture = _without_idle_colour(load_image(source))
    name = Path(source).name if isinstance(source, str | Path) else "the picture"
    first = _first(picture, name, sampling)
    codes = in_reading_order([first, *_others(picture, first, sampling)], lambda one: one.grid.corners)
    number = choice([one.recovery.payload for one in codes], which, name)
    return _capture(codes[number - 1], rectified_module_px)


def _first(picture: Picture, name: str, sampling: Sampling) -> _Found:
    """The code that is found with the least effort."""
    damage: tuple[float, str] = (0.0, "")
    tries, effort = 0, Effort()
    for view, seed in distinct(seeds(picture, effort)):
        for space, grid, fit in _registered(view, seed):
            tries += 1
            if tries > CORRECTIONS_TRIED:
                raise CaptureError(_failure(name, picture, effort, *damage))
            try:
                return _corrected(picture, space, grid, fit, seed, sampling)
            except SymbolError as failure:
                damage = max(damage, (abs(fit), str(failure)))
    raise CaptureError(_failure(name, picture, effort, *damage))


def _others(picture: Picture, first: _Found, sampling: Sampling) -> list[_Found]:
    """The readable codes beside the first, as far as a quick look shows them."""
    codes = [first]
    grey = luminance(picture)
    for seed in glimpses(grey):
        if _is_on(codes, seed.outline):
            continue
        for space, grid, fit in _registered(grey, seed):
            if abs(fit) < GOOD_FIT or _is_on(codes, grid.corners):
                continue
            try:
                found = _corrected(picture, space, grid, fit, seed, sampling)
            except SymbolError:  # what cannot be read is none to choose
                continue
            codes.append(found)
            break
    return codes[1:]


def _is_on(codes: list[_Found], corners: Floats) -> bool:
    return any(overlap(one.grid.corners, corners) for one in codes)


def _without_idle_colour(picture: Picture) -> Picture:
    return picture if is_colourful(picture) else luminance(picture)


def _registered(grey: Picture, seed: Seed) -> Iterator[tuple[Workspace, Grid, float]]:
    """The grids that a seed leads to, fitted to the picture, best first."""
    starts = _starts(grey, seed)
    fitted = [(space, *register(space, grid)) for space, grid in starts]
    for space, grid, fit in sorted(fitted, key=lambda one: -abs(one[2])):
        if abs(fit) >= LEAST_FIT:
            yield space, grid, fit


def _starts(grey: Picture, seed: Seed) -> list[tuple[Workspace, Grid]]:
    """Grids to begin with: of the given size, or of those whose finders look most like the picture."""
    sizes = seed.sizes or tuple(size_of(version) for version in range(1, 41))
    turns = range(1 if seed.oriented else 4)
    grids = [
        Grid.from_corners(size, np.roll(seed.corners(size), -k, axis=0)) for size in sizes for k in turns
    ]
    grids = [grid for grid in grids if grid.module_px > 0]
    if len(grids) <= 1:
        return [(workspace(grey, grid), grid) for grid in grids]
    middle = sorted(grids, key=lambda grid: grid.size)[len(grids) // 2]
    space = workspace(grey, middle)
    likeness = {id(grid): abs(correlation(space, grid, "finders")) for grid in grids}
    grids = sorted(
        (one for one in grids if likeness[id(one)] >= LEAST_LIKENESS), key=lambda one: -likeness[id(one)]
    )
    return [(workspace(grey, grid), grid) for grid in grids[:SIZES_TRIED]]


def _corrected(
    picture: Picture, space: Workspace, grid: Grid, fit: float, seed: Seed, sampling: Sampling
) -> _Found:
    """The symbol on this grid, on a bent one, or in another colour; else SymbolError of the first try."""
    first: SymbolError | None = None
    best: _Found | None = None
    for candidate in _shapes(space, grid, seed):
        for _, shade in projections(picture, candidate, fit < 0):
            try:
                found = _recovered(shade, candidate, seed, sampling, fit < 0)
            except SymbolError as failure:
                first = first or failure
                continue
            if best is None or sum(found.recovery.errors) < sum(best.recovery.errors):
                best = found
            break
        if best is not None and (abs(fit) >= FLAT_FIT or not any(best.recovery.errors)):
            return best
    if best is None:
        raise first or SymbolError("no grid could be laid over the code")
    return best


def _shapes(space: Workspace, grid: Grid, seed: Seed) -> Iterator[Grid]:
    """The flat grid, then grids bent as the page may be."""
    yield grid
    yield bent(space, grid)
    if len(seed.places) == 3:
        yield bent(space, Grid.from_corners(grid.size, seed.corners(grid.size)))


def _recovered(shade: Picture, grid: Grid, seed: Seed, sampling: Sampling, inverted: bool) -> _Found:
    """Sampled and corrected, as it is or as in a mirror."""
    samples = sample_modules(shade, grid)
    light, dark = levels(samples)
    if sampling == "soft":
        likely = soft_log_likelihood(samples, light, dark)
    else:
        likely = vote_log_likelihood(samples, global_threshold(shade))
    if _format_distance(likely.T) < _format_distance(likely):
        grid, light, dark, likely = _transposed(grid), light.T, dark.T, likely.T
    return _Found(shade, grid, light, dark, likely, _trusted(likely, seed), seed.engine, inverted)


def _format_distance(likely: NDArray[np.float64]) -> int:
    """Wrong bits in the better copy of the format information."""
    try:
        return min(min(one.distances) for one in format_candidates(Matrix.from_array(likely > 0)))
    except SymbolError:
        return FORMAT_UNREADABLE


def _trusted(likely: NDArray[np.float64], seed: Seed) -> Recovery:
    """The recovery, unless it contradicts what was seen or what the decoder read."""
    recovery = recover(Matrix.from_array(likely > 0), log_likelihood=likely)
    placed = layout(recovery.observed.version, recovery.symbol.level).codeword_of >= 0
    same = recovery.observed.dark[placed] == recovery.symbol.matrix.dark[placed]
    if same.mean() < LEAST_AGREEMENT:
        raise SymbolError(
            f"corrected to a symbol that only {same.mean():.0%} of the modules agree with, at least "
            f"{LEAST_AGREEMENT:.0%} must: take a clearer picture"
        )
    if any(recovery.erasures) and seed.payload is not None and seed.payload != recovery.payload.data:
        raise SymbolError(f"read otherwise than by {seed.engine}, after erasures: take a clearer picture")
    return recovery


def _transposed(grid: Grid) -> Grid:
    """The grid of the mirrored symbol: rows and columns change places."""
    swap = np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, 1]])
    return replace(grid, homography=grid.homography @ swap, warp=grid.warp.transpose(1, 0, 2)[..., ::-1])


def _capture(found: _Found, module_px: int) -> Capture:
    likely = found.log_likelihood
    return Capture(
        matrix=found.recovery.observed,
        log_likelihood=likely,
        recovery=found.recovery,
        art=art_of(found.picture, found.grid, likely > 0, found.light, found.dark),
        rectified=rectify(found.picture, found.grid, module_px),
        homography=np.asarray(found.grid.homography, np.float64),
        warp=np.asarray(found.grid.warp, np.float64),
        confidence=1.0 / (1.0 + np.exp(-np.abs(likely))),
        engine=found.engine,
        inverted=found.inverted,
        mirrored=_is_mirrored(found.grid),
    )


def _is_mirrored(grid: Grid) -> bool:
    a, b, c, _ = grid.pixels(CORNERS * grid.size)
    return bool(np.linalg.det(np.stack([b - a, c - a])) < 0)


def _failure(name: str, picture: Picture, effort: Effort, fit: float, damage: str) -> str:
    other = None if effort.is_cut_short else other_code(picture, lookalikes=fit >= GOOD_FIT)
    if other is not None:
        return f"{name} holds no QR code but {other}; make a QR code (Model 2) of its text"
    if fit >= GOOD_FIT:
        return f"the code in {name} cannot be read: {damage}"
    height, width = picture.shape[:2]
    if effort.is_cut_short:
        return (
            f"no QR code found in {name} ({width} × {height} pixels) within the {SEARCHED_PX / 1e6:g} "
            "megapixels that a search looks at: crop the picture to the code and its quiet zone"
        )
    return (
        f"no QR code found in {name} ({width} × {height} pixels): take a sharper, straighter or larger "
        "picture with all three finder patterns in it"
    )
