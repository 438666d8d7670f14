"""How the finder rings are held: from bars that read from furthest aside to bars that bear most.

The light ring of a finder floats in its slot and hangs on bars. From one side it is a cantilever: a fingertip
bends its bars by the length of their slot and half the ring, and twists a bar that is not in the middle. On
two sides it is a beam, which bears several times as much. These are estimates: they put the holds in order,
and the structure layer has the last word.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

from perfqr_cad.pattern.joining import finder, rings
from perfqr_cad.pattern.spec import ON_TWO_SIDES
from perfqr_cad.pipeline.request import Request
from perfqr_cad.pipeline.resolve import LAYER_SHARE

RING = 5.0  # modules across the light ring of a finder, 7 with its dark ring
SHADE_MM = 1.6  # depth of a bar's top from which its slot is dark; the bars of thin plates lie less deep
STEP_MM = 0.4  # between thicknesses
THICKEST_MM = 4.0  # holes of 1.6 mm in a thicker plate are hidden at 20°
# Stress by a fingertip (8 mm pad) on the far side of a ring over that of one on its middle. The middle's is
# the estimate's to 2 % (24 MPa under 5 N, 3-D elements; two bars 1.2 mm high in a plate of 2.4 mm).
WORST_PLACE = 1.3
# Newtons a MPa allowed, over the square of the bars' height and of the wall's thickness, mm, by the
# certificate: the lower left ring's bars give way first, or a ring itself. Modules of 1.3 to 1.6 mm.
BARS_ON_TWO_SIDES, RING_ON_TWO_SIDES = 0.11, 0.048
HOPEFUL = 2.0  # times its estimate: a hold that would have to bear more than that is not tried
USUAL_MODULE_MM = 1.6  # bars and levers grow alike, so that the estimate hardly depends on it
# Of PLA in a flat plate: its yield stress, what the process leaves of it, a factor of 2 and the margin of the
# certificate (docs/strength.md).
ALLOWABLE_MPA = 50.0 * 0.9 * 0.9 / 2.0 / 1.15


@dataclass(frozen=True)
class RingHold:
    """Bars of the finder rings in a plate; `width_mm` None: as wide as reads well.

    bars   of each ring, as in `PatternSpec`
    """

    bars: int
    height_mm: float
    width_mm: float | None
    thickness_mm: float

    def bears_n(self, module_mm: float, allowable_mpa: float = ALLOWABLE_MPA) -> float:
        """Force of a fingertip on the weakest finder ring, N.

        >>> [round(RingHold(bars, 0.4, None, 1.6).bears_n(1.62), 2) for bars in (1, 2, 3)]
        [0.14, 0.3, 0.31]
        """
        if self.bars == ON_TWO_SIDES:
            bars, ring = BARS_ON_TWO_SIDES * self.height_mm**2, RING_ON_TWO_SIDES * self.thickness_mm**2
            return allowable_mpa * min(bars, ring)
        wide_mm = min(rings.WIDE * module_mm, rings.WIDE_MM) if self.width_mm is None else self.width_mm
        straight_mm = (RING - 2 * finder.CLEAR) * module_mm
        width_mm = min(self.bars * wide_mm, straight_mm)
        off_mm = (straight_mm - width_mm) / 2  # of the bar at the lower left from the middle of its side
        lever_mm = RING / 2 * module_mm
        lower = _stress_mpa(
            min(rings.SLOT * module_mm, rings.DARK_MM) + lever_mm, off_mm, width_mm, self.height_mm
        )
        upper = _stress_mpa(module_mm + lever_mm, off_mm if self.bars == 1 else 0.0, width_mm, self.height_mm)
        return allowable_mpa / WORST_PLACE / max(lower, upper)

    def applied(self, request: Request) -> Request:
        """The request with these bars and this thickness."""
        return replace(
            request,
            bars=self.bars,
            bar_height_mm=self.height_mm,
            bar_width_mm=self.width_mm,
            thickness_mm=self.thickness_mm,
        )


def front(thickness_mm: float, nozzle_mm: float) -> tuple[RingHold, ...]:
    """Holds in the order in which readers lose them: one line a ring, bars on two sides, then thicker plates.

    Higher bars come with thicker plates, for their tops must stay in the shade. Size is no part of it: bars
    and levers grow alike.
    """
    holds = [
        RingHold(1, LAYER_SHARE * nozzle_mm, nozzle_mm, thickness_mm),
        RingHold(ON_TWO_SIDES, nozzle_mm, None, thickness_mm),
    ]
    steps = max(0, math.floor((THICKEST_MM - thickness_mm) / STEP_MM + 1e-9))
    thicker = [round(thickness_mm + k * STEP_MM, 6) for k in range(1, steps + 1)]
    holds += [
        RingHold(ON_TWO_SIDES, round(t - SHADE_MM, 6), None, t) for t in thicker if t - SHADE_MM > nozzle_mm
    ]
    return tuple(holds)


def holding(
    request: Request, module_mm: float, force_n: float, allowable_mpa: float = ALLOWABLE_MPA
) -> tuple[Request, ...]:
    """Requests whose rings should bear a fingertip's force, those that read from furthest aside first.

    The strongest alone when none does: then a factor, a thickness or a reader has to give. A request that
    names its bars is left as it is.
    """
    named = any(value is not None for value in (request.bars, request.bar_height_mm, request.bar_width_mm))
    if named or request.finder != "recessed":
        return (request,)
    holds = front(request.thickness_mm, request.nozzle_mm)
    enough = [hold for hold in holds if hold.bears_n(module_mm, allowable_mpa) >= force_n]
    strongest = max(holds, key=lambda hold: hold.bears_n(module_mm, allowable_mpa))
    return tuple(hold.applied(request) for hold in enough or [strongest])


def attempts(request: Request, *, plate: bool = True) -> Iterator[Request]:
    """The request as it is, then, where a hand's force is asked for, with other holds of the rings: those
    that read from furthest aside first, without those that are far too weak by the estimate.

    plate   whether the request's thickness is that of the part; a host keeps its own
    """
    yield request
    named = any(value is not None for value in (request.bars, request.bar_height_mm, request.bar_width_mm))
    if request.handling_n is None or named or request.finder != "recessed":
        return
    for hold in front(request.thickness_mm, request.nozzle_mm):
        if not plate and hold.thickness_mm != request.thickness_mm:
            continue
        if HOPEFUL * hold.bears_n(USUAL_MODULE_MM) >= request.handling_n:
            yield hold.applied(request)


def _stress_mpa(lever_mm: float, twist_mm: float, width_mm: float, height_mm: float) -> float:
    """Von Mises' stress of 1 N at the root of a flat bar, MPa (Roark, rectangular bars in torsion)."""
    bending = 6 * lever_mm / (width_mm * height_mm**2)
    long, short = max(width_mm, height_mm), min(width_mm, height_mm)
    torsion = twist_mm * (3 + 1.8 * short / long) / (long * short**2)
    return math.hypot(bending, math.sqrt(3) * torsion)
