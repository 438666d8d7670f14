"""`Workplane.perforatedQR`: the code as a CadQuery method. Importing this module adds it."""

from __future__ import annotations

from typing import Any, Literal, cast

import cadquery

from perfqr_cad.frontends.designs import design_of
from perfqr_cad.solid.kernel.convert import to_cadquery


def perforatedQR(
    self: cadquery.Workplane,
    text: str,
    size_mm: float | None = None,
    thickness_mm: float = 1.6,
    *,
    combine: bool | Literal["cut", "a", "s"] = True,
    clean: bool = False,
    **settings: Any,
) -> cadquery.Workplane:
    """A flat perforated code at every point of the stack, its back on the workplane, read from its +z side.

    Settings are those of `perfqr_cad.make`; `combine` and `clean` are CadQuery's. The design with its
    certificate is `design` of the workplane that is returned.
    """
    design = design_of(text, size_mm=size_mm, thickness_mm=thickness_mm, **settings)
    code = cast(cadquery.Shape, to_cadquery(design.solid).val())
    placed = self.eachpoint(lambda place: code.moved(place), True, combine, clean)
    placed.design = design  # type: ignore[attr-defined]
    return placed


cadquery.Workplane.perforatedQR = perforatedQR  # type: ignore[attr-defined]
