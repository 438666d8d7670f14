"""What lies around the code: a frame of material, rounded outer corners, mounting holes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry.outline import Arc, Circle, Line, Loop, Region
from perfqr_cad.remedy import Remedy

SQUARE_TOL = 1e-6  # share by which the area of the code's outline may differ from its square


@dataclass(frozen=True)
class Hole:
    """A round mounting hole about (x, y) in the pattern plane, mm."""

    x_mm: float
    y_mm: float
    diameter_mm: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.x_mm) and math.isfinite(self.y_mm)):
            raise DesignError(f"a hole at ({self.x_mm:g}, {self.y_mm:g}) mm is nowhere: give finite numbers")
        if not (math.isfinite(self.diameter_mm) and self.diameter_mm > 0):
            raise DesignError(f"a hole of diameter {self.diameter_mm:g} mm: give a number above 0")

    @property
    def circle(self) -> Circle:
        """Its edge, clockwise as holes run."""
        return Circle((self.x_mm, self.y_mm), self.diameter_mm / 2, ccw=False)


@dataclass(frozen=True)
class Surround:
    """Material around the code's square.

    frame_mm           width of the frame on each side
    corner_radius_mm   of the outer corners
    holes              mounting holes, clear of the code with its quiet zone
    corner_hole_mm     diameter of four more, one in each corner of the frame; None for none
    """

    frame_mm: float = 0.0
    corner_radius_mm: float = 0.0
    holes: tuple[Hole, ...] = ()
    corner_hole_mm: float | None = None

    def __post_init__(self) -> None:
        for name, value in (("frame", self.frame_mm), ("corner radius", self.corner_radius_mm)):
            if not (math.isfinite(value) and value >= 0):
                raise DesignError(f"{name} {value:g} mm is not a length of 0 mm or more")

    @property
    def is_plain(self) -> bool:
        """Whether there is nothing around the code."""
        return not (self.frame_mm or self.corner_radius_mm or self.holes or self.corner_hole_mm)

    def outline(self, size_mm: float) -> Loop:
        """The outer edge around a code of that edge."""
        return _outline(size_mm / 2 + self.frame_mm, self.corner_radius_mm)

    def all_holes(self, size_mm: float) -> tuple[Hole, ...]:
        """The holes around a code of that edge, those in the corners last."""
        if self.corner_hole_mm is None:
            return self.holes
        at = (size_mm + self.frame_mm) / 2
        corners = [(x, y) for y in (at, -at) for x in (-at, at)]
        return (*self.holes, *(Hole(x, y, self.corner_hole_mm) for x, y in corners))


NOTHING = Surround()


def surrounded(
    front: Sequence[Region], size_mm: float, surround: Surround, web_mm: float
) -> tuple[Region, ...]:
    """The front of a code of that edge with what lies around it.

    Raises `DesignError` where the code has no square of material around it, or a web falls below the least.
    """
    if surround.is_plain:
        return tuple(front)
    body, *others = front
    if abs(body.outer.area - size_mm**2) > SQUARE_TOL * size_mm**2:
        raise DesignError(
            "a frame, rounded corners or mounting holes need the quiet zone as material, which an inverted "
            "code leaves open",
            Remedy(tone="normal"),
        )
    outer = surround.outline(size_mm)
    holes = surround.all_holes(size_mm)
    _check(outer, holes, body.holes, size_mm, web_mm)
    return Region(outer, (*body.holes, *(Loop((hole.circle,)) for hole in holes))), *others


def _outline(half_mm: float, radius_mm: float) -> Loop:
    """A square about the origin with rounded corners, counter-clockwise."""
    h, r = half_mm, radius_mm
    if r > h:
        raise DesignError(
            f"a corner radius of {r:g} mm is more than half of {2 * h:g} mm", Remedy(corner_radius_mm=h)
        )
    if r == 0:
        return Loop.from_points([(-h, -h), (h, -h), (h, h), (-h, h)])
    i = h - r
    arcs = [
        Arc((i, -h), (h, -i), (i, -i), ccw=True),
        Arc((h, i), (i, h), (i, i), ccw=True),
        Arc((-i, h), (-h, i), (-i, i), ccw=True),
        Arc((-h, -i), (-i, -h), (-i, -i), ccw=True),
    ]
    segments: list[Line | Arc] = []
    for arc, following in zip(arcs, arcs[1:] + arcs[:1], strict=True):
        segments.append(arc)
        if i > 0:
            segments.append(Line(arc.end, following.start))
    return Loop(tuple(segments))


def _check(outer: Loop, holes: Sequence[Hole], code: Sequence[Loop], size_mm: float, web_mm: float) -> None:
    """Webs between the outline, the mounting holes and the code; the quiet zone stays whole."""
    import shapely

    edge = shapely.Polygon(outer.flatten())
    inner = shapely.MultiPoint(np.vstack([loop.flatten() for loop in code])) if code else shapely.Point(0, 0)
    left = edge.exterior.distance(inner) if edge.covers(inner) else 0.0
    if left < web_mm:
        raise DesignError(
            f"rounded corners leave {left:.3g} mm beside the code, {web_mm:g} mm are needed",
            "a smaller corner radius",
            "a wider frame",
        )
    for i, hole in enumerate(holes):
        at, radius = shapely.Point(hole.x_mm, hole.y_mm), hole.diameter_mm / 2
        name = f"the hole of {hole.diameter_mm:g} mm at ({hole.x_mm:g}, {hole.y_mm:g}) mm"
        rim = edge.exterior.distance(at) - radius if edge.covers(at) else 0.0
        if rim < web_mm:
            raise DesignError(
                f"{name} leaves {max(rim, 0.0):.3g} mm to the edge, {web_mm:g} mm are needed: "
                "move it, make it smaller or take a wider frame"
            )
        outside = math.hypot(*(max(abs(v) - size_mm / 2, 0.0) for v in (hole.x_mm, hole.y_mm)))
        if outside < radius:
            raise DesignError(
                f"{name} cuts into the quiet zone, which ends {size_mm / 2:g} mm from the centre: "
                "move it out (a hole in the corners moves with a wider frame)"
            )
        for other in holes[:i]:
            between = math.dist((hole.x_mm, hole.y_mm), (other.x_mm, other.y_mm)) - radius
            if between - other.diameter_mm / 2 < web_mm:
                raise DesignError(
                    f"{name} leaves {max(between - other.diameter_mm / 2, 0.0):.3g} mm to the one at "
                    f"({other.x_mm:g}, {other.y_mm:g}) mm, {web_mm:g} mm are needed: move one"
                )
