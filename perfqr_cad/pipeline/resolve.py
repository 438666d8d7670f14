"""A request in each layer's own terms: resolved once, before any long step."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from perfqr_cad.errors import DesignError
from perfqr_cad.pipeline.request import Request
from perfqr_cad.remedy import Remedy
from perfqr_cad.units import linear_from_srgb, srgb_from_linear

if TYPE_CHECKING:
    from perfqr_cad.pattern import PatternSpec
    from perfqr_cad.profile import Backing, Caption, Walls
    from perfqr_cad.profile.caption import Place
    from perfqr_cad.profile.colour import Colour
    from perfqr_cad.scan import Look, Schedule
    from perfqr_cad.scan.camera.look import RGB
    from perfqr_cad.structure import Case
    from perfqr_cad.structure.reinforcement.algorithm1 import Method

# Walls of plates: they hide the least from aside, and printers still bear the overhang (docs/scan.md).
DRAFT_DEG, LIP_MM = 15.0, 0.2
LEAST_FLARED_MM = 4 * LIP_MM  # thinner sheets are cut, not printed, and hide little
FRAME_MM = 8.0  # that bears one line which can be printed and read
BACKING_MM = 1.0  # that is stiff and dark enough behind a plate
LAYER_SHARE = 0.75  # of its diameter: the thickest layer that a nozzle lays well
# Settings of what ends within a sheet; handling moves along recessed bars.
WITHIN = (
    "depth_mm", "draft_deg", "lip_mm", "bars", "bar_height_mm", "bar_width_mm", "handling_n", "colour_change"
)  # fmt: skip


@dataclass(frozen=True)
class Terms:
    """One value for each layer.

    request   as it was asked, with the walls that it left open filled in
    drawing   for `pattern`
    walls     of the holes, for `profile` and `solid`
    case      for `structure`; how far the walls flare is known once the part has a thickness: `case_in`
    views, look   for `scan`
    caption, backing, colour   what is written on the part, lies behind it, and the part's own colour in files
    """

    request: Request
    drawing: PatternSpec
    walls: Walls
    case: Case
    views: Schedule
    look: Look
    caption: Caption | None
    backing: Backing | None
    colour: Colour

    @property
    def method(self) -> Method:
        """How bridges for strength are chosen."""
        return self.request.method  # pyright: ignore[reportReturnType]  # `reinforce` refuses unknown names

    def case_in(self, thickness_mm: float) -> Case:
        """The strength case in a wall of that thickness, whose holes are wider at the back."""
        return replace(self.case, flare_mm=self.walls.flare_mm(self.walls.reach_mm(thickness_mm)))


def resolve(request: Request, *, plate: bool) -> Terms:
    """The terms of a request. On a plate with through-holes, walls that it leaves open flare for the reader;
    elsewhere they are straight.

    Raises `DesignError` for walls, captions, colours and names that cannot be meant, and a change of
    colour on a part of one.
    """
    request = makeable(request, plate=plate)
    if request.colour_change and plate and request.backing_mm is None:
        raise DesignError(
            "a change of colour between layers needs a second colour",
            Remedy(backing_mm=BACKING_MM),
            Remedy(colour_change=None),
        )
    flares = plate and request.depth_mm is None and request.thickness_mm >= LEAST_FLARED_MM
    draft_deg, lip_mm = (DRAFT_DEG, LIP_MM) if flares and request.draft_deg is None else (0.0, 0.0)
    filled = replace(
        request,
        draft_deg=draft_deg if request.draft_deg is None else request.draft_deg,
        lip_mm=lip_mm if request.lip_mm is None else request.lip_mm,
        support=request.support or ("free" if plate else "clamped"),
    )
    if request.lip_mm and not filled.draft_deg:
        raise DesignError(
            f"a lip of {request.lip_mm:g} mm has no effect before straight walls",
            Remedy(draft_deg=DRAFT_DEG),
            Remedy(lip_mm=None),
        )
    return resolved(filled, or_straight=request.draft_deg is None)


def resolved(request: Request, *, or_straight: bool) -> Terms:
    """The terms of a request that says how its walls run; `or_straight`: walls that can flare nowhere may be
    straight instead."""
    from perfqr_cad.profile import Walls

    drawing = _drawing(request)
    return Terms(
        request=request,
        drawing=drawing,
        walls=Walls(request.draft_deg or 0.0, request.lip_mm or 0.0, request.depth_mm, or_straight),
        case=_case(request),
        views=_views(request),
        look=_look(request),
        caption=_caption(request, drawing),
        backing=_backing(request),
        colour=_part_colour(request),
    )


def makeable(request: Request, *, plate: bool) -> Request:
    """The request with what its process leaves no choice of: walls of sheets are straight, bars go through,
    letters are engraved.

    Raises `DesignError` for what cannot be cut from a sheet.
    """
    from perfqr_cad.profile.sheets import CUTTING

    way = CUTTING.get(request.process)
    if way is None:
        return request
    printed = Remedy(process="fdm", **({"kerf_mm": None} if request.kerf_mm else {}))
    if not plate:
        raise DesignError(f"{way.name} cuts flat sheets, not the wall of a part", printed)
    if within := {name: None for name in WITHIN if getattr(request, name)}:
        raise DesignError(f"{way.name} cuts straight through a sheet", Remedy(**within), printed)
    way.require(request.thickness_mm, request.material, lettered=bool(request.caption))
    relief_mm = request.caption_relief_mm
    return replace(
        request,
        draft_deg=0.0,
        lip_mm=0.0,
        finder="panel" if request.finder == "recessed" else request.finder,
        caption_relief_mm=way.relief_mm(relief_mm, request.thickness_mm) if request.caption else relief_mm,
    )


def _least_sizes(request: Request) -> dict[str, Any]:
    """Fields of the pattern's spec that a cutter sets, or a nozzle."""
    from perfqr_cad.profile.sheets import CUTTING, HOLE_KERFS

    way = CUTTING.get(request.process)
    if way is None:
        return {"fillet_mm": request.fillet_mm}
    return {
        "min_web_mm": way.least_web_mm(request.thickness_mm, request.material),
        "min_gap_mm": max(way.gap_mm, HOLE_KERFS * request.kerf_mm),
        "fillet_mm": max(request.fillet_mm or 0.0, way.corner_mm, request.kerf_mm / 2),
    }


