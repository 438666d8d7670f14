"""Webs between holes that widen towards the back: what the taper adds to stress and deflection, at most."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry import Polygon

from perfqr_cad.errors import AnalysisError
from perfqr_cad.structure.mesh.triangle import Floats, Ints

# Widths of webs in front, over that of the web that loses most, at which they are told apart.
STEPS = (0.8, 1.0, 1.15, 1.35, 1.7, 2.4, 4.0)
WIDER = 1.05  # than the least web: what is no wider does not flare
ROUNDING = 1e-3  # of a radius: a web as wide as a step counts as that wide


@dataclass(frozen=True)
class Taper:
    """Bending stress and deflection of the narrowest web over those of its rectangle with upright walls.

    A section as wide as a at the front and b at the back has I = t³ (a² + 4ab + b²) / 36(a + b), its centre
    t (2a + b) / 3(a + b) above the back (Roark's Formulas for Stress and Strain, table A.1, trapezoid). Wider
    webs lose a smaller share, so both figures are upper bounds for a part.
    """

    stress: float = 1.0
    deflection: float = 1.0
    area: float = 1.0

    @staticmethod
    def of(web_mm: float, flare_mm: float) -> Taper:
        """That of a web which is `web_mm` wide at the back, and wider in front by the flare on each side.

        Raises:
            AnalysisError: the web has no width, or the flare is negative.
        """
        if not (math.isfinite(web_mm) and web_mm > 0.0):
            raise AnalysisError(f"web is {web_mm} mm; it must be a positive number")
        if not (math.isfinite(flare_mm) and flare_mm >= 0.0):
            raise AnalysisError(f"flare is {flare_mm} mm; it must be 0 or a positive number")
        a, b = web_mm + 2.0 * flare_mm, web_mm
        inertia = (a * a + 4.0 * a * b + b * b) / (36.0 * (a + b))  # of a unit thickness
        from_back = (2.0 * a + b) / (3.0 * (a + b))
        return Taper(
            stress=from_back / inertia / (6.0 / a), deflection=a / 12.0 / inertia, area=(a + b) / (2.0 * a)
        )


STRAIGHT = Taper()


@dataclass(frozen=True)
class Webs:
    """Webs of one range of widths in front, and what the taper of their walls adds at most."""

    elements: Ints
    taper: Taper


def webs(region: Polygon, places: Floats, web_mm: float, flare_mm: float) -> list[Webs]:
    """The elements whose centres are at some places (k, 2), by the width of the web that they lie in.

    An edge of a hole is set back by the flare at most, and by less where a web would be narrower at the back
    than `web_mm`: a web a wide in front is max(a - 2·flare, min(a, web)) wide there. Webs are told apart by
    the widest of some discs in the region that hold a place. Few steps keep tiles of one pattern alike.
    """
    worst = web_mm + 2.0 * flare_mm
    steps = [0.0, *(share * worst for share in STEPS if share * worst > WIDER * web_mm), math.inf]
    steps.insert(1, WIDER * web_mm)
    bins = np.zeros(len(places), np.int64)
    for number, width in enumerate(steps[1:-1], start=1):
        radius = 0.5 * (1.0 - ROUNDING) * width
        opened = shapely.buffer(shapely.buffer(region, -radius, quad_segs=4), radius, quad_segs=4)
        if opened.is_empty:
            break
        shapely.prepare(opened)
        bins[shapely.contains_xy(opened, places[:, 0], places[:, 1])] = number
    found: list[Webs] = []
    for number in np.unique(bins).tolist():
        front = min(max(steps[number], worst), steps[number + 1])
        back = max(front - 2.0 * flare_mm, min(front, web_mm))
        found.append(Webs(np.flatnonzero(bins == number), Taper.of(back, 0.5 * (front - back))))
    return found
