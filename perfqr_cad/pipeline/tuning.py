"""Design for the reader: bars for a grade, walls and thickness for a tilt, with the camera as the judge.

What is filmed are plates drawn from the pattern; the solid is built once, from what comes out of here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from perfqr_cad.pipeline.request import AUTO
from perfqr_cad.pipeline.resolve import Terms, resolved
from perfqr_cad.progress import tell

if TYPE_CHECKING:
    from perfqr_cad.capture import Art
    from perfqr_cad.pattern import Pattern
    from perfqr_cad.pipeline.source import Source
    from perfqr_cad.scan import Scene


# Values tried for each setting. A lip of one or two printed layers keeps the front edge crisp; beyond 15° of
# draft the back webs, not the walls, limit what is seen.
DRAFTS_DEG = (0.0, 8.0, 12.0, 15.0)
LIPS_MM = (0.0, 0.2, 0.4)
# Plates only: shares of the thickness asked for, down to the thinnest that still prints as a plate.
THICKNESS_SHARES = (1.0, 0.875, 0.75, 0.625, 0.5)
THINNEST_MM = 0.8
# Shares of the way from the art to the plain code that are tried, and what decoders must read then.
LEGIBILITIES = (0.0, 0.5, 0.67, 0.8, 1.0)
ALL_FRONTALLY, ASIDE_DEG, THREE_ASIDE = 4, 20.0, 3
# Ways to hold the finder rings, those that read from furthest aside first. A pinched slot spoils its corner
# for a verifier, which looks straight at it and finds it narrow; flush bars of one line it hardly sees in
# large modules.
FINDERS = ("recessed", "panel")


def for_legibility(
    terms: Terms, found: Source, draw: Callable[[Art], Pattern], thickness_mm: float
) -> Art | None:
    """The art of a picture as far on its way to the plain code as was asked for.

    With `auto` the panel judges plates drawn from the art: the least share with which four decoders read
    frontally and three of them at 20° from two sides; the best one where none does.
    """
    from perfqr_cad.capture.clearer import clearer
    from perfqr_cad.errors import DesignError

    if found.capture is None:
        return None
    art, asked = found.capture.art, terms.request.legibility
    if asked != AUTO:
        return clearer(art, found.symbol, float(asked or 0.0))
    best: tuple[int, Art] = (-1, art)
    for share in LEGIBILITIES:
        tell(f"legibility {share:g}: the panel")
        changed = clearer(art, found.symbol, share)
        try:
            drawn = draw(changed)
        except DesignError:  # webs that this art cannot have
            continue
        frontal, aside = _readers(terms, drawn, thickness_mm)
        if frontal >= ALL_FRONTALLY and aside >= THREE_ASIDE:
            return changed
        if frontal + aside > best[0]:
            best = frontal + aside, changed
    return best[1]


def _readers(terms: Terms, drawn: Pattern, thickness_mm: float) -> tuple[int, int]:
    """How many decoders read a plate drawn from a pattern frontally, and at a tilt from two sides."""
    from perfqr_cad import scan
    from perfqr_cad.scan.decoding.decoders import CORE, accepted
    from perfqr_cad.scan.decoding.panel import shared
    from perfqr_cad.scan.schedule import PATIENCE
    from perfqr_cad.symbol import payload_of

    views = scan.Schedule((0.0, ASIDE_DEG), (25.0, 205.0)).views()
    read = scan.reads(
        _drawn_plate(terms, drawn, thickness_mm),
        views,
        terms.look,
        accepted(payload_of(drawn.symbol).data),
        shared(CORE),
        frames=[PATIENCE] * len(views),
    )
    return len(read[0]), len(frozenset.intersection(*read[1:]))


def for_grade(terms: Terms, draw: Callable[[Terms], Pattern], thickness_mm: float) -> tuple[Terms, Pattern]:
    """The terms, and the pattern drawn by them, with bars of the finder rings that have the grade asked for.

    The first of `FINDERS` with which a plate drawn from the pattern has it, before the ground that was named,
    or before dark; those of the terms where none has.
    """
    from perfqr_cad.scan.grade import LETTERS

    request = terms.request
    own = draw(terms)
    named = any(value is not None for value in (request.bars, request.bar_height_mm, request.bar_width_mm))
    if request.grade is None or request.depth_mm is not None or named:
        return terms, own
    tell("choose bars for the grade")
    for finder in FINDERS[FINDERS.index(request.finder) :] if request.finder in FINDERS else ():
        changed = resolved(replace(request, finder=finder), or_straight=terms.walls.or_straight)
        drawn = draw(changed)
        if _drawn_grade(changed, drawn, thickness_mm) >= LETTERS[request.grade]:
            return changed, drawn
    return terms, own


def _drawn_grade(terms: Terms, drawn: Pattern, thickness_mm: float) -> float:
    """Grade by ISO/IEC 15415 of a plate that exists as a pattern only."""
    from perfqr_cad.scan.grade import graded

    found = graded(
        _drawn_plate(terms, drawn, thickness_mm),
        terms.look,
        drawn.symbol,
        module_mm=drawn.module_mm,
        quiet=drawn.quiet_modules,
        ground_known=True,
    )
    return found.counted.overall


def _drawn_plate(terms: Terms, drawn: Pattern, thickness_mm: float) -> Scene:
    """The plate that a pattern would be, with the walls of the terms."""
    from perfqr_cad import scan

    lip_mm = min(terms.walls.lip_mm, thickness_mm / 2)
    return scan.plate_scene(drawn, thickness_mm, draft_deg=terms.walls.draft_deg, lip_mm=lip_mm)


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
