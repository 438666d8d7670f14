"""What a file does not hold of a design, by the module that writes it: nothing is left out without a word."""

from __future__ import annotations

from perfqr_cad.export import cutting
from perfqr_cad.export.colour_change import colour_changes
from perfqr_cad.export.design_view import DesignView
from perfqr_cad.export.options import DEFAULT, Options
from perfqr_cad.geometry import Bezier

FLAT = ("dxf", "svg")  # formats of the pattern's plane
ONE_BODY = (*FLAT, "stl")


def leaves_out(design: DesignView, module: str, options: Options = DEFAULT) -> tuple[str, ...]:
    """Bodies of the design that are not in the file, nor in one beside it."""
    left: list[str] = []
    if module in ONE_BODY and not (module == "stl" and options.split_stl):
        left += [f"the {extra.name}" for extra in design.solid.extras]
    if module in FLAT and design.solid.is_carved:
        left.append("the body around the code")
    return tuple(left)


def notes(design: DesignView, module: str, options: Options = DEFAULT) -> tuple[str, ...]:
    """What the file shows otherwise than the part is, and what its maker must know."""
    if module == "threemf" and options.colour_change:
        return tuple(change.words for change in colour_changes(design.solid))
    if module not in FLAT:
        return ()
    found = list(cutting.notes(design))
    if options.kerf_mm and (module == "dxf" or options.svg == "cut"):
        found.append(f"paths keep {options.kerf_mm / 2:g} mm off the part, half of the kerf")
    work = cutting.cut(design)
    curved = any(isinstance(s, Bezier) for loop in (*work.engrave, *work.through) for s in loop.segments)
    if module == "dxf" and curved:
        from perfqr_cad.export.dxf import ARC_TOL_MM

        found.append(f"curves are arcs within {ARC_TOL_MM:g} mm")
    return tuple(found)
