"""What a hand does to a part: where it presses, and where it holds against that.

Regions are areas of the pattern plane (mm). Material in them takes the force in proportion to its area; holes
take none.
"""

from __future__ import annotations

from dataclasses import dataclass

import shapely
from shapely.geometry import Point, Polygon, box
from shapely.geometry.base import BaseGeometry

from perfqr_cad.structure.handling.named_loads import FINGERTIP_PAD_MM, HandlingLoad

EDGE_SHARE = 0.08  # of the part's length: the strip along an edge that a hand takes hold of
LINE_SHARE = 0.04  # of its length: half the strip across the middle that three-point bending presses


@dataclass(frozen=True)
class Push:
    """A force on `loaded`, balanced on `held`; None: on the front as a whole, or by the supports."""

    loaded: BaseGeometry | None
    held: BaseGeometry
    words: str

    @property
    def at_mm(self) -> tuple[float, float] | None:
        """The middle of what is pressed."""
        return None if self.loaded is None else (self.loaded.centroid.x, self.loaded.centroid.y)


def pushes(load: HandlingLoad, domain: Polygon) -> tuple[Push, ...]:
    """The ways in which a load can act on a part. A fingertip's places are sought elsewhere: see
    `fingertip`."""
    left, low, right, high = domain.bounds
    wide, tall = right - left, high - low
    strip_x, strip_y = EDGE_SHARE * wide, EDGE_SHARE * tall
    edges = {
        "left": box(left, low, left + strip_x, high),
        "right": box(right - strip_x, low, right, high),
        "lower": box(left, low, right, low + strip_y),
        "upper": box(left, high - strip_y, right, high),
    }
    across = {"left": "right", "right": "left", "lower": "upper", "upper": "lower"}
    match load.name:
        case "weight":
            return tuple(Push(None, edges[name], f"held at the {name} edge") for name in ("left", "lower"))
        case "push":
            return tuple(
                Push(edges[name], edges[across[name]], f"on the {name} edge, held at the {across[name]} one")
                for name in edges
            )
        case "bend":
            x, y = left + wide / 2, low + tall / 2
            upright = box(x - LINE_SHARE * wide, low, x + LINE_SHARE * wide, high)
            level = box(left, y - LINE_SHARE * tall, right, y + LINE_SHARE * tall)
            return (
                Push(upright, edges["left"] | edges["right"], "across the middle, upright"),
                Push(level, edges["lower"] | edges["upper"], "across the middle, level"),
            )
        case "twist":
            pads = _corner_pads(domain)
            return (Push(pads[0], shapely.union_all(pads[1:]), "at one corner, held at the others"),)
        case "peel":
            halves = {
                "left": box(left + wide / 2, low, right, high),
                "right": box(left, low, right - wide / 2, high),
                "lower": box(left, low + tall / 2, right, high),
                "upper": box(left, low, right, high - tall / 2),
            }
            return tuple(
                Push(edges[name], held, f"at the {name} edge, half of it still stuck")
                for name, held in halves.items()
            )
        case "pressure":
            return (Push(None, rim(domain), "on the whole front"),)
        case _:
            return ()


def fingertip(at_mm: tuple[float, float], rim: BaseGeometry) -> Push:
    """A fingertip at a place of a part that is held by its rim."""
    return Push(Point(at_mm).buffer(FINGERTIP_PAD_MM / 2, quad_segs=4), rim, "")


def rim(domain: Polygon) -> BaseGeometry:
    """The strip along the outer boundary that a hand holds."""
    hull = shapely.convex_hull(domain)
    left, low, right, high = domain.bounds
    return hull.difference(hull.buffer(-EDGE_SHARE * min(right - left, high - low)))


def _corner_pads(domain: Polygon) -> list[BaseGeometry]:
    """Fingertips on the material nearest to the four corners, counter-clockwise from the lower left."""
    left, low, right, high = domain.bounds
    inner = shapely.convex_hull(domain).buffer(-FINGERTIP_PAD_MM / 4)
    pads: list[BaseGeometry] = []
    for corner in ((left, low), (right, low), (right, high), (left, high)):
        on_part = shapely.shortest_line(inner if not inner.is_empty else domain, Point(corner))
        pads.append(Point(on_part.coords[0]).buffer(FINGERTIP_PAD_MM / 2))
    return pads
