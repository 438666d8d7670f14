"""Which drawing of a message needs the least joining."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from perfqr_cad.pattern.cells.lattice import checkerboards, label
from perfqr_cad.pattern.spec import PatternSpec, Tone
from perfqr_cad.symbol import Symbol

MASKS = 8
LINK_AREA = 0.27  # modules of area that a link at a corner paints, by a web of two thirds of a module
ROUTE_AREA = 1.5  # the same for a route between islands


def easiest_mask(symbol: Symbol, spec: PatternSpec) -> Symbol:
    """The same message under the mask whose light, or material of another tone, hangs together best.

    All eight masks are valid to every reader. Estimated is the area that links at corners and routes between
    islands would paint; of equal masks the first.
    """
    return min(
        (replace(symbol, mask=mask) for mask in range(MASKS)),
        key=lambda other: joining_area(other, spec.tone, spec.quiet_modules),
    )


def joining_area(symbol: Symbol, tone: Tone, quiet_modules: int = 4) -> float:
    """Modules of area that joining a plain code's islands would change, estimated."""
    solid = np.pad(
        symbol.matrix.dark == (tone == "inverted"), quiet_modules, constant_values=tone == "normal"
    )
    corners = checkerboards(solid)
    linked = solid.repeat(2, axis=0).repeat(2, axis=1)
    for x, y in corners.tolist():
        linked[2 * y - 1 : 2 * y + 1, 2 * x - 1 : 2 * x + 1] = True
    return LINK_AREA * len(corners) + ROUTE_AREA * (label(linked)[1] - 1)
