"""What a picture lost on its way to a part: who still reads it, and how alike the two look."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
from numpy.typing import NDArray

from perfqr_cad.scan.camera.camera import View
from perfqr_cad.scan.camera.flat import FlatPrint
from perfqr_cad.scan.camera.look import Look
from perfqr_cad.scan.camera.scene import Scene

if TYPE_CHECKING:
    from perfqr_cad.scan.report import DecoderResult

Gray = NDArray[np.uint8]
ARM_MM = 500.0  # from where a part in the hand or on a desk is looked at
ARC_MINUTE = np.pi / 180 / 60  # what an eye resolves
LEAST_PX, MOST_PX = 96, 800
# Wang et al., Image quality assessment: from error visibility to structural similarity (2004), §III.
WINDOW_PX, SIGMA_PX, K1, K2 = 11, 1.5, 0.01, 0.03


@dataclass(frozen=True)
class Likeness:
    """A flat print of the art beside the part.

    art, part    pictures (n, n) of both from straight above, as an eye resolves them at `ARM_MM`
    ssim         their structural similarity, 1 = the same
    results      what decoders read of the flat print of the art, by tilt
    """

    art: Gray
    part: Gray
    ssim: float
    results: dict[str, DecoderResult]

    @property
    def readers(self) -> tuple[str, ...]:
        """Decoders that read the art from straight above."""
        return tuple(name for name, result in self.results.items() if result.frontal)

    def lost(self, readers: tuple[str, ...]) -> tuple[str, ...]:
        """Decoders that read the art and are not among those that read the part."""
        return tuple(name for name in self.readers if name not in readers)

    def words(self, readers: tuple[str, ...]) -> str:
        """One sentence for people; `readers` are those of the part."""
        lost = self.lost(readers)
        read = (
            f"{', '.join(lost)} read the art and not the part" if lost else "all that read it read the part"
        )
        return f"the art is kept to {self.ssim:.0%} (SSIM at {ARM_MM / 1000:g} m); {read}"

    def as_dict(self, readers: tuple[str, ...]) -> dict[str, Any]:
        """For the certificate."""
        return {
            "ssim": round(self.ssim, 4),
            "viewing_distance_mm": ARM_MM,
            "lost": list(self.lost(readers)),
            "rates": {
                name: {f"{t:g}": round(rate, 4) for t, rate in zip(one.tilts_deg, one.rates, strict=True)}
                for name, one in self.results.items()
            },
        }


def likeness(
    scene: Scene, art: FlatPrint, look: Look, edge_mm: float, results: dict[str, DecoderResult]
) -> Likeness:
    """The part beside a flat print of the art, both of this edge with its quiet zone."""
    resolved_px = int(np.clip(edge_mm / (ARM_MM * ARC_MINUTE), LEAST_PX, MOST_PX))
    view = View(fill=1.0, distance=ARM_MM / edge_mm, size_px=2 * resolved_px)
    pictures = [
        cv2.resize(subject.photo(view, look), (resolved_px, resolved_px), interpolation=cv2.INTER_AREA)
        for subject in (art, scene)
    ]
    first, second = (np.asarray(picture, np.uint8) for picture in pictures)
    return Likeness(first, second, similarity(first, second), results)


def similarity(one: Gray, other: Gray) -> float:
    """Mean structural similarity of two pictures (H, W), with the window of the paper.

    >>> flat = np.full((32, 32), 90, np.uint8)
    >>> similarity(flat, flat)
    1.0
    """
    x, y = one.astype(np.float64), other.astype(np.float64)

    def mean(picture: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(cv2.GaussianBlur(picture, (WINDOW_PX, WINDOW_PX), SIGMA_PX), np.float64)

    mx, my = mean(x), mean(y)
    vx, vy, both = mean(x * x) - mx**2, mean(y * y) - my**2, mean(x * y) - mx * my
    c1, c2 = (K1 * 255) ** 2, (K2 * 255) ** 2
    index = (2 * mx * my + c1) * (2 * both + c2) / ((mx**2 + my**2 + c1) * (vx + vy + c2))
    return round(float(index.mean()), 9)
