"""The size of a module: the smallest that the nozzle can make, or the one asked for if it can be made."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from perfqr_cad.errors import DesignError
from perfqr_cad.pattern.spec import PatternSpec
from perfqr_cad.symbol import Symbol

if TYPE_CHECKING:
    from perfqr_cad.capture import Art

WEBS_PER_MODULE = (
    1.5  # a route along a module edge takes half a web of each side: at most a third of the module
)
SIZE_STEP_MM = 0.1  # a size that is picked is rounded up to a tenth of a millimetre


def module_size(symbol: Symbol, spec: PatternSpec, art: Art | None) -> tuple[float, str]:
    """Module edge in mm, and why. DesignError with the least size that works when less is asked for."""
    modules = symbol.size + 2 * spec.quiet_modules
    least_module, reason = _least_module(spec)
    least_size = _rounded_up(least_module * modules)
    if spec.size_mm is not None:
        if spec.size_mm < least_size:
            raise DesignError(
                f"size {spec.size_mm:g} mm makes modules of {spec.size_mm / modules:.3g} mm, least is"
                f" {least_module:.3g} mm ({reason}): use --size {least_size:g} or more, or a finer nozzle"
            )
        return spec.size_mm / modules, "as asked"
    scale = 1 if art is None or art.kind != "halftone" else art.scale
    if scale * spec.web_mm > least_module:
        least_module, reason = (
            scale * spec.web_mm,
            f"{scale} dots of the art across, each a web of {spec.web_mm:g} mm",
        )
    return _rounded_up(least_module * modules) / modules, f"module {least_module:.3g} mm: {reason}"


def _least_module(spec: PatternSpec) -> tuple[float, str]:
    by_web = WEBS_PER_MODULE * spec.web_mm
    by_gap = spec.web_mm + spec.gap_mm
    if by_gap > by_web:
        return by_gap, f"a web of {spec.web_mm:g} mm and a gap of {spec.gap_mm:g} mm side by side"
    return by_web, f"{WEBS_PER_MODULE:g} webs of {spec.web_mm:g} mm"


def _rounded_up(size_mm: float) -> float:
    return round(math.ceil(size_mm / SIZE_STEP_MM - 1e-9) * SIZE_STEP_MM, 6)
