# pyright: reportAttributeAccessIssue=false
# The modeller's stubs are incomplete.
"""How the pattern plane lies in a wall of material, as the kernel sees it.

A chart maps pattern points to space at any depth behind the front: depth 0 is the front face, depth
`thickness_mm` the back face. It lays segments of the pattern on those levels as exact or fitted curves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from perfqr_cad.pattern.outline import Loop, Segment

from .occ import TOLERANCE_MM, Array

if TYPE_CHECKING:
    from OCP.Geom import Geom_Curve, Geom_Surface
    from OCP.Geom2d import Geom2d_Curve


@dataclass(frozen=True)
class Trace:
    """A segment of the pattern laid on one level of the wall; its curve runs as the segment does.

    curve         the curve in space and the parameters where the segment starts and ends, first < last
    image         the same in the parameters of the level's surface; None on planes, or where no face lies
    tolerance_mm  how far the curve may stray from the surface and from the image's points
    """

    curve: Geom_Curve
    first: float
    last: float
    image: Geom2d_Curve | None = None
    tolerance_mm: float = TOLERANCE_MM


@dataclass(frozen=True)
class Wall:
    """The surface between a segment on one level and on the next, with the images of its four edges.

    outward  whether the surface's own normal points out of the material (to the right of travel)
    images   of the upper edge, the lower edge, and the two side edges at the segment's start and end
             (side edges run downwards, by arc length); None on a plane, which needs no images
    """

    surface: Geom_Surface
    outward: bool
    images: tuple[Geom2d_Curve, Geom2d_Curve, Geom2d_Curve, Geom2d_Curve] | None = None


@dataclass(frozen=True)
class Level:
    """Loops of the pattern at one depth: on a face (front, back, floor of a pocket) or between faces."""

    depth_mm: float
    on_face: bool


@dataclass(frozen=True)
class Well:
    """One loop followed into the material, which lies to the left of travel.

    loops   one for each level, the uppermost first, with equally many segments
    levels  their depths: from the front, or from the level of the bars for what stands below it
    floor   number of the floor that the last loop bounds (a blind pocket's), from 1; 0: none
    crest   number of the raised face that the first loop bounds (a letter's), from 1; 0: none
    piece   which piece of the front face a loop at the front bounds; below a crest, the last one
    part_of the well from front to back of which this is a storey: curves are fitted to the whole
    """

    loops: tuple[Loop, ...]
    levels: tuple[Level, ...]
    floor: int = 0
    crest: int = 0
    piece: int = 0
    part_of: Well | None = None

    def stacks(self) -> list[tuple[Segment, ...]]:
        """The segments that lie above one another."""
        return list(zip(*(loop.segments for loop in self.loops), strict=True))


@dataclass(frozen=True)
class Column:
    """What stands on one segment of a loop: its traces level by level, and the walls between them."""

    traces: tuple[Trace, ...]
    walls: tuple[Wall, ...]

    def storey(self, first: int, levels: int) -> Column:
        """The part from one level on."""
        last = first + levels
        if first == 0 and last == len(self.traces):
            return self
        return Column(self.traces[first:last], self.walls[first : last - 1])


class Chart(Protocol):
    """What a punch needs to know of a wall of material."""

    @property
    def thickness_mm(self) -> float: ...

    @property
    def whole_circles(self) -> bool:
        """Whether a circle stays one closed segment; else it is laid as two half-circles."""
        ...

    def points(self, uv: Array, depth_mm: float) -> Array:
        """Points (k, 3) in space of (k, 2) pattern points at a depth."""
        ...

    def surface(self, depth_mm: float) -> Geom_Surface:
        """The surface of a face at that depth."""
        ...

    def towards_reader(self, depth_mm: float) -> bool:
        """Whether the own normal of `surface(depth_mm)` points towards the reader."""
        ...

    def lay(self, stacks: Sequence[tuple[Segment, ...]], levels: tuple[Level, ...]) -> list[Column]:
        """Columns on stacks of segments, one segment for each level, front first."""
        ...
