"""A request in each layer's own terms."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from perfqr_cad.errors import DesignError
from perfqr_cad.request import Request
from perfqr_cad.units import linear_from_srgb, srgb_from_linear

if TYPE_CHECKING:
    from perfqr_cad.pattern import PatternSpec
    from perfqr_cad.scan import Look, Plan
    from perfqr_cad.scan.look import RGB
    from perfqr_cad.solid import Backing, Caption, Walls
    from perfqr_cad.solid.caption import Place
    from perfqr_cad.solid.shape import Colour
    from perfqr_cad.structure.loads import Load

# Walls of plates: they hide the least from aside, and printers still bear the overhang (docs/scan.md).
DRAFT_DEG, LIP_MM = 15.0, 0.2
LEAST_FLARED_MM = 4 * LIP_MM  # thinner sheets are cut, not printed, and hide little
LAYER_SHARE = 0.75  # of its diameter: the thickest layer that a nozzle lays well


def spec(request: Request) -> PatternSpec:
    """What the pattern is asked to be."""
    from perfqr_cad.pattern import Hole, PatternSpec, Surround

    # The smaller the bars, the further from aside zxing-cpp reads the part: docs/scan.md.
    bars = {}
    if request.scan_tilt_deg:
        bars = {"bar_width_mm": request.nozzle_mm, "bar_height_mm": LAYER_SHARE * request.nozzle_mm}
    return PatternSpec(
        size_mm=request.size_mm,
        quiet_modules=request.quiet_modules,
        nozzle_mm=request.nozzle_mm,
        style=request.style,  # pyright: ignore[reportArgumentType]  # PatternSpec refuses unknown names
        fillet_mm=request.fillet_mm,
        finder=request.finder,  # pyright: ignore[reportArgumentType]
        **bars,
        objective=request.objective,  # pyright: ignore[reportArgumentType]
        contour=request.contour,  # pyright: ignore[reportArgumentType]
        tone=request.tone,  # pyright: ignore[reportArgumentType]
        surround=Surround(
            frame_mm=request.frame_mm,
            corner_radius_mm=request.corner_radius_mm,
            holes=tuple(Hole(*hole) for hole in request.holes_mm),
            corner_hole_mm=request.corner_hole_mm,
        ),
        seed=request.seed,
    )


def settled(request: Request, *, plate: bool) -> Request:
    """The request with the walls that it left open: flared for a plate with through-holes, else straight."""
    flares = plate and request.depth_mm is None and request.thickness_mm >= LEAST_FLARED_MM
    draft, lip = (DRAFT_DEG, LIP_MM) if flares and request.draft_deg is None else (0.0, 0.0)
    return replace(
        request,
        draft_deg=draft if request.draft_deg is None else request.draft_deg,
        lip_mm=lip if request.lip_mm is None else request.lip_mm,
    )


def walls(request: Request, *, or_straight: bool = False) -> Walls:
    """How the walls of the holes run; straight where the request leaves them open, or nothing can flare and
    `or_straight`."""
    from perfqr_cad.solid import Walls

    return Walls(request.draft_deg or 0.0, request.lip_mm or 0.0, request.depth_mm, or_straight)


def caption(request: Request) -> Caption | None:
    """What is written on the frame."""
    from perfqr_cad.solid.caption import Caption, fitting_height_mm

    if not request.caption:
        return None
    if not request.frame_mm:
        raise DesignError("a caption needs a frame to stand on: give --frame 8, say")
    height_mm = request.caption_height_mm
    if height_mm is None:
        height_mm = fitting_height_mm(request.caption, request.font, request.frame_mm, spec(request).web_mm)
    place: Place = request.caption_place  # pyright: ignore[reportAssignmentType]  # Caption refuses others
    return Caption(request.caption, height_mm, request.caption_relief_mm, request.font, place)


def backing(request: Request) -> Backing | None:
    """The plate behind, in the tone that the holes are to have."""
    from perfqr_cad.solid import Backing
    from perfqr_cad.solid.shape import DARK, LIGHT

    if request.backing_mm is None:
        return None
    plain = LIGHT if request.tone == "inverted" else DARK
    colour = plain if request.ground is None else _srgb(_colours(request)[1])
    return Backing(request.backing_mm, request.backing_gap_mm, colour)


def loads(request: Request) -> tuple[Load, ...]:
    """What pushes on the part, all at once."""
    from perfqr_cad.structure import Finger, Pressure, Weight

    finger = (Finger(request.finger_n),) if request.finger_n else ()
    weight = (Weight(),) if request.own_weight else ()
    return (Pressure(request.pressure_mpa), *finger, *weight)


def plan(request: Request) -> Plan:
    """The quick views; with a tilt that is asked for, as many sides and frames as in the full certificate."""
    from perfqr_cad.scan import FULL, QUICK

    if request.scan_tilt_deg is None:
        return QUICK
    return replace(FULL, tilts_deg=tuple(sorted({*QUICK.tilts_deg, request.scan_tilt_deg})), backgrounds=())


def look(request: Request) -> Look:
    """Colours of the part and of the ground behind it, which a backing brings near."""
    from perfqr_cad.scan import Look

    gap = Look.gap_mm if request.backing_mm is None else request.backing_gap_mm
    material, ground = _colours(request)
    return Look(material=material, ground=ground, gap_mm=gap)


def part_colour(request: Request) -> Colour:
    """sRGB of the part as files show it."""
    from perfqr_cad.solid.shape import DARK, LIGHT

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
