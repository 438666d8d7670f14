"""Codes that stand in for the paper's five pictures, which cannot be shipped.

Where the folder of shared pictures lies beside the checkout, its artistic codes are used; elsewhere a 3×3
halftone of the same version is drawn here.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

SHARED = Path(__file__).resolve().parents[3] / "shared" / "data" / "art"
SUBMODULES, PX, QUIET = 3, 4, 4  # the halftone of Chu et al.; pixels a submodule; modules


@dataclass(frozen=True)
class Row:
    """A row of Table 1: what the paper made and measured. `size_mm` is the printed edge."""

    name: str
    shared: str
    version: int
    size_mm: float
    connectivity_s: float
    connectivity_iterations: int
    structural_s: float
    structural_iterations: int


# Table 1 of the paper; the shared file is the stand-in.
TABLE_1: tuple[Row, ...] = (
    Row("Flower", "flower_halftone.png", 8, 140.0, 842, 140, 387, 7),
    Row("Monroe", "monalisa_halftone.png", 6, 130.0, 456, 79, 156, 3),
    Row("Einstein", "cat_halftone.png", 5, 120.0, 2465, 493, 588, 12),
    Row("Mario", "horse_qart_v8.png", 6, 50.0, 179, 35, 232, 6),
    Row("CADGraphics", "cadgraphics_styled.png", 5, 90.0, 336, 61, 168, 4),
)
THICKNESS_MM = 2.0  # Table 1: all cuboids are 0.2 cm thick


def picture(row: Row, folder: Path) -> Path:
    """The stand-in's picture; drawn into `folder` when no shared one is there."""
    shared = SHARED / row.shared
    return shared if shared.is_file() else _drawn(row, folder)


def _drawn(row: Row, folder: Path) -> Path:
    from PIL import Image

    from perfqr_cad.symbol import Role, encode, layout

    symbol = encode(f"https://example.com/{row.name.lower()}", version=row.version, level="H")
    dark = symbol.matrix.dark
    role = layout(symbol.version, symbol.level).roles
    art = _dithered(symbol.size * SUBMODULES)
    art[1::3, 1::3] = dark  # the centre of every module tells its value
    whole = np.kron(np.isin(role, (Role.DATA, Role.EC)), np.ones((3, 3), bool))
    art = np.where(whole, art, np.kron(dark, np.ones((3, 3), bool)))
    pixels = np.kron(np.pad(art, QUIET * SUBMODULES), np.ones((PX, PX), bool))
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{row.name.lower()}.png"
    Image.fromarray(np.where(pixels, 0, 255).astype(np.uint8)).save(path)
    return path


def _dithered(size: int) -> np.ndarray:
    """A flower of six petals as black and white dots, True = dark, (size, size)."""
    from PIL import Image

    y, x = np.mgrid[-1 : 1 : size * 1j, -1 : 1 : size * 1j]
    petals = np.hypot(x, y) - 0.5 - 0.25 * np.cos(6 * np.arctan2(y, x))
    shade = Image.fromarray((255 * (0.5 + 0.45 * np.tanh(8 * petals))).astype(np.uint8))
    return np.array(shade.convert("1", dither=Image.Dither.FLOYDSTEINBERG)) == 0
