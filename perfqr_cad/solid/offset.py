"""Holes widened in the plane, segment by segment, so that the walls between stay planes, cones and ruled faces.

`shapely.buffer` would flatten arcs and drop segments; here every segment of the widened loop lies above the
segment it came from.
"""

from __future__ import annotations

from perfqr_cad.pattern.outline import Loop


def widened(loop: Loop, by_mm: float) -> Loop:
    raise NotImplementedError
