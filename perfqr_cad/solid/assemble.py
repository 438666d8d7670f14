"""A pattern on a placement becomes a solid: loops, walls, shell, triangles, measures, checks."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from perfqr_cad.profile.backing import Backing
from perfqr_cad.profile.caption import Caption
from perfqr_cad.profile.colour import LIGHT, Colour
from perfqr_cad.profile.profile import Profile
from perfqr_cad.profile.sections import Sections
from perfqr_cad.profile.walls import Walls
from perfqr_cad.solid.charts.chart import Chart
from perfqr_cad.solid.charts.plane_chart import PlaneChart
from perfqr_cad.solid.mesh import CHORD_MM, triangulate
from perfqr_cad.solid.proof import flux
from perfqr_cad.solid.proof.check import check
from perfqr_cad.solid.proof.expected import volume_mm3
from perfqr_cad.solid.shape import Solid
from perfqr_cad.solid.stitch import panel
from perfqr_cad.surface import Placement, Plane

# Share of the volume by which the modeller may differ from the closed form: rounding on plates, straight or
# flared; elsewhere the fit of curves and offset surfaces.
FLAT_VOLUME_TOL = 1e-9
CURVED_VOLUME_TOL = 1e-6

if TYPE_CHECKING:
    from perfqr_cad.pattern import Pattern


def build(
    pattern: Pattern,
    placement: Placement,
    walls: Walls | None = None,
    *,
    caption: Caption | None = None,
    name: str = "perforated-qr",
    colour: Colour = LIGHT,
    chord_mm: float = CHORD_MM,
) -> Solid:
    """The part of a pattern, its webs no thinner at the back than the pattern's minimum; recessed bars are
    flush where the wall leaves no room before them (`Solid.notes`).

    Raises `DesignError` for walls that cannot be made, `KernelError` for a bad solid.
    """
    profile = Profile.of(pattern)
    if caption is not None:
        letters = caption.placed(pattern, placement.thickness_mm)
        profile = replace(profile, letters=letters, relief_mm=caption.relief_mm)
    return build_profile(profile, placement, walls, name=name, colour=colour, chord_mm=chord_mm)


def build_profile(
    profile: Profile,
    placement: Placement,
    walls: Walls | None = None,
    *,
    name: str = "perforated-qr",
    colour: Colour = LIGHT,
    chord_mm: float = CHORD_MM,
) -> Solid:
    """The part of a profile; otherwise as `build`.

    >>> from perfqr_cad.geometry import Loop, Region
    >>> square = Region(Loop.from_points([(0, 0), (4, 0), (4, 4), (0, 4)]))
    >>> part = build_profile(Profile((square,)), Plane(2.0))
    >>> part.valid, part.faces, round(part.volume_mm3, 9)
    (True, 6, 32.0)
    """
    walls = walls or Walls()
    sections, notes = profile.feasible_sections(
        placement.thickness_mm, walls, whole_circles=chart_of(placement).whole_circles
    )
    solid = _assembled(sections, placement, chord_mm)
    return replace(
        solid, notes=notes, name=name, colour=colour, letters=profile.letters, relief_mm=profile.relief_mm
    )


def back(
    pattern: Pattern,
    placement: Placement,
    backing: Backing,
    *,
    name: str = "backing",
    chord_mm: float = CHORD_MM,
) -> Solid:
    """The plate behind a part. Raises `DesignError` where the wall bends too tightly for it."""
    profile = Profile.of(pattern)
    loops = backing.loops(profile.front[0], profile.mounts)
    sections = backing.sections(loops, placement, chart_of(placement).whole_circles)
    return replace(_assembled(sections, placement, chord_mm), name=name, colour=backing.colour)


def _assembled(sections: Sections, placement: Placement, chord_mm: float) -> Solid:
    """The solid of some sections, measured and checked."""
    volume_tol = FLAT_VOLUME_TOL if placement.is_flat else CURVED_VOLUME_TOL
    brep = panel(sections, chart_of(placement))
    volume, expected = flux.volume_mm3(brep), volume_mm3(sections.lofts, placement)
    triangles = triangulate(
        sections.lofts,
        sections.between_mm[1],
        placement.at_depth,
        tops=sections.tops,
        chord_mm=chord_mm,
        flat=placement.is_flat,
    )
    problems = check(
        brep, genus=sections.genus, expected_volume_mm3=expected, volume_tol=volume_tol, volume_mm3=volume
    )
    if not triangles.closed:
        problems = (*problems, "the triangles do not close")
    return Solid(
        exact=brep,
        triangles=triangles,
        valid=not problems,
        solids=1,
        faces=brep.face_count,
        edges=len(brep.ends),
        volume_mm3=volume,
        expected_volume_mm3=expected,
        problems=problems,
        bbox_mm=triangles.bounds_mm,  # exact on plates, within the chord elsewhere
    )


def chart_of(placement: Placement) -> Chart:
    """How the pattern lies in a placement."""
    match placement:
        case Plane():
            return PlaneChart(placement)
        case _:  # the modeller takes a second to load, and a plate needs none
            from perfqr_cad.solid.charts.curved import curved_chart

            return curved_chart(placement)
