"""A flat perforated code in one call: what both front ends put into their models."""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING, Any

from perfqr_cad.errors import DesignError

if TYPE_CHECKING:
    from perfqr_cad.solid.shape import Solid


def plate(
    text: str,
    size_mm: float | None = None,
    thickness_mm: float = 1.6,
    *,
    level: str = "M",
    version: int | None = None,
    draft_deg: float = 0.0,
    lip_mm: float = 0.0,
    depth_mm: float | None = None,
    **pattern: Any,
) -> Solid:
    """The solid: back at z = 0, front at z = thickness, centre of the code on the z axis, y up.

    `pattern` are the fields of `PatternSpec` (quiet_modules, nozzle_mm, style, fillet_mm, finder, …). Raises
    `SymbolError`, `DesignError` and `KernelError` as the steps do.
    """
    from perfqr_cad.pattern import PatternSpec, build
    from perfqr_cad.profile import Walls
    from perfqr_cad.solid import build as build_solid
    from perfqr_cad.surface import Plane
    from perfqr_cad.symbol import encode

    known = {f.name for f in fields(PatternSpec)}
    for name in pattern:
        if name not in known:
            raise DesignError(f"a perforated code has no setting {name!r}: it has {', '.join(sorted(known))}")
    symbol = encode(text, version=version, level=level)  # pyright: ignore[reportArgumentType] - checked there
    made = build(symbol, PatternSpec(size_mm=size_mm, **pattern))
    return build_solid(made, Plane(thickness_mm), Walls(draft_deg, lip_mm, depth_mm))
