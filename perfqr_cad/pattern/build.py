"""From a symbol, or the art of a picture, to a pattern in one piece."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from perfqr_cad.errors import DesignError
from perfqr_cad.pattern.connect import join
from perfqr_cad.pattern.draft import Draft, Rect, is_slanted, link_corners, strip
from perfqr_cad.pattern.finder import bars
from perfqr_cad.pattern.lattice import Cells, Lattice, draw, label, trace
from perfqr_cad.pattern.outline import Loop, Region
from perfqr_cad.pattern.pattern import Bridge, Pattern
from perfqr_cad.pattern.sampling import brightness
from perfqr_cad.pattern.size import module_size
from perfqr_cad.pattern.spec import PatternSpec
from perfqr_cad.symbol import Matrix, Symbol, readability

if TYPE_CHECKING:
    from perfqr_cad.capture import Art


def build(symbol: Symbol, spec: PatternSpec, art: Art | None = None) -> Pattern:
    """The pattern of a symbol in one piece; `art` replaces the plain modules by a picture's own.

    DesignError when the size is too small for the nozzle, or the result could not be read.
    """
    module_mm, reason = module_size(symbol, spec, art)
    asked = _asked(symbol, spec, art, module_mm)
    draft = Draft(asked, asked.solid, asked.solid)
    _, islands = label(asked.solid)
    draft = tie_rings(draft, symbol, spec)
    draft = link_corners(draft, spec.web_mm)
    draft = join(draft, symbol, spec.web_mm, spec.tone == "inverted")
    draft = link_corners(draft, spec.web_mm)
    return finish(draft, symbol, spec, islands)


def _asked(symbol: Symbol, spec: PatternSpec, art: Art | None, module_mm: float) -> Lattice:
    dark = symbol.matrix.dark if art is None else art.dark
    inverted = spec.tone == "inverted"
    return draw(dark == inverted, dark.shape[0] // symbol.size, spec.quiet_modules, module_mm, frame=not inverted)


def tie_rings(draft: Draft, symbol: Symbol, spec: PatternSpec) -> Draft:
    """The rings of finder and alignment patterns tied to their surroundings by the chosen strategy."""
    lattice = draft.lattice
    half = lattice.whole(spec.web_mm / 2)
    u, edge = lattice.per_module, lattice.quiet * lattice.per_module
    for bar in bars(symbol.version, spec.finder):
        (x0, y0), (x1, y1) = ((round(edge + x * u), round(edge + y * u)) for x, y in (bar.start, bar.end))
        if x0 != x1 and y0 != y1:
            ends = lattice.to_mm(x0, y0), lattice.to_mm(x1, y1)
            draft = draft.with_slanted(Bridge(*ends, spec.web_mm, "function", 0.0))
        elif x0 == x1:
            draft = draft.with_bars([(Rect(x0 - half, y0, x0 + half, y1), False)], "function")
        else:
            draft = draft.with_bars([(Rect(x0, y0 - half, x1, y0 + half), True)], "function")
    return draft


def finish(draft: Draft, symbol: Symbol, spec: PatternSpec, islands: int) -> Pattern:
    """The outline of a draft, and what a reader makes of it."""
    lattice = draft.lattice
    skeleton = _outline(lattice, draft.upright, [b for b in draft.bridges if is_slanted(b)])
    solid_is_dark = spec.tone == "inverted"
    observed = Matrix((brightness(lattice) >= 0.5) == solid_is_dark)
    changed = int(np.count_nonzero(lattice.solid ^ draft.asked)) * lattice.cell_mm**2
    return Pattern(
        symbol=symbol,
        spec=spec,
        module_mm=lattice.module_mm,
        quiet_modules=lattice.quiet,
        region=skeleton,
        bridges=draft.bridges,
        islands_before=islands,
        observed=observed,
        readability=readability(observed, symbol),
        changed_area_mm2=changed,
        edits=dict(draft.edits),
        skeleton=skeleton,
    )


def _outline(lattice: Lattice, upright: Cells, slanted: list[Bridge]) -> Region:
    loops = [np.array([lattice.to_mm(x, y) for x, y in loop.tolist()]) for loop in trace(upright)]
    areas = [Loop.from_points(loop).area for loop in loops]
    if slanted:
        import shapely
        from shapely.geometry import Polygon

        outer = shapely.union_all([Polygon(p) for p, a in zip(loops, areas, strict=True) if a > 0])
        inner = shapely.union_all([Polygon(p) for p, a in zip(loops, areas, strict=True) if a < 0])
        shape = shapely.union_all([shapely.difference(outer, inner), *(Polygon(strip(b)) for b in slanted)])
        if shape.geom_type != "Polygon":
            raise DesignError(f"{len(shape.geoms)} pieces are left after bridging: raise --size or use a finer nozzle")
        return Region.from_polygon(shape)
    outers = [Loop.from_points(p) for p, a in zip(loops, areas, strict=True) if a > 0]
    if len(outers) != 1:
        raise DesignError(f"{len(outers)} pieces are left after bridging: raise --size or use a finer nozzle")
    return Region(outers[0], tuple(Loop.from_points(p) for p, a in zip(loops, areas, strict=True) if a < 0))