def _drawing(request: Request) -> PatternSpec:
    """What the pattern is asked to be."""
    from perfqr_cad.pattern import Hole, PatternSpec, Surround

    return PatternSpec(
        size_mm=request.size_mm,
        quiet_modules=request.quiet_modules,
        nozzle_mm=request.nozzle_mm,
        style=request.style,  # pyright: ignore[reportArgumentType]  # PatternSpec refuses unknown names
        **_least_sizes(request),
        finder=request.finder,  # pyright: ignore[reportArgumentType]
        **_bars(request),
        objective=request.objective,  # pyright: ignore[reportArgumentType]
        contour=request.contour,  # pyright: ignore[reportArgumentType]
        tone=request.tone,  # pyright: ignore[reportArgumentType]
        surround=Surround(
            frame_mm=request.frame_mm,
            corner_radius_mm=request.corner_radius_mm,
            holes=tuple(Hole(*hole) for hole in request.hole_mm if len(hole) > 1),
            corner_hole_mm=next((hole[0] for hole in request.hole_mm if len(hole) == 1), None),
        ),
        seed=request.seed,
    )


def _bars(request: Request) -> dict[str, Any]:
    """Settings of the recessed bars: as asked for, and what is left open as suits the reader: `PatternSpec`'s
    own, or, the smaller the bars, the further from aside zxing-cpp reads (docs/scan.md).
    """
    chosen: dict[str, Any] = {}
    if request.scan_tilt_deg:
        layer_mm = LAYER_SHARE * request.nozzle_mm
        chosen = {"bars": 1, "bar_width_mm": request.nozzle_mm, "bar_height_mm": layer_mm}
    asked = {name: getattr(request, name) for name in ("bars", "bar_height_mm", "bar_width_mm")}
    return chosen | {name: value for name, value in asked.items() if value is not None}


