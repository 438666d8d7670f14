"""How a reader sees the modules of a pattern: sampled matrix, and the chance that each module is misread.

Hard sampling is the paper's (§4.2): Gaussian points over the centre third of a module, majority wins.
The soft loss adds what a camera adds: the picture is blurred, noisy and cut at a threshold that is a
little off, so a module whose blurred brightness is near one half may go either way.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.pattern.cells.lattice import Cells, Lattice
from perfqr_cad.symbol import Symbol, layout

Field = NDArray[np.float64]

CENTRE_PART = 1 / 3  # §4.2: the part of a module's width that a reader samples
SAMPLE_SIGMA = 1 / 6  # of a module: the spread of sampling points (Chu et al., Halftone QR Codes, §4)
# Measured (bench/margin.py): with these two the margin tells in 92 % of 540 views of damaged codes, at 4 to 9
# pixels a module, whether zxing-cpp reads them; 85 % with 0.20 and 0.15. docs/pattern.md has the table.
BLUR_SIGMA = 0.12  # of a module
NOISE_SIGMA = 0.12  # of the contrast: pixel noise and the threshold's own error together
REACH = 1.5  # modules: beyond five sigmas of blur nothing arrives


@lru_cache(maxsize=32)
def sample_weights(per_module: int) -> Field:
    """(u,) weights of the cells along a module's edge: a Gaussian cut off outside the centre third, sum 1."""
    edges = np.arange(per_module + 1) / per_module - 0.5
    kept = np.clip(edges, -CENTRE_PART / 2, CENTRE_PART / 2)
    mass = np.array([math.erf(e / SAMPLE_SIGMA / math.sqrt(2)) for e in kept])
    weights = np.diff(mass)
    weights /= weights.sum()
    weights.setflags(write=False)
    return weights


def sampled_part(per_module: int) -> slice:
    """The cells along a module's edge that are sampled at all."""
    used = np.flatnonzero(sample_weights(per_module))
    return slice(int(used[0]), int(used[-1]) + 1)


@lru_cache(maxsize=8)
def blur_weights(modules: int, quiet: int, per_module: int, sigma: float = BLUR_SIGMA) -> Any:
    """(modules, cells) sparse weights with which each cell along an axis reaches each module's centre.

    The cells are those of the whole code: blur reaches into the quiet zone.
    """
    from scipy.sparse import csr_array

    reach = math.ceil(REACH * per_module)
    cells = (modules + 2 * quiet) * per_module
    middle = (np.arange(modules) + quiet) * per_module + per_module // 2
    offset = np.arange(-reach, reach + 1)
    mass = _erf(offset / per_module / (sigma * math.sqrt(2))) / 2
    at = (middle[:, None] + offset[:-1]).ravel()
    rows, weights = np.repeat(np.arange(modules), 2 * reach), np.tile(np.diff(mass), modules)
    inside = (at >= 0) & (at < cells)
    return csr_array((weights[inside], (rows[inside], at[inside])), shape=(modules, cells))


def solid_part(lattice: Lattice) -> Field:
    """(n, n) solid part of each module's sampled centre, 0 to 1."""
    return sampled(lattice.symbol_cells(), lattice.per_module)


def sampled(cells: Cells, per_module: int) -> Field:
    """(rows, columns) weighted solid part of the centre of each module of a block of whole modules."""
    weights = sample_weights(per_module)
    part = sampled_part(per_module)
    rows, columns = cells.shape[0] // per_module, cells.shape[1] // per_module
    centres = cells.reshape(rows, per_module, columns, per_module)[:, part, :, part]
    return np.einsum("ruc,u->rc", centres @ weights[part], weights[part])


def blurred(lattice: Lattice, sigma: float = BLUR_SIGMA) -> Field:
    """(n, n) solid part that a blurred picture shows at each module's centre."""
    weights = blur_weights(lattice.modules, lattice.quiet, lattice.per_module, sigma)
    return (weights @ (weights @ lattice.solid).T).T


def module_misread_chance(contrast: Field, sigma: float = NOISE_SIGMA) -> Field:
    """Chance that a module is misread whose blurred brightness is `contrast` above one half the right way."""
    return 0.5 * (1 - _erf(contrast / (sigma * math.sqrt(2))))


def right_contrast(lattice: Lattice, symbol: Symbol, solid_is_dark: bool, blur: float = BLUR_SIGMA) -> Field:
    """(n, n) blurred brightness beyond one half in the direction that Q₀ asks for; negative reads wrong."""
    towards_solid = blurred(lattice, blur) - 0.5
    return np.where(symbol.matrix.dark == solid_is_dark, towards_solid, -towards_solid)


def margin_left(
    lattice: Lattice,
    symbol: Symbol,
    solid_is_dark: bool = False,
    blur: float = BLUR_SIGMA,
    noise: float = NOISE_SIGMA,
) -> float:
    """Least over the blocks of (capacity − expected erroneous codewords) / capacity; below 0: unreadable."""
    plan = layout(symbol.version, symbol.level)
    right = 1 - module_misread_chance(right_contrast(lattice, symbol, solid_is_dark, blur), noise)
    modules = plan.modules
    wrong = 1 - right[modules[..., 0], modules[..., 1]].prod(axis=1)
    expected = np.bincount(plan.block_of_codeword, weights=wrong, minlength=plan.blocks.count)
    return float(1 - expected.max() / plan.blocks.capacity)


def _erf(x: Field) -> Field:
    from scipy.special import erf

    return np.asarray(erf(x), np.float64)
