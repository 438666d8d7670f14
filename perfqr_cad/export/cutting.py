"""What a cutter is given of a design: closed loops in the plane, mm, by what is done along them.

Cutters know one thickness. Bars behind the face are cut like all other material, so that the sheet stays one
piece, and holes go straight through; `notes` says where the part itself is made otherwise.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from perfqr_cad.export.design_view import DesignView, face
from perfqr_cad.geometry import Loop, Region
from perfqr_cad.geometry.mirror import mirrored

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


def cut(design: DesignView) -> Cut:
    """The loops of the whole material, recessed bars included, and of the caption."""
    region = face(design).region
    letters = tuple(loop for letter in engraving(design) for loop in (*letter.holes, letter.outer))
    return Cut(letters, region.holes, region.outer)


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
