"""The finished pattern: one piece of material in the plane, and how it came to be one."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry.mirror import mirrored
from perfqr_cad.geometry.outline import Region
from perfqr_cad.pattern.bridge import Bridge
from perfqr_cad.pattern.cells.brightness import solid_part
from perfqr_cad.pattern.cells.canvas import Canvas
from perfqr_cad.pattern.drawing.contours import check_webs, styled_front
from perfqr_cad.pattern.drawing.front import front_with_bars
from perfqr_cad.pattern.joining.rings import as_webs, flush_where_joined
from perfqr_cad.pattern.joining.spanning import Optimality
from perfqr_cad.pattern.spec import PatternSpec
from perfqr_cad.pattern.surround import surrounded
from perfqr_cad.symbol import Matrix, Readability, Symbol, readability

if TYPE_CHECKING:
    from shapely.geometry import Polygon


@dataclass(frozen=True)
class Pattern:
    """The 2-D design: material as one region in mm, origin at the centre of the code, y up.

    region            outline of the material with curves kept as curves, recessed bars included
    front             the same at the front face: without recessed bars, so the rings they hold are regions
                      of their own; the greatest comes first
    bridges           in the order in which they were laid
    islands_before    pieces of material before any bridge (sharing a corner is not joined)
    observed          the matrix as sampled on the finished region
    changed_area_mm2  area where the material differs from the art that was asked for
    edits             counts of clean-up changes by name
    optimality        what was proved, None for the baselines
    losses            L(Q) after each connector of the baselines (Fig. 9); empty for `optimal`
    size_reason       why the module has the size it has
    canvas            the lattice that the outline was drawn from
    """

    symbol: Symbol
    spec: PatternSpec
    module_mm: float
    quiet_modules: int
    region: Region
    front: tuple[Region, ...]
    bridges: tuple[Bridge, ...]
    islands_before: int
    observed: Matrix
    readability: Readability
    changed_area_mm2: float
    edits: Mapping[str, int]
    optimality: Optimality | None
    losses: tuple[float, ...]
    size_reason: str
    canvas: Canvas = field(repr=False)

    @property
    def size_mm(self) -> float:
        """Edge of the whole code with its quiet zone, mm."""
        return self.module_mm * (self.symbol.size + 2 * self.quiet_modules)

    @property
    def extent_mm(self) -> float:
        """Edge of the whole part, frame included, mm."""
        return self.size_mm + 2 * self.spec.surround.frame_mm

    @property
    def recessed(self) -> tuple[Bridge, ...]:
        """The bridges that fill only the back of the part; `region` is `front` and these."""
        return tuple(bridge for bridge in self.bridges if bridge.is_recessed)

    def mirrored(self) -> Pattern:
        """The outlines and bridges as seen from behind; what was read and counted stays."""
        return replace(
            self,
            region=mirrored(self.region),
            front=tuple(mirrored(region) for region in self.front),
            bridges=tuple(bridge.mirrored() for bridge in self.bridges),
        )

    @cached_property
    def polygon(self) -> Polygon:
        """The region as a shapely polygon, curves within the default tolerance."""
        return self.region.polygon()

    @cached_property
    def web_polygon(self) -> Polygon:
        """The polygon by which the least web is judged: recessed bars count as wide as that (`as_webs`)."""
        return front_with_bars(self.front, as_webs(self.canvas, self.spec)).polygon()

    def with_bridge(self, bridge: Bridge) -> Pattern:
        """The pattern with one more bridge, sampled again; see `with_bridges`."""
        return self.with_bridges((bridge,))

    def with_bridges(self, bridges: Iterable[Bridge]) -> Pattern:
        """The pattern with more bridges, at any angle, sampled again.

        DesignError when a web is too thin or when the code can no longer be read.
        """
        canvas = self.canvas
        for bridge in bridges:
            canvas = canvas.with_slanted(bridge)
        pattern = finish(canvas, self)
        if math.isinf(pattern.readability.total) and math.isfinite(self.readability.total):
            errors, capacity = max(pattern.readability.errors), min(pattern.readability.capacity)
            raise DesignError(
                f"the bridges leave {errors} wrong codewords in a block, {capacity} can be corrected:"
                " place them elsewhere or raise the error correction level"
            )
        return pattern


@dataclass(frozen=True)
class Origin:
    """What a pattern comes from: it stays the same while bridges are added (see `Pattern` for the fields)."""

    symbol: Symbol
    spec: PatternSpec
    islands_before: int
    size_reason: str
    optimality: Optimality | None = None
    losses: tuple[float, ...] = ()


def finish(canvas: Canvas, origin: Origin | Pattern, webs_hold: bool = False) -> Pattern:
    """The pattern of a canvas. DesignError when it is not one piece with the least web throughout.

    webs_hold  the webs have been checked already
    """
    spec, lattice = origin.spec, canvas.lattice
    canvas = flush_where_joined(canvas, spec)
    if not webs_hold:
        check_webs(canvas, spec)
    size_mm = lattice.cells * lattice.cell_mm
    front = surrounded(styled_front(canvas, spec), size_mm, spec.surround, spec.web_mm)
    observed = Matrix((solid_part(canvas.lattice) >= 0.5) == (spec.tone == "inverted"))
    changed = int(np.count_nonzero(canvas.solid ^ canvas.asked))
    return Pattern(
        symbol=origin.symbol,
        spec=spec,
        module_mm=lattice.module_mm,
        quiet_modules=lattice.quiet,
        region=front_with_bars(front, canvas.recessed),
        front=front,
        bridges=canvas.bridges,
        islands_before=origin.islands_before,
        observed=observed,
        readability=readability(observed, origin.symbol),
        changed_area_mm2=changed * lattice.cell_mm**2,
        edits=canvas.edits,
        optimality=origin.optimality,
        losses=origin.losses,
        size_reason=origin.size_reason,
        canvas=canvas,
    )