def _caption(request: Request, drawing: PatternSpec) -> Caption | None:
    """What is written on the frame."""
    if not request.caption:
        return None
    if not request.frame_mm:
        raise DesignError("a caption needs a frame to stand on", Remedy(frame_mm=FRAME_MM), "another width")
    from perfqr_cad.profile.caption import Caption, fitting_height_mm

    height_mm = request.caption_height_mm
    if height_mm is None:
        height_mm = fitting_height_mm(request.caption, request.font, request.frame_mm, drawing.web_mm)
    place: Place = request.caption_place  # pyright: ignore[reportAssignmentType]  # Caption refuses others
    caption = Caption(request.caption, height_mm, request.caption_relief_mm, request.font, place)
    caption.require_fit(drawing)
    return caption


def _backing(request: Request) -> Backing | None:
    """The plate behind, in the tone that the holes are to have."""
    from perfqr_cad.profile import Backing
    from perfqr_cad.profile.colour import DARK, LIGHT

    if request.backing_mm is None:
        return None
    plain = LIGHT if request.tone == "inverted" else DARK
    colour = plain if request.ground is None else _srgb(_colours(request)[1])
    return Backing(request.backing_mm, request.gap_mm, colour)


def _case(request: Request) -> Case:
    """What the part is asked to bear in the hand, or as it is mounted. A wall that goes on around the code is
    printed upright as a rule, a plate flat."""
    from perfqr_cad.structure import Case, handling_loads

    case = Case.of(
        (),
        material=request.material,
        support=request.support or "clamped",
        nozzle_mm=request.nozzle_mm,
        yield_mpa=request.yield_mpa,
    )
    loads = handling_loads(asked_loads(request), request.pressure_mpa)
    asked = bool(asked_loads(request) or request.pressure_mpa)
    return case.for_hands(loads, upright=request.support != "free", strengthen=asked)


def asked_loads(request: Request) -> tuple[str, ...]:
    """The loads that were asked for by name, as they were written."""
    listed = [name.strip() for name in (request.load or "").split(",") if name.strip()]
    forces = (request.finger_n, request.handling_n)
    listed += [f"fingertip={force_n:g}" for force_n in forces if force_n is not None]
    return (*listed, "weight") if request.own_weight else tuple(listed)


def _views(request: Request) -> Schedule:
    """The quick views; with a tilt that is asked for, as many sides and frames as in the full certificate."""
    from perfqr_cad.scan import FULL, QUICK

    known = request.ground is not None or request.backing_mm is not None
    if request.scan_tilt_deg is None:
        return replace(QUICK, ground_known=known)
    tilts_deg = tuple(sorted({*QUICK.tilts_deg, request.scan_tilt_deg}))
    return replace(FULL, tilts_deg=tilts_deg, backgrounds=(), ground_known=known)


def _look(request: Request) -> Look:
    """Colours of the part and of the ground behind it, which a backing brings near."""
    from perfqr_cad.scan import Look

    gap = Look.gap_mm if request.backing_mm is None else request.gap_mm
    material, ground = _colours(request)
    return Look(material=material, ground=ground, gap_mm=gap)


def _part_colour(request: Request) -> Colour:
    """sRGB of the part as files show it."""
    from perfqr_cad.profile.colour import DARK, LIGHT

    if request.colour is None:
        return DARK if request.tone == "inverted" else LIGHT
    return _srgb(_colours(request)[0])


def _colours(request: Request) -> tuple[RGB, RGB]:
    """Linear reflectances of part and ground."""
    from perfqr_cad.scan.colours import BACKGROUNDS, FILAMENTS

    part, ground = ("black", "white") if request.tone == "inverted" else ("white", "black")
    return (
        _reflectance("colour", request.colour or part, FILAMENTS),
        _reflectance("ground", request.ground or ground, {"white": FILAMENTS["white"], **BACKGROUNDS}),
    )


def _reflectance(setting: str, colour: str, named: Mapping[str, RGB]) -> RGB:
    """A named colour's reflectances, or those of #rrggbb."""
    if colour in named:
        return named[colour]
    if not re.fullmatch("#[0-9a-fA-F]{6}", colour):
        raise DesignError(f"{setting} {colour!r} is unknown: use #rrggbb or one of {', '.join(named)}")
    red, green, blue = linear_from_srgb([byte / 255 for byte in bytes.fromhex(colour[1:])]).tolist()
    return red, green, blue


def _srgb(reflectance: RGB) -> Colour:
    red, green, blue = srgb_from_linear(reflectance).tolist()
    return red, green, blue
