"""Design for the reader: walls and thickness that read best at a tilt, with the camera as the judge."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from perfqr_cad.progress import tell
from perfqr_cad.request import Request

if TYPE_CHECKING:
    from perfqr_cad.pattern import Pattern
    from perfqr_cad.surface import Placement, Triangles

    Carve = Callable[[Request], tuple[Triangles, Placement]]

# Values tried for each setting. A lip of two printed layers keeps the front edge crisp; beyond 15° of draft
# the back webs, not the walls, limit what is seen.
DRAFTS_DEG = (0.0, 8.0, 15.0)
LIP_MM = 0.4
# Plates only: shares of the thickness asked for, down to the thinnest that still prints as a plate.
THICKNESS_SHARES = (1.0, 0.5)
THINNEST_MM = 0.8


def for_reader(request: Request, drawn: Pattern, payload: bytes, carve: Carve, *, plate: bool) -> Request:
    """The request with the walls (and, on a plate, the thickness) that read best at `scan_tilt_deg`.

    `carve` makes the part of a request. The request comes back unchanged when the part reads at that tilt
    as it is, or when nothing that was tried reads better.
    """
    from perfqr_cad.scan import Goal, improve

    assert request.scan_tilt_deg is not None
    tell("tune for the reader")
    start = {
        "draft_deg": request.draft_deg,
        "lip_mm": min(request.lip_mm, request.thickness_mm / 2),
        "thickness_mm": request.thickness_mm,
    }
    choices: dict[str, tuple[float, ...]] = {
        "draft_deg": DRAFTS_DEG,
        "lip_mm": (0.0, min(LIP_MM, request.thickness_mm / 2)),
    }
    if plate:
        shares = (max(THINNEST_MM, share * request.thickness_mm) for share in THICKNESS_SHARES)
        choices["thickness_mm"] = tuple(sorted({*shares, request.thickness_mm}))

    def build(settings: Mapping[str, float]) -> tuple[Triangles, Placement]:
        return carve(replace(request, **settings))

    goal = Goal(drawn.symbol.matrix, drawn.module_mm, payload, request.scan_tilt_deg)
    best, _ = improve(build, start, choices, goal)
    return replace(request, **best.settings)
