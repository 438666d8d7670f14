"""A pattern on a placement becomes a solid: loops, walls, shell, triangles, measures, checks."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from perfqr_cad.pattern.outline import Region
from perfqr_cad.surface import Placement, Plane, Triangles

from . import flux
from .backing import Backing
from .caption import Caption
from .chart import Chart
from .expected import volume_mm3
from .mesh import CHORD_MM, triangulate
from .plan import Plan
from .plane_chart import PlaneChart
from .proof import check
from .sections import Sections
from .shape import LIGHT, Colour, Corner, Solid
from .stitch import panel
from .walls import Walls

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
    plan = plan_of(pattern)
    if caption is not None:
        plan = replace(plan, lettering=caption.placed(pattern, placement.thickness_mm))
    return build_plan(plan, placement, walls, name=name, colour=colour, chord_mm=chord_mm)


def build_region(
    region: Region,
    placement: Placement,
    walls: Walls | None = None,
    *,
    min_web_mm: float = 0.0,
    name: str = "perforated-qr",
    colour: Colour = LIGHT,
    chord_mm: float = CHORD_MM,
) -> Solid:
    """The part of any region of the pattern plane, mm; otherwise as `build`."""
    plan = Plan((region,), min_web_mm=min_web_mm)
    return build_plan(plan, placement, walls, name=name, colour=colour, chord_mm=chord_mm)


def build_plan(
    plan: Plan,
    placement: Placement,
    walls: Walls | None = None,
    *,
    name: str = "perforated-qr",
    colour: Colour = LIGHT,
    chord_mm: float = CHORD_MM,
) -> Solid:
    """The part of a plan; otherwise as `build`."""
    walls = walls or Walls()
    stands, notes = plan.sections(placement.thickness_mm, walls, chart_of(placement).whole_circles)
    solid = _stood(stands, placement, chord_mm)
    return replace(solid, notes=notes, name=name, colour=colour, lettering=plan.lettering)


def back(
    pattern: Pattern,
    placement: Placement,
    backing: Backing,
    *,
    name: str = "backing",
    chord_mm: float = CHORD_MM,
) -> Solid:
    """The plate behind a part. Raises `DesignError` where the wall bends too tightly for it."""
    plan = plan_of(pattern)
    loops = backing.loops(plan.front[0], plan.mounts)
    stands = backing.sections(loops, placement, chart_of(placement).whole_circles)
    return replace(_stood(stands, placement, chord_mm), name=name, colour=backing.colour)


def plan_of(pattern: Pattern) -> Plan:
    """What a pattern's own part is made of."""
    mounts = pattern.spec.surround.all_holes(pattern.size_mm)
    return Plan(
        pattern.front,
        pattern.recessed,
        pattern.region,
        pattern.spec.web_mm,
        tuple(hole.circle for hole in mounts),
    )


def _stood(stands: Sections, placement: Placement, chord_mm: float) -> Solid:
    """The solid of some sections, measured and checked."""
    volume_tol = FLAT_VOLUME_TOL if placement.is_flat else CURVED_VOLUME_TOL
    brep = panel(stands, chart_of(placement))
    volume, expected = flux.volume_mm3(brep), volume_mm3(stands.wells, placement)
    triangles = triangulate(
        stands.wells,
        stands.between_mm[1],
        placement.at_depth,
        tops=stands.tops,
        chord_mm=chord_mm,
        flat=placement.is_flat,
    )
    problems = check(
        brep, genus=stands.genus, expected_volume_mm3=expected, volume_tol=volume_tol, volume_mm3=volume
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
        bbox_mm=_bounds(triangles),
    )


def _bounds(triangles: Triangles) -> tuple[Corner, Corner]:
    """Of the mesh: exact on plates, within the chord elsewhere."""
    (x0, y0, z0), (x1, y1, z1) = (
        f(axis=0).tolist() for f in (triangles.vertices.min, triangles.vertices.max)
    )
    return (x0, y0, z0), (x1, y1, z1)


def chart_of(placement: Placement) -> Chart:
    """How the pattern lies in a placement."""
    match placement:
        case Plane():
            return PlaneChart(placement)
        case _:  # the modeller takes a second to load, and a plate needs none
            from .curved_charts import curved_chart

            return curved_chart(placement)
