"""Sheets that are cut through by a beam, a jet or a blade, square to their face."""

from __future__ import annotations

from dataclasses import dataclass

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry.outline import Region
from perfqr_cad.remedy import Remedy

METALS = ("aluminium", "steel", "stainless")
METAL_WEB = 0.5  # of the thickness: narrower webs burn away or bend, a common rule of cutting shops
ENGRAVED_MM = 0.2  # depth of letters that a beam marks, where no depth is asked for,
ENGRAVED_SHARE = 0.25  # or this share of a thinner sheet
HOLE_KERFS = 1.25  # least width of a hole: the cutter runs along both sides of it
STENCIL = "stencil"
OVERSPRAY_MM = 0.3  # that paint creeps under the edges of a stencil held against the wall
PAINT_MM = 0.05  # thickness of the picture that is filmed: none to speak of
PAINTED = f"filmed: the picture painted through the stencil, holes {OVERSPRAY_MM:g} mm wider all around"


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

    def relief_mm(self, asked_mm: float, thickness_mm: float) -> float:
        """How far letters stand out: not at all, they are engraved."""
        return asked_mm if asked_mm <= 0 else -min(ENGRAVED_MM, ENGRAVED_SHARE * thickness_mm)

    def require(self, thickness_mm: float, material: str, *, lettered: bool) -> None:
        """Raises `DesignError` for a sheet that is not cut, or marked, in this way."""
        if thickness_mm > self.thickest_mm:
            raise DesignError(
                f"{self.name} cuts sheets of up to {self.thickest_mm:g} mm, not {thickness_mm:g} mm",
                Remedy(thickness_mm=self.thickest_mm),
            )
        if material in METALS and not self.cuts_metal:
            raise DesignError(f"{self.name} cuts no {material}", Remedy(process="laser"))
        if lettered and not self.engraves:
            raise DesignError(
                f"{self.name} cannot engrave a caption", Remedy(caption=None), Remedy(process="laser")
            )


CUTTING: dict[str, Cutting] = {
    way.name: way
    for way in (
        Cutting("laser", 0.8, 0.3, 0.1, 20.0, engraves=True),
        Cutting("waterjet", 1.0, 1.2, 0.5, 100.0),
        Cutting("knife", 1.2, 0.8, 0.0, 2.0, cuts_metal=False),
        Cutting("stencil", 1.0, 0.4, 0.1, 2.0),  # cut by a laser, painted through: letters would fall out
    )
}


def bare(stencil: Region, overspray_mm: float = OVERSPRAY_MM) -> tuple[Region, ...]:
    """What of the wall behind a stencil stays bare when it is painted: bars that paint creeps under are gone.

    >>> from perfqr_cad.geometry import Loop
    >>> hole = Loop.from_points([(1, 1), (1, 2), (2, 2), (2, 1)])
    >>> sheet = Region(Loop.from_points([(0, 0), (4, 0), (4, 3), (0, 3)]), (hole,))
    >>> [round(piece.area, 9) for piece in bare(sheet, 0.25)]
    [9.75]
    """
    import shapely

    whole = stencil.polygon()
    holes = shapely.unary_union(
        [shapely.Polygon(ring).buffer(overspray_mm, join_style="mitre") for ring in whole.interiors]
    )
    left = shapely.get_parts(shapely.Polygon(whole.exterior).difference(holes))
    return tuple(Region.from_polygon(piece) for piece in left)
