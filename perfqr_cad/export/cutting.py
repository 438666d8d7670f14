"""What a cutter is given of a design: closed loops in the plane, mm, by what is done along them.

Cutters know one thickness. Bars behind the face are cut like all other material, so that the sheet stays one
piece, and holes go straight through; `notes` says where the part itself is made otherwise. A part that is
made for a cutter (`--process laser`) is what is cut.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from perfqr_cad.errors import DesignError
from perfqr_cad.export.design_view import DesignView, face
from perfqr_cad.geometry import Circle, Loop, Region
from perfqr_cad.geometry.mirror import mirrored
from perfqr_cad.remedy import Remedy

PATH_TOL_MM = 0.002  # of a path beside a curve, which is one of chords
SHARPEST = 5.0  # mitre limit of a path around a corner, in kerfs from it
SAME_VOLUME = 1e-6  # relative: a part of this volume is the plain extrusion of its outline


@dataclass(frozen=True)
class Cut:
    """Loops in the order in which they are worked: what is inside first, since the outline frees the part.

    engrave  outlines of the letters; holes and outline are cut through
    """

    engrave: tuple[Loop, ...]
    holes: tuple[Loop, ...]
    outline: Loop

    @property
    def through(self) -> tuple[Loop, ...]:
        """All that is cut."""
        return (*self.holes, self.outline)


def cut(design: DesignView, kerf_mm: float = 0.0) -> Cut:
    """The loops of the whole material, recessed bars included, and of the caption.

    With a kerf the paths of what is cut through run half of it beside the part. Raises `DesignError` for a
    hole that a kerf so wide cannot make.
    """
    region = face(design).region
    letters = tuple(loop for letter in engraving(design) for loop in (*letter.holes, letter.outer))
    if not kerf_mm:
        return Cut(letters, region.holes, region.outer)
    (outline,) = beside([region.outer], kerf_mm / 2)
    return Cut(letters, beside(region.holes, -kerf_mm / 2), outline)


def beside(loops: Iterable[Loop], by_mm: float) -> tuple[Loop, ...]:
    """Loops so far outside others, or inside them where it is less than 0; round where they are circles.

    >>> hole = Loop.from_points([(0, 0), (2, 0), (2, 2), (0, 2)]).oriented(ccw=False)
    >>> round(beside([hole], -0.5)[0].area, 9)
    -1.0
    """
    return tuple(_beside(loop, by_mm) for loop in loops)


def _beside(loop: Loop, by_mm: float) -> Loop:
    import shapely

    match loop.segments:
        case (Circle(centre, radius, ccw),) if radius + by_mm > 0:
            return Loop((Circle(centre, radius + by_mm, ccw),))
        case _:
            flat = shapely.Polygon(loop.flatten(PATH_TOL_MM))
            moved = flat.buffer(by_mm, join_style="mitre", mitre_limit=SHARPEST).simplify(PATH_TOL_MM)
    if not isinstance(moved, shapely.Polygon) or moved.is_empty:
        x, y = flat.centroid.x, flat.centroid.y
        raise DesignError(
            f"the hole at ({x:.1f}, {y:.1f}) is narrower than a kerf of {2 * abs(by_mm):g} mm",
            Remedy(kerf_mm=None),
            "a larger part",
        )
    return Loop.from_points(shapely.get_coordinates(moved.exterior)[:-1]).oriented(ccw=loop.area > 0)


def engraving(design: DesignView) -> tuple[Region, ...]:
    """The letters of the caption where they stand on the part, raised or sunk; none without a caption."""
    letters = design.solid.letters
    return tuple(mirrored(letter) for letter in letters) if design.placement.is_turned else letters


def is_extrusion(design: DesignView) -> bool:
    """Whether the outline raised by the thickness, and the letters by their relief, is the whole part."""
    upright = design.placement.is_flat and not design.placement.is_turned
    return upright and _is_volume(design, design.pattern.region.area)


def notes(design: DesignView) -> tuple[str, ...]:
    """How what is cut along the loops differs from the part."""
    found = ["letters are outlines to engrave"] if engraving(design) else []
    if is_extrusion(design):
        return tuple(found)
    bars = design.pattern.recessed
    if not design.placement.is_flat:
        found.append("drawn flat")
    if bars:
        found.append("recessed bars are as thick as the sheet")
    thickness = design.placement.thickness_mm
    behind_mm3 = sum(math.dist(b.start, b.end) * b.width_mm * (b.height_mm or thickness) for b in bars)
    straight_mm2 = sum(piece.area for piece in design.pattern.front) + behind_mm3 / thickness
    if design.placement.is_flat and not design.solid.is_carved and not _is_volume(design, straight_mm2):
        found.append("holes go straight through")
    return tuple(found)


def _is_volume(design: DesignView, area_mm2: float) -> bool:
    """Whether the part has the volume of so much area, as thick as it is, and of its letters."""
    letters_mm3 = sum(letter.area for letter in engraving(design)) * design.solid.relief_mm
    plain_mm3 = area_mm2 * design.placement.thickness_mm + letters_mm3
    return math.isclose(plain_mm3, design.solid.volume_mm3, rel_tol=SAME_VOLUME)
