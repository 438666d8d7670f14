"""How a part is made: what a process cannot make is not designed, and so not filmed either.

Printers build any depth; a sheet is cut through by a beam, a jet or a blade, square to its face.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from perfqr_cad.errors import DesignError

if TYPE_CHECKING:
    from perfqr_cad.pipeline.request import Request

METALS = ("aluminium", "steel", "stainless")
METAL_WEB = 0.5  # of the thickness: narrower webs burn away or bend, a common rule of cutting shops
ENGRAVED_MM = 0.2  # depth of letters that a beam marks, where no depth is asked for,
ENGRAVED_SHARE = 0.25  # or this share of a thinner sheet
PRINTED = ("fdm", "resin")


@dataclass(frozen=True)
class Cutting:
    """A way to cut sheets, with the least that shops promise for it.

    web_mm, gap_mm   least width of material and of a hole
    corner_mm        least radius of re-entrant corners, that of the beam or jet; a blade is turned
    thickest_mm      of a sheet
    engraves, cuts_metal   whether it can mark letters on the face; whether it goes through metal
    """

    name: str
    web_mm: float
    gap_mm: float
    corner_mm: float
    thickest_mm: float
    engraves: bool = False
    cuts_metal: bool = True

    def least_web_mm(self, thickness_mm: float, material: str) -> float:
        """Least width of material in a sheet.

        >>> CUTTING["laser"].least_web_mm(3.0, "stainless"), CUTTING["laser"].least_web_mm(3.0, "PLA")
        (1.5, 0.8)
        """
        return max(self.web_mm, METAL_WEB * thickness_mm if material in METALS else 0.0)


CUTTING: dict[str, Cutting] = {
    way.name: way
    for way in (
        Cutting("laser", 0.8, 0.3, 0.1, 20.0, engraves=True),
        Cutting("waterjet", 1.0, 1.2, 0.5, 100.0),
        Cutting("knife", 1.2, 0.8, 0.0, 2.0, cuts_metal=False),
        Cutting("stencil", 1.0, 0.4, 0.1, 2.0),  # cut by a laser, painted through: letters would fall out
    )
}


def is_cut(request: Request) -> bool:
    """Whether the part is cut from a sheet."""
    return request.process in CUTTING


def makeable(request: Request, *, plate: bool) -> Request:
    """The request with what its process leaves no choice of: walls of sheets are straight, bars go through,
    letters are engraved.

    Raises `DesignError` for what cannot be made so.
    """
    if not is_cut(request):
        if request.kerf_mm:
            raise DesignError(
                f"a kerf of {request.kerf_mm:g} mm is a cutter's, and {request.process} prints: "
                "leave --kerf out, or name the cutter (--process laser)"
            )
        return request
    way = CUTTING[request.process]
    _require_flat(request, plate)
    _require_through(request)
    _require_sheet(request, way)
    relief_mm = request.caption_relief_mm
    if request.caption and relief_mm > 0:
        relief_mm = -min(ENGRAVED_MM, ENGRAVED_SHARE * request.thickness_mm)
    return replace(
        request,
        draft_deg=0.0,
        lip_mm=0.0,
        finder="panel" if request.finder == "recessed" else request.finder,
        caption_relief_mm=relief_mm,
    )


def least_sizes(request: Request) -> dict[str, Any]:
    """Fields of the pattern's spec that a cutter sets; none where a nozzle does."""
    if not is_cut(request):
        return {"fillet_mm": request.fillet_mm}
    way = CUTTING[request.process]
    corner_mm = max(way.corner_mm, request.kerf_mm / 2)
    return {
        "min_web_mm": way.least_web_mm(request.thickness_mm, request.material),
        "min_gap_mm": max(way.gap_mm, request.kerf_mm),
        "fillet_mm": max(request.fillet_mm or 0.0, corner_mm),
    }


def _require_flat(request: Request, plate: bool) -> None:
    if not plate:
        raise DesignError(f"{request.process} cuts flat sheets, not a wall of a part: take --process fdm")


def _require_through(request: Request) -> None:
    """Nothing is asked for that ends within the sheet."""
    asked: dict[str, object] = {
        "depth": request.depth_mm,
        "draft": request.draft_deg,
        "lip": request.lip_mm,
        "bars": request.bars,
        "bar-height": request.bar_height_mm,
        "bar-width": request.bar_width_mm,
        "handling": request.handling_n,  # which moves along recessed bars
        "colour-change": request.colour_change,
    }
    if found := [f"--{name}" for name, value in asked.items() if value]:
        raise DesignError(
            f"{request.process} cuts straight through a sheet: leave {', '.join(found)} out, "
            "or take --process fdm"
        )


def _require_sheet(request: Request, way: Cutting) -> None:
    """The sheet can be cut, and marked, in that way."""
    if request.thickness_mm > way.thickest_mm:
        raise DesignError(
            f"{way.name} cuts sheets of up to {way.thickest_mm:g} mm, not {request.thickness_mm:g} mm: "
            f"take --thickness {way.thickest_mm:g} or less, or another --process"
        )
    if request.material in METALS and not way.cuts_metal:
        raise DesignError(f"{way.name} cuts no {request.material}: take --process laser or waterjet")
    if request.caption and not way.engraves:
        raise DesignError(f"{way.name} cannot engrave the caption: leave it out, or take --process laser")
