"""A small part with every kind of segment, and a code of version 1, made without the chain."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest
import segno
import shapely
import shapely.affinity

from perfqr_cad.geometry import Arc, Bezier, Circle, Line, Loop, Region, Triangles
from perfqr_cad.pattern import Bridge, PatternSpec
from perfqr_cad.surface import Cylinder, Placement, Plane

IVORY, BLACK = (0.92, 0.92, 0.90), (0.05, 0.05, 0.06)
BACKING_MM = 1.0


@dataclass(frozen=True)
class Body:
    triangles: Triangles
    name: str
    colour: tuple[float, float, float]
    volume_mm3: float
    extras: tuple[Body, ...] = ()
    letters: tuple[Region, ...] = ()
    relief_mm: float = 0.0
    is_carved: bool = False

    @property
    def bbox_mm(self) -> tuple[list[float], list[float]]:
        points = self.triangles.vertices
        return points.min(axis=0).tolist(), points.max(axis=0).tolist()


@dataclass(frozen=True)
class Drawn:
    """What exporters read of a pattern."""

    region: Region
    bridges: tuple[Bridge, ...] = ()
    spec: PatternSpec = field(default_factory=PatternSpec)
    size_mm: float = 0.0

    @property
    def front(self) -> tuple[Region, ...]:
        return (self.region,)

    @property
    def recessed(self) -> tuple[Bridge, ...]:
        return tuple(bridge for bridge in self.bridges if bridge.is_recessed)

    @property
    def polygon(self) -> shapely.Polygon:
        return self.region.polygon()


@dataclass(frozen=True)
class Part:
    """A design as exporters see it."""

    pattern: Drawn
    placement: Placement
    solid: Body
    stress: None = None
    reinforcement: None = None
    scan: None = None
    facts: dict[str, Any] = field(default_factory=lambda: {"payload": "TEXT", "files": []})

    def certificate(self) -> dict[str, Any]:
        return self.facts

    def with_backing(self) -> Part:
        width = shapely.box(*self.pattern.polygon.bounds)
        plate = extrude(width, Plane(BACKING_MM), lift_mm=-BACKING_MM)
        backing = Body(plate, "backing", BLACK, plate.volume_mm3)
        return replace(self, solid=replace(self.solid, extras=(backing,)))

    def with_letter(self, relief_mm: float) -> Part:
        """An O of 0.64 mm² on the plate, raised or sunk, in the volume though not in the triangles."""
        letter = letter_o()
        volume_mm3 = self.solid.volume_mm3 + letter.area * relief_mm
        solid = replace(self.solid, letters=(letter,), relief_mm=relief_mm, volume_mm3=volume_mm3)
        return replace(self, solid=solid)


def extrude(polygon: shapely.Polygon, placement: Placement, lift_mm: float = 0.0) -> Triangles:
    """The closed wall over a polygon: its triangles in front and behind, quads around every ring."""
    triangles = shapely.orient_polygons(shapely.constrained_delaunay_triangles(polygon)).geoms
    corners = np.round([shapely.get_coordinates(t)[:3] for t in triangles], 9)
    uv, index = np.unique(corners.reshape(-1, 2), axis=0, return_inverse=True)
    front = index.reshape(-1, 3)
    edges = front[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    rim = edges[~np.isin(edges @ [len(uv), 1], edges @ [1, len(uv)])]
    a, b, back = rim[:, 0], rim[:, 1], len(uv)
    walls = np.vstack([np.column_stack([b, a, a + back]), np.column_stack([b, a + back, b + back])])
    depth = np.full(len(uv), placement.thickness_mm)
    vertices = np.vstack([placement.point(uv), placement.at_depth(uv, depth)]) + np.array([0, 0, lift_mm])
    return Triangles(vertices, np.vstack([front, front[:, ::-1] + back, walls]))


def part(region: Region, placement: Placement, bridges: tuple[Bridge, ...] = ()) -> Part:
    triangles = extrude(region.polygon(), placement)
    volume_mm3 = region.area * placement.thickness_mm if placement.is_flat else triangles.volume_mm3
    body = Body(triangles, "test-part", IVORY, volume_mm3)
    return Part(Drawn(region, bridges), placement, body)


def curved_region() -> Region:
    """A 20 × 10 plate with one rounded corner, a circular hole, a Bézier hole and a slot of two arcs."""
    outer = Loop(
        (
            Line((-10, -5), (10, -5)),
            Line((10, -5), (10, 3)),
            Arc((10, 3), (8, 5), (8, 3), True),
            Line((8, 5), (-10, 5)),
            Line((-10, 5), (-10, -5)),
        )
    )
    drop = Loop((Bezier((0, 2), (2, 2), (2, -2), (0, -2)), Bezier((0, -2), (-2, -2), (-2, 2), (0, 2))))
    slot = Loop(
        (
            Line((5, 1), (7, 1)),
            Arc((7, 1), (7, -1), (7, 0), False),
            Line((7, -1), (5, -1)),
            Arc((5, -1), (5, 1), (5, 0), False),
        )
    )
    holes = tuple(loop.oriented(ccw=False) for loop in (Loop((Circle((-6, 0), 1.5, False),)), drop, slot))
    return Region(outer, holes)


def letter_o() -> Region:
    """A square ring about (3.5, -3.5): an outline and a counter."""

    def square(half: float) -> list[tuple[float, float]]:
        return [(3.5 + x * half, -3.5 + y * half) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]

    return Region(Loop.from_points(square(0.5)), (Loop.from_points(square(0.3)[::-1]),))


def code_region(text: str, size_mm: float) -> Region:
    """The light modules of a code: corners joined, finders held by a bar, other islands left out."""
    dark = np.pad(np.array([list(row) for row in segno.make(text, error="M", micro=False).matrix], bool), 4)
    n, m = len(dark), size_mm / len(dark)
    squares = [shapely.box(c * m, -(r + 1) * m, (c + 1) * m, -r * m) for r, c in np.argwhere(~dark).tolist()]
    joined = shapely.unary_union([square.buffer(0.08 * m, join_style="mitre") for square in squares])
    rings = [(4, 4), (n - 11, 4), (4, n - 11)]  # a bar over each finder's dark ring, near its corner
    bars = [shapely.box((c + 1.4) * m, -(r + 1.1) * m, (c + 1.6) * m, -r * m) for c, r in rings]
    whole = shapely.unary_union([joined, *bars])
    largest = max(whole.geoms, key=lambda p: p.area) if whole.geom_type == "MultiPolygon" else whole
    return Region.from_polygon(shapely.affinity.translate(largest, -size_mm / 2, size_mm / 2))


@pytest.fixture(scope="session")
def plate() -> Part:
    bridges = (
        Bridge((-6, -1.5), (-6, 1.5), 0.8, "connectivity", 1.0),
        Bridge((5, 0), (7, 0), 0.5, "structural", 2.0),
    )
    return part(curved_region(), Plane(2.0), bridges)


@pytest.fixture(scope="session")
def code() -> Part:
    return part(code_region("TEXT", 30.0), Plane(1.2))


@pytest.fixture(scope="session")
def wrapped() -> Part:
    region = Region.from_polygon(curved_region().polygon().segmentize(1.0))
    return part(region, Cylinder(12.0, 1.0))
