"""The light region as a mesher wants it: one clean piece, no near-coincident points, no slivers.

Points closer than the mesher's own tolerance hang gmsh or lose area without a word, so the outline is
snapped and thinned first, and what that changed is checked.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import shapely
from shapely.geometry import MultiPolygon, Polygon

from perfqr_cad.errors import AnalysisError
from perfqr_cad.pattern.bridge import LEAST_SLOT_DEPTH_MM

if TYPE_CHECKING:
    from perfqr_cad.pattern import Pattern

SNAP_MM = 1e-4  # far below any printer, far above the rounding of a double at 1 m
SPECK_FRACTION = 1e-6  # pieces below this share of the area are left-overs of snapping, not parts
ROOT_HEIGHTS = 0.65  # of a recessed bar: by how much it acts longer at each end
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


@dataclass(frozen=True)
class ThinPart:
    """A part of the light region (mm) that fills only some of the wall's thickness."""

    polygon: Polygon
    thickness_mm: float


def thin_parts(pattern: Pattern, wall_mm: float) -> tuple[ThinPart, ...]:
    """The recessed bars of a pattern in a wall thick enough to have their slots."""
    return tuple(
        ThinPart(Polygon(bar.corners()), bar.height_mm)
        for bar in pattern.recessed
        if bar.height_mm is not None and bar.height_mm + LEAST_SLOT_DEPTH_MM <= wall_mm
    )


def with_roots(parts: Sequence[ThinPart]) -> tuple[ThinPart, ...]:
    """Thin parts drawn out into the wall on all sides, by what the wall yields at their roots.

    A bar that is much thinner than the wall it stands in turns with the material at its root as if it were
    longer by a share of its own height (O'Donnell, J. Appl. Mech. 27, 1960, for a beam in the edge of a half
    plane); the share is that with which shell and solid agree.
    """
    longer = (
        shapely.buffer(one.polygon, ROOT_HEIGHTS * one.thickness_mm, join_style="mitre") for one in parts
    )
    return tuple(replace(part, polygon=polygon) for part, polygon in zip(parts, longer, strict=True))


def by_thickness(domain: Polygon, thin: Sequence[ThinPart], wall_mm: float) -> dict[float, MultiPolygon]:
    """A clean region parted by its thickness in mm, that of the wall first.

    Raises:
        AnalysisError: a part has no thickness.
    """
    parts: dict[float, list[Polygon]] = {}
    for part in thin:
        if not 0.0 < part.thickness_mm <= wall_mm:
            raise AnalysisError(
                f"a part is {part.thickness_mm} mm thick in a wall of {wall_mm} mm: make it thinner"
            )
        parts.setdefault(part.thickness_mm, []).append(part.polygon)
    parts.pop(wall_mm, None)
    unions = {thickness: shapely.union_all(polygons) for thickness, polygons in parts.items()}
    rest = shapely.difference(domain, shapely.union_all(list(unions.values())))
    return {wall_mm: _areas(rest)} | {
        thickness: _areas(shapely.intersection(domain, union)) for thickness, union in unions.items()
    }


def _areas(region: shapely.Geometry) -> MultiPolygon:
    return MultiPolygon([part for part in shapely.get_parts(region) if isinstance(part, Polygon)])


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
