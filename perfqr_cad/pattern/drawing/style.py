"""Styles that draw each dark module, or each run of them, as a shape of its own: dots, diamonds, bars.

Finder and alignment patterns keep their squares, on which readers find the code. Between any two shapes lies
at least the least web, so nothing but the rings of the patterns can float.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from perfqr_cad.geometry.outline import Arc, Circle, Line, Loop, Point
from perfqr_cad.pattern.cells.lattice import Cells, Lattice
from perfqr_cad.pattern.spec import PatternSpec, Style
from perfqr_cad.symbol import Role, Symbol, layout

FULLEST = 0.46  # of a module: the greatest half width, so that shapes stay apart to the eye
ROUNDED_RADIUS = 0.45  # of a module, in the corners of the holes of the style `rounded`
# Least half width, in modules, at which the shape still decides the reading of its module.
LEAST_HALF = {"dots": 0.30, "diamond": 0.36, "bars": 0.27}


def is_drawn(style: Style) -> bool:
    """Whether a style draws shapes instead of modules."""
    return style in LEAST_HALF


def least_module_mm(spec: PatternSpec) -> float:
    """The least module in which a shape wide enough to be read leaves webs between two of its kind."""
    return spec.web_mm / (1 - 2 * LEAST_HALF[spec.style])


def shaped_modules(symbol: Symbol) -> Cells:
    """(n, n) dark modules that are drawn as shapes."""
    roles = layout(symbol.version, symbol.level).roles
    return symbol.matrix.dark & (roles != Role.FINDER) & (roles != Role.ALIGNMENT)


def style_holes(symbol: Symbol, spec: PatternSpec, lattice: Lattice) -> tuple[Loop, ...]:
    """The holes of a style, clockwise, in mm."""
    m = lattice.module_mm
    half_mm = min(FULLEST * m, (m - spec.web_mm) / 2)
    edge, u = lattice.quiet * lattice.per_module, lattice.per_module

    def centre(row: float, column: float) -> Point:
        return lattice.to_mm(edge + (column + 0.5) * u, edge + (row + 0.5) * u)

    return tuple(_DRAW[spec.style](shaped_modules(symbol), centre, half_mm))


def _dots(dark: Cells, centre: Callable[[float, float], Point], half_mm: float) -> Iterator[Loop]:
    for row, column in np.argwhere(dark).tolist():
        yield Loop((Circle(centre(row, column), half_mm, ccw=False),))


def _diamonds(dark: Cells, centre: Callable[[float, float], Point], half_mm: float) -> Iterator[Loop]:
    for row, column in np.argwhere(dark).tolist():
        x, y = centre(row, column)
        tips = [(x, y + half_mm), (x + half_mm, y), (x, y - half_mm), (x - half_mm, y)]
        yield Loop.from_points(tips)


def _bars(dark: Cells, centre: Callable[[float, float], Point], half_mm: float) -> Iterator[Loop]:
    """Runs of dark modules in a column, with round ends."""
    for column in range(dark.shape[1]):
        steps = np.flatnonzero(np.diff(np.concatenate([[0], dark[:, column].astype(np.int8), [0]])))
        for first, end in steps.reshape(-1, 2).tolist():
            (x, top), (_, bottom) = centre(first, column), centre(end - 1, column)
            if math.isclose(top, bottom):
                yield Loop((Circle((x, top), half_mm, ccw=False),))
                continue
            left, right = x - half_mm, x + half_mm
            yield Loop(
                (
                    Arc((left, top), (right, top), (x, top), ccw=False),
                    Line((right, top), (right, bottom)),
                    Arc((right, bottom), (left, bottom), (x, bottom), ccw=False),
                    Line((left, bottom), (left, top)),
                )
            )


_DRAW: dict[str, Callable[[Cells, Callable[[float, float], Point], float], Iterator[Loop]]] = {
    "dots": _dots,
    "diamond": _diamonds,
    "bars": _bars,
}
