"""The decoding margin against a decoder: how many codewords zxing-cpp had to correct, and what was predicted.

Codes with bars painted at random into their modules are seen through blur, noise and a threshold, at several
pixels a module. zxing-cpp tells of each code it reads how much error correction was left ("UEC", the measure
of ISO/IEC 15415); `sampling.margin_left` predicts the same. `fit` finds the constants of that prediction.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.pattern.cells.brightness import BLUR_SIGMA, NOISE_SIGMA, margin_left
from perfqr_cad.pattern.cells.lattice import Lattice, rasterised
from perfqr_cad.symbol import Symbol, encode
from perfqr_cad.table import Table

TEXT = "perfqr margin study"
VERSIONS = (3, 5, 8)
LEVEL = "H"  # much to correct, so that there is much to measure
BARS_PER_MODULE = (0.0, 0.1, 0.2, 0.3, 0.45)
BAR_WIDTHS = (6, 10, 16)  # of the 24 cells of a module: a third to two thirds, as webs are
QUIET = 4
LIGHT, DARK = 0.85, 0.04  # reflectance of white plastic and of black card (see scan.look)
GAMMA = 2.2


@dataclass(frozen=True)
class Conditions:
    """One way to be seen: pixels a module, blur (standard deviation, px) and noise (part of full scale)."""

    module_px: float
    blur_px: float
    noise: float


CONDITIONS = tuple(Conditions(*s) for s in product((4.0, 6.0, 9.0), (0.6, 1.2), (0.02, 0.08)))
BLURS = (0.06, 0.08, 0.10, 0.12, 0.16, 0.20, 0.24)  # of a module
NOISES = (0.06, 0.08, 0.10, 0.12, 0.15, 0.20)  # of the contrast


@dataclass(frozen=True)
class Sample:
    """A damaged code, how it was seen, and the part of its error correction that was left; None: not read."""

    lattice: Lattice
    symbol: Symbol
    seen: Conditions
    left: float | None


def run() -> Table:
    """Predicted and measured margin by pixels a module, with the constants in use and with the best."""
    samples = list(study())
    blur, noise = fit(samples)
    rows = [_row(f"{px:g} px a module", [s for s in samples if s.seen.module_px == px]) for px in (4, 6, 9)]
    rows.append(_row("all", samples))
    return Table(
        "pattern: predicted decoding margin against zxing-cpp's unused error correction",
        (
            "views",
            "codes",
            "read",
            "mean measured",
            "mean predicted",
            "rms error",
            "correlation",
            "verdicts right",
        ),
        tuple(rows),
        (
            f"in use: blur {BLUR_SIGMA:g} of a module, noise {NOISE_SIGMA:g} of the contrast;"
            f" best on this sample: {blur:g} and {noise:g}",
            "margins below 0 and codes that are not read count as 0; verdicts right: part of the views in"
            " which the code is read exactly when the predicted margin is above 0",
        ),
    )


def study(seed: int = 1) -> Iterator[Sample]:
    """Every damaged code under all conditions."""
    rng = np.random.default_rng(seed)
    for version, share, width in product(VERSIONS, BARS_PER_MODULE, BAR_WIDTHS):
        symbol = encode(TEXT, version=version, level=LEVEL)
        lattice = damaged(symbol, share, width, rng)
        for seen in CONDITIONS:
            picture = photographed(lattice, seen, rng)
            yield Sample(lattice, symbol, seen, unused_correction(picture, TEXT))


def damaged(symbol: Symbol, share: float, width: int, rng: np.random.Generator) -> Lattice:
    """A plain code with bars, solid or void, `share` of them a module, at random between the finders."""
    lattice = rasterised(~symbol.matrix.dark, 1, QUIET, 1.0, frame=True)
    u, n = lattice.per_module, lattice.modules
    solid = lattice.solid.copy()
    for _ in range(round(share * n * n)):
        x, y = (rng.integers((QUIET + 9) * u, (QUIET + n - 9) * u, 2)).tolist()
        length = int(rng.integers(u // 2, 2 * u))
        across, down = (length, width) if rng.random() < 0.5 else (width, length)
        solid[y : y + down, x : x + across] = rng.random() < 0.8
    return lattice.with_solid(solid)


def photographed(lattice: Lattice, seen: Conditions, rng: np.random.Generator) -> NDArray[np.uint8]:
    """A gray view, turned a little and off the pixel grid."""
    import cv2

    edge = lattice.cells
    zoom = seen.module_px / lattice.per_module
    side = int(np.ceil(edge * zoom * 1.1)) + 8
    turn = cv2.getRotationMatrix2D((edge / 2, edge / 2), float(rng.uniform(-3, 3)), zoom)
    turn[:, 2] += side / 2 - edge / 2 + rng.uniform(-0.5, 0.5, 2)
    cells = np.where(lattice.solid, LIGHT, DARK).astype(np.float32)
    fine = max(1, round(1 / zoom))  # cells a pixel: averaged first, so that none is passed over
    cells = cv2.blur(cells, (fine, fine))
    view = cv2.warpAffine(cells, turn, (side, side), flags=cv2.INTER_LINEAR, borderValue=LIGHT)
    view = cv2.GaussianBlur(view, (0, 0), seen.blur_px)
    view = np.clip(view, 0, 1) ** (1 / GAMMA) + rng.normal(0, seen.noise, view.shape)
    return (255 * np.clip(view, 0, 1)).astype(np.uint8)


def unused_correction(image: NDArray[np.uint8], text: str) -> float | None:
    """What zxing-cpp says is left of the error correction; None when it does not read the text."""
    import zxingcpp

    formats: Any = zxingcpp.BarcodeFormat.QRCode
    for found in zxingcpp.read_barcodes(image, formats=formats):
        if found.text == text:
            extra: Any = found.extra
            return float(extra["UEC"])
    return None


def fit(samples: Sequence[Sample]) -> tuple[float, float]:
    """Blur and noise with which the margin predicts the measured one best; a code not read counts as 0."""
    codes = {id(s.lattice): s for s in samples}
    measured = np.array([s.left or 0.0 for s in samples])

    def error(blur: float, noise: float) -> float:
        margin = {k: margin_left(s.lattice, s.symbol, blur=blur, noise=noise) for k, s in codes.items()}
        predicted = np.array([max(margin[id(s.lattice)], 0.0) for s in samples])
        return float(((predicted - measured) ** 2).mean())

    return min(product(BLURS, NOISES), key=lambda pair: error(*pair))


def _row(name: str, samples: Sequence[Sample]) -> tuple[object, ...]:
    margin = {id(s.lattice): margin_left(s.lattice, s.symbol) for s in samples}
    predicted = np.array([max(margin[id(s.lattice)], 0.0) for s in samples])
    measured = np.array([s.left or 0.0 for s in samples])
    read = np.array([s.left is not None for s in samples])
    return (
        name,
        len(samples),
        int(read.sum()),
        float(measured.mean()),
        float(predicted.mean()),
        float(np.sqrt(((predicted - measured) ** 2).mean())),
        float(np.corrcoef(predicted, measured)[0, 1]),
        f"{((predicted > 0) == read).mean():.0%}",
    )
