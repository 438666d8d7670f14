"""What a picture of a code turns out to hold."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from perfqr_cad.symbol import Matrix, Recovery

Sampling = Literal["soft", "gaussian"]
ArtKind = Literal["plain", "halftone", "freeform"]


@dataclass(frozen=True, eq=False)
class Art:
    """The picture's own light and dark shapes inside the symbol, quiet zone excluded.

    kind   "plain" whole modules, "halftone" k × k submodules, "freeform" any shapes
    scale  samples along one module: 1, k, or the resolution that the shapes were sampled at
    dark   (n·scale, n·scale) bool, row 0 at the top
    """

    kind: ArtKind
    scale: int
    dark: NDArray[np.bool_]

    def __post_init__(self) -> None:
        _close(self, "dark", np.bool_)

    @property
    def modules(self) -> int:
        """n, the modules on one side."""
        return self.dark.shape[0] // self.scale


@dataclass(frozen=True, eq=False)
class Capture:
    """A code read from a picture.

    matrix          Q, the modules as sampled, errors and all (paper §4.2)
    log_likelihood  (n, n) ln(P(dark)/P(light)) of each module
    recovery        the symbol Q₀ that Q stands for, and the codewords in which they differ
    art             the picture's own shapes
    rectified       (n·px, n·px) uint8 luminance of the symbol seen straight on, dark on light
    homography      (3, 3) from module coordinates (x right, y down, 0..n) to pixels whose centres are
                    integers; curved pages deviate from it by `warp`
    warp            (k, k, 2) displacement in modules, on an even lattice over the symbol; 0 for a flat page
    confidence      (n, n) probability that the module was sampled right, 0.5..1
    engine          what found the code
    inverted        the picture shows light modules for dark ones
    mirrored        the picture shows the code as in a mirror
    """

    matrix: Matrix
    log_likelihood: NDArray[np.float64]
    recovery: Recovery
    art: Art
    rectified: NDArray[np.uint8]
    homography: NDArray[np.float64]
    warp: NDArray[np.float64]
    confidence: NDArray[np.float64]
    engine: str
    inverted: bool
    mirrored: bool

    def __post_init__(self) -> None:
        for name in ("log_likelihood", "homography", "warp", "confidence"):
            _close(self, name, np.float64)
        _close(self, "rectified", np.uint8)


def _close(owner: object, name: str, dtype: Any) -> None:
    """Replaces an array field of a frozen value by a read-only copy."""
    values = np.array(getattr(owner, name), dtype=dtype, order="C")
    values.setflags(write=False)
    object.__setattr__(owner, name, values)
