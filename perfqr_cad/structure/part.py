"""What is analysed: a light region, where it lies, and how it is meshed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from shapely.geometry import Polygon

from perfqr_cad.structure.mesh.light_region import ThinPart, thin_parts, with_roots
from perfqr_cad.structure.mesh.tiling import TileLattice
from perfqr_cad.surface import Placement

if TYPE_CHECKING:
    from perfqr_cad.pattern import Pattern


@dataclass(frozen=True)
class Part:
    """A light region (mm, in the pattern plane) on a placement.

    thin     parts of it that do not fill the wall
    lattice  squares that repeat in it, to mesh each kind of them once
    web_mm   width of its narrowest web at the back; None: its walls do not flare
    """

    polygon: Polygon
    placement: Placement
    thin: tuple[ThinPart, ...] = ()
    lattice: TileLattice | None = None
    web_mm: float | None = None

    @staticmethod
    def of(pattern: Pattern, placement: Placement, *, roots: bool = True) -> Part:
        """That of a pattern, recessed bars with their own thickness, and `roots` as a shell needs them."""
        thin = thin_parts(pattern, placement.thickness_mm)
        return Part(
            pattern.polygon,
            placement,
            with_roots(thin) if roots else thin,
            lattice_of(pattern),
            pattern.spec.web_mm,
        )


def lattice_of(pattern: Pattern) -> TileLattice:
    """The lattice of a pattern's modules."""
    half = 0.5 * pattern.symbol.size * pattern.module_mm
    return TileLattice(pattern.module_mm, (-half, -half))
