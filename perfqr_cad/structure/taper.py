"""Webs between holes that widen towards the back: what the taper adds to stress and deflection, at most."""

from __future__ import annotations

import math
from dataclasses import dataclass

from perfqr_cad.errors import AnalysisError


@dataclass(frozen=True)
class Taper:
    """Bending stress and deflection of the narrowest web over those of its rectangle with upright walls.

    A section as wide as a at the front and b at the back has I = t³ (a² + 4ab + b²) / 36(a + b), its centre
    t (2a + b) / 3(a + b) above the back (Roark's Formulas for Stress and Strain, table A.1, trapezoid). Wider
    webs lose a smaller share, so both figures are upper bounds for a part.
    """

    stress: float = 1.0
    deflection: float = 1.0

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
        return Taper(stress=from_back / inertia / (6.0 / a), deflection=a / 12.0 / inertia)


STRAIGHT = Taper()
