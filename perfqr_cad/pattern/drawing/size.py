"""The size of a module: the smallest that the nozzle can make, or the one asked for if it can be made."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from perfqr_cad.errors import DesignError
from perfqr_cad.pattern.cells.lattice import cells_per_module
from perfqr_cad.pattern.drawing.style import is_drawn, least_module_mm
from perfqr_cad.pattern.spec import PatternSpec
from perfqr_cad.remedy import Remedy
from perfqr_cad.symbol import Symbol

if TYPE_CHECKING:
    from perfqr_cad.capture import Art

# A route along a module edge takes half a web from each side: that may be a third of a module at most.
WEBS_PER_MODULE = 1.5
DOT_STEP = 1.01  # dots are tried in steps of a hundredth
SIZE_ROUNDING_MM = 1e-6  # what a size may fall short by for the sake of binary fractions
SIZE_STEP_MM = 0.1  # a size that is picked is rounded up to a tenth of a millimetre


def module_size(symbol: Symbol, spec: PatternSpec, art: Art | None) -> tuple[float, str]:
    """Module edge in mm, and why. DesignError with the least size that works when less is asked for."""
    modules = symbol.size + 2 * spec.quiet_modules
    least_module, reason = _least_module(spec, is_drawn(spec.style) and art is None)
    least_size = rounded_up(least_module * modules)
    if spec.size_mm is not None:
        if spec.size_mm < least_size - SIZE_ROUNDING_MM:
            raise DesignError(
                f"size {spec.size_mm:g} mm makes modules of {spec.size_mm / modules:.3g} mm, least is"
                f" {least_module:.3g} mm ({reason})",
                Remedy(size_mm=least_size),
                "a finer nozzle",
            )
        return spec.size_mm / modules, "as asked"
    if art is not None and art.kind == "halftone":
        dot_mm = least_dot_mm(spec, art.scale)
        if art.scale * dot_mm > least_module:
            least_module = art.scale * dot_mm
            reason = (
                f"{art.scale} dots of {dot_mm:.3g} mm across, wide enough for a web of {spec.web_mm:g} mm"
            )
    return rounded_up(least_module * modules) / modules, f"module {least_module:.3g} mm: {reason}"


def can_be_made(symbol: Symbol, spec: PatternSpec) -> bool:
    """Whether the plain modules of a symbol are large enough in the size that is asked for."""
    least_module, _ = _least_module(spec, is_drawn(spec.style))
    least_mm = rounded_up(least_module * (symbol.size + 2 * spec.quiet_modules))
    return spec.size_mm is None or spec.size_mm >= least_mm - SIZE_ROUNDING_MM


def _least_module(spec: PatternSpec, drawn: bool) -> tuple[float, str]:
    if drawn:
        return least_module_mm(spec), f"{spec.style} that can be read, {spec.web_mm:g} mm apart"
    by_web = WEBS_PER_MODULE * spec.web_mm
    by_gap = spec.web_mm + spec.gap_mm
    if by_gap > by_web:
        return by_gap, f"a web of {spec.web_mm:g} mm and a gap of {spec.gap_mm:g} mm side by side"
    return by_web, f"{WEBS_PER_MODULE:g} webs of {spec.web_mm:g} mm"


def least_dot_mm(spec: PatternSpec, scale: int) -> float:
    """Edge of the least dot of art, mm: it holds a web between two corners that are parted by a gap."""
    cells = cells_per_module(scale) // scale
    dot_mm = max(spec.web_mm, (spec.web_mm + spec.gap_mm) / math.sqrt(2))
    while True:
        cell_mm = dot_mm / cells
        parted = math.ceil(spec.gap_mm / math.sqrt(2) / cell_mm)
        if (cells - parted) / math.sqrt(2) * cell_mm >= spec.web_mm / 2:
            return dot_mm
        dot_mm *= DOT_STEP


def rounded_up(size_mm: float) -> float:
    """The size in whole tenths of a millimetre."""
    return round(math.ceil(size_mm / SIZE_STEP_MM - 1e-9) * SIZE_STEP_MM, 6)
