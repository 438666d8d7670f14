"""A pattern on a placement becomes a solid: loops, walls, shell, triangles, measures, checks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from perfqr_cad.errors import KernelError
from perfqr_cad.pattern import Bridge
from perfqr_cad.pattern.outline import Region
from perfqr_cad.surface import Cone, HeightField, Placement, Plane, Revolved

from . import occ
from .chart import Chart
from .curved_charts import ConeChart, HeightFieldChart, RevolvedChart
from .expected import volume_mm3
from .mesh import CHORD_MM, triangulate
from .occ import EDGE, FACE, SOLID, explore
from .plane_chart import PlaneChart
from .proof import check
from .punch import panel
from .recess import NoRecess
from .sections import Sections, sections
from .shape import LIGHT, Colour, Solid
from .walls import Walls

# Share of the volume by which the modeller may differ from the closed form: rounding on straight plates; on
# flared ones corners that join smoothly to 1e-6, elsewhere the fit of curves and offset surfaces.
FLAT_VOLUME_TOL = 1e-9
CURVED_VOLUME_TOL = 1e-6
VOLUME_ACCURACY = 1e-7  # asked of the modeller's adaptive integration

if TYPE_CHECKING:
    from perfqr_cad.pattern import Pattern


def build(
    pattern: Pattern,
    placement: Placement,
    walls: Walls | None = None,
    *,
    name: str = "perforated-qr",
    colour: Colour = LIGHT,
    chord_mm: float = CHORD_MM,
) -> Solid:
    """The part of a pattern, its webs no thinner at the back than the pattern's minimum; recessed bars are
    flush where the wall leaves no room before them (`Solid.notes`).

    Raises `DesignError` for walls that cannot be made, `KernelError` for a bad solid.
    """
    return build_front(
        pattern.front,
        pattern.recessed,
        pattern.region,
        placement,
        walls,
        min_web_mm=pattern.spec.web_mm,
        name=name,
        colour=colour,
        chord_mm=chord_mm,
    )


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
    return build_front(
        (region,),
        (),
        region,
        placement,
        walls,
        min_web_mm=min_web_mm,
        name=name,
        colour=colour,
        chord_mm=chord_mm,
    )


def build_front(
    front: Sequence[Region],
    bars: Sequence[Bridge],
    flush: Region,
    placement: Placement,
    walls: Walls | None = None,
    *,
    min_web_mm: float = 0.0,
    name: str = "perforated-qr",
    colour: Colour = LIGHT,
    chord_mm: float = CHORD_MM,
) -> Solid:
    """The part of several pieces joined by recessed bars; `flush` is the region that holds where the bars
    cannot lie behind the face. Otherwise as `build`."""
    walls = walls or Walls()
    chart = chart_of(placement)
    stands, notes = _sections(front, bars, flush, placement.thickness_mm, walls, chart, min_web_mm)
    with occ.kernel("building the solid", "simplify the outline or move the code to a smoother place"):
        shape = panel(stands, chart)
        volume = occ.volume(shape)
        expected = volume_mm3(stands.wells, placement)
        if (
            abs(volume - expected) > CURVED_VOLUME_TOL * expected
        ):  # the quick rule is coarse on spline surfaces
            volume = occ.volume(shape, VOLUME_ACCURACY)
        bbox = occ.bounds(explore(shape, FACE)[: stands.pieces + 1])  # walls are ruled between their edges
    triangles = triangulate(
        stands.wells,
        placement.thickness_mm,
        placement.at_depth,
        tops=stands.tops,
        chord_mm=chord_mm,
        flat=placement.is_flat,
    )
    exact = placement.is_flat and walls.draft_deg == 0
    limit = FLAT_VOLUME_TOL if exact else CURVED_VOLUME_TOL
    problems = check(
        shape, genus=stands.genus, expected_volume_mm3=expected, volume_tol=limit, volume_mm3=volume
    )
    if not triangles.closed:
        problems = (*problems, "the triangles do not close")
    return Solid(
        shape=shape,
        triangles=triangles,
        valid=not problems,
        solids=occ.count(shape, SOLID),
        faces=occ.count(shape, FACE),
        edges=occ.count(shape, EDGE),
        volume_mm3=volume,
        expected_volume_mm3=expected,
        problems=problems,
        notes=notes,
        bbox_mm=bbox,
        name=name,
        colour=colour,
    )


def _sections(
    front: Sequence[Region],
    bars: Sequence[Bridge],
    flush: Region,
    thickness_mm: float,
    walls: Walls,
    chart: Chart,
    min_web_mm: float,
) -> tuple[Sections, tuple[str, ...]]:
    """The loops of the part, and what was made otherwise than asked."""
    whole = chart.whole_circles
    try:
        return sections(front, thickness_mm, walls, whole, bars=bars, min_web_mm=min_web_mm), ()
    except NoRecess as reason:
        return sections([flush], thickness_mm, walls, whole, min_web_mm=min_web_mm), (str(reason),)


def chart_of(placement: Placement) -> Chart:
    """The kernel's view of a placement."""
    match placement:
        case Plane():
            return PlaneChart(placement)
        case Revolved():
            return RevolvedChart(placement)
        case Cone():
            return ConeChart(placement)
        case HeightField():
            return HeightFieldChart(placement)
        case _:
            raise KernelError(
                f"no exact chart for {type(placement).__name__}: use a surface of perfqr_cad.surface"
            )
