"""The light region as a mesher wants it: one clean piece, no near-coincident points, no slivers.

Points closer than the mesher's own tolerance hang gmsh or lose area without a word, so the outline is
snapped and thinned first, and what that changed is checked.
"""

from __future__ import annotations

import numpy as np
import shapely
from shapely.geometry import Polygon

from perfqr_cad.errors import AnalysisError

SNAP_MM = 1e-4  # far below any printer, far above the rounding of a double at 1 m
SPECK_FRACTION = 1e-6  # pieces below this share of the area are left-overs of snapping, not parts
AREA_CHANGE_LIMIT = 0.02  # cleaning may move the outline, never remove a web


def clean(polygon: Polygon) -> Polygon:
    """One valid polygon (mm) on a fine grid.

    Raises:
        AnalysisError: the region is empty, not finite, in several pieces, or changed by the cleaning.
    """
    _require_finite(polygon)
    pieces = _pieces(shapely.make_valid(polygon))
    if len(pieces) > 1:
        where = ", ".join(
            f"({p.representative_point().x:.1f}, {p.representative_point().y:.1f})" for p in pieces[1:4]
        )
        raise AnalysisError(
            f"the light region is in {len(pieces)} pieces; loose ones near {where} mm:"
            " connect them with bridges first"
        )
    change = abs(pieces[0].area - polygon.area) / polygon.area
    if change > AREA_CHANGE_LIMIT:
        raise AnalysisError(
            f"cleaning to {SNAP_MM} mm changes the light area by {change:.1%}"
            f" (limit {AREA_CHANGE_LIMIT:.0%}): make the webs wider"
        )
    return pieces[0]


def _require_finite(polygon: Polygon) -> None:
    coordinates = shapely.get_coordinates(polygon)
    if not len(coordinates):
        raise AnalysisError("the light region is empty: there is nothing to load")
    bad = ~np.isfinite(coordinates).all(axis=1)
    if bad.any():
        raise AnalysisError(
            f"{int(bad.sum())} points of the light region are not finite numbers;"
            f" the first is {coordinates[bad][0]} mm: repair the outline"
        )


def _pieces(region: shapely.Geometry) -> list[Polygon]:
    parts = [part for part in shapely.get_parts(region) if isinstance(part, Polygon) and part.area > 0.0]
    if not parts:
        raise AnalysisError("the light region has no area: there is nothing to load")
    total = sum(part.area for part in parts)
    return sorted((p for p in parts if p.area > SPECK_FRACTION * total), key=lambda p: -p.area)
