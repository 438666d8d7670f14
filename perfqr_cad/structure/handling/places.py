"""Places of a pattern in words: what a buyer points at."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from shapely.geometry import Point, Polygon

from perfqr_cad.structure.handling.named_loads import FINGERTIP_PAD_MM
from perfqr_cad.symbol import layout
from perfqr_cad.symbol.layout import Role

if TYPE_CHECKING:
    from perfqr_cad.pattern import Pattern

ARM_MODULES = 1.5  # from where it is pressed to where it breaks: further than that and what bends is an arm


def on_ring(pattern: Pattern, at_mm: tuple[float, float], reach_mm: float = 0.0) -> bool:
    """Whether a place is in a finder or alignment pattern, or in reach of one: no bridge may help there."""
    x, y = at_mm
    corners = ((x + i * reach_mm, y + j * reach_mm) for i in (-1, 1) for j in (-1, 1))
    return any(_ring(pattern, corner) is not None for corner in corners)


def breaks_ring(pattern: Pattern, at_mm: tuple[float, float]) -> bool:
    """Whether a ring gives way at a place, or one of its bars, whose outer ends are beside its pattern."""
    return on_ring(pattern, at_mm, pattern.spec.web_mm)


def presses_ring(pattern: Pattern, at_mm: tuple[float, float]) -> bool:
    """Whether a fingertip at a place presses a ring too, whose own bars then decide."""
    return on_ring(pattern, at_mm, FINGERTIP_PAD_MM / 2)


def place(pattern: Pattern, at_mm: tuple[float, float]) -> str:
    """The ring that a place is on, the frame around the code, or its coordinates.

    >>> from perfqr_cad.pattern import PatternSpec, build
    >>> from perfqr_cad.symbol import encode
    >>> pattern = build(encode("A", version=1), PatternSpec(size_mm=58.0))
    >>> place(pattern, (-15.0, -15.0)), place(pattern, (28.0, 0.0)), place(pattern, (2.04, 0.0))
    ('on the lower left finder ring', 'on the frame', 'at (2.0, 0.0)')
    """
    half = 0.5 * pattern.symbol.size * pattern.module_mm
    if max(abs(at_mm[0]), abs(at_mm[1])) >= half:
        return "on the frame"
    where = f"at ({at_mm[0] + 0.0:.1f}, {at_mm[1] + 0.0:.1f})"
    match _ring(pattern, at_mm):
        case None:
            return where
        case Role.ALIGNMENT:
            return f"on the alignment ring {where}"
        case _:
            upper, left = at_mm[1] > 0.0, at_mm[0] < 0.0
            return f"on the {'upper' if upper else 'lower'} {'left' if left else 'right'} finder ring"


def _ring(pattern: Pattern, at_mm: tuple[float, float]) -> Role | None:
    """Whose ring a place is on, if any."""
    n, m = pattern.symbol.size, pattern.module_mm
    column, row = int(np.floor(at_mm[0] / m + n / 2)), int(np.floor(n / 2 - at_mm[1] / m))
    if not (0 <= column < n and 0 <= row < n):
        return None
    role = Role(layout(pattern.symbol.version, pattern.symbol.level).roles[row, column])
    return role if role in (Role.FINDER, Role.SEPARATOR, Role.ALIGNMENT) else None


def pressed(pattern: Pattern, loaded_mm: tuple[float, float], stressed_mm: tuple[float, float]) -> str:
    """Where a fingertip presses: on an arm, its tip is meant where it breaks elsewhere."""
    words = place(pattern, loaded_mm)
    far = np.hypot(*np.subtract(loaded_mm, stressed_mm)) > ARM_MODULES * pattern.module_mm
    return f"at the tip of the arm {words}" if far and words.startswith("at ") else words


def breaking(pattern: Pattern, at_mm: tuple[float, float]) -> str:
    """Where a part breaks: at a bar of a ring, or a place."""
    reach = 0.5 * pattern.spec.nozzle_mm
    for bar in pattern.bridges:
        if bar.stage == "function" and Polygon(bar.corners()).distance(Point(at_mm)) <= reach:
            return f"at the bar of the ring at ({at_mm[0]:.1f}, {at_mm[1]:.1f})"
    return place(pattern, at_mm)
