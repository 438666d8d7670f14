"""Design for the reader: walls and thickness that read best at a tilt, with the camera as the judge.

What is filmed are plates drawn from the pattern; the solid is built once, from what comes out of here.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from perfqr_cad.pipeline.resolve import Terms, resolved
from perfqr_cad.progress import tell

if TYPE_CHECKING:
    from perfqr_cad.pattern import Pattern
    from perfqr_cad.scan import Scene

# Values tried for each setting. A lip of one or two printed layers keeps the front edge crisp; beyond 15° of
# draft the back webs, not the walls, limit what is seen.
DRAFTS_DEG = (0.0, 8.0, 12.0, 15.0)
LIPS_MM = (0.0, 0.2, 0.4)
# Plates only: shares of the thickness asked for, down to the thinnest that still prints as a plate.
THICKNESS_SHARES = (1.0, 0.875, 0.75, 0.625, 0.5)
THINNEST_MM = 0.8


def for_reader(terms: Terms, drawn: Pattern, thickness_mm: float, *, plate: bool) -> Terms:
    """The terms with the walls (and, on a plate, the thickness) that read best at `scan_tilt_deg`.

    thickness_mm   of the wall that the code is carved into
    plate          whether that may become thinner

    Bent walls are judged as if they were flat: what walls hide is the same. The terms come back unchanged
    when the part reads at that tilt as it is, or when nothing that was tried reads better.
    """
    from perfqr_cad import scan
    from perfqr_cad.symbol import payload_of

    request, walls = terms.request, terms.walls
    assert request.scan_tilt_deg is not None
    tell("tune for the reader")
    lips_mm = sorted({min(lip, thickness_mm / 2) for lip in LIPS_MM})
    start = {
        "draft_deg": walls.draft_deg,
        "lip_mm": min(walls.lip_mm, thickness_mm / 2),
        "thickness_mm": thickness_mm,
    }
    choices: dict[str, tuple[float, ...]] = {"draft_deg": DRAFTS_DEG, "lip_mm": tuple(lips_mm)}
    if plate:
        shares = (max(THINNEST_MM, round(share * thickness_mm, 2)) for share in THICKNESS_SHARES)
        choices["thickness_mm"] = tuple(sorted({*shares, thickness_mm}))

    def stage(settings: Mapping[str, float]) -> Scene:
        walls = {"draft_deg": settings["draft_deg"], "lip_mm": settings["lip_mm"]}
        return scan.plate_scene(drawn, settings["thickness_mm"], **walls)

    payload = payload_of(drawn.symbol).data
    goal = scan.Goal(drawn.symbol.matrix, drawn.module_mm, payload, request.scan_tilt_deg)
    weighs_most = "thickness_mm" if plate else "draft_deg"
    best, _ = scan.improve(stage, start, choices, goal, weighs_most=weighs_most)
    found = replace(request, **(best.settings if plate else _walls(best.settings)))
    return resolved(found, or_straight=walls.or_straight)


def _walls(settings: Mapping[str, float]) -> dict[str, float]:
    """The settings that a wall of given thickness has."""
    return {name: value for name, value in settings.items() if name != "thickness_mm"}
