"""One face before the code and one behind it in the place of several, where a seam, a pole or a joint of
faces runs there.

The part is scored along a square a little larger than the holes. The pieces within the square are replaced by
one face on the same surface, turned so that its own seam and poles lie far away. Nothing moves in space.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepAlgoAPI import BRepAlgoAPI_Splitter
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakePolygon
from OCP.BRepOffsetAPI import BRepOffsetAPI_ThruSections
from OCP.Geom import (
    Geom_ConicalSurface,
    Geom_CylindricalSurface,
    Geom_Plane,
    Geom_RectangularTrimmedSurface,
    Geom_SphericalSurface,
    Geom_SurfaceOfRevolution,
    Geom_ToroidalSurface,
)
from OCP.gp import gp_Ax3
from OCP.ShapeAnalysis import ShapeAnalysis_Surface
from OCP.ShapeFix import ShapeFix_Face
from OCP.TopExp import TopExp
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS, TopoDS_Face, TopoDS_Wire
from OCP.TopTools import TopTools_IndexedMapOfShape, TopTools_ListOfShape

from perfqr_cad.geometry.arrays import Array
from perfqr_cad.geometry.graph import components
from perfqr_cad.geometry.spline import DEGREE, interpolated
from perfqr_cad.hosts.frame import Frame
from perfqr_cad.hosts.host_placement import HostPlacement
from perfqr_cad.hosts.probe import probe
from perfqr_cad.hosts.step.host import Host
from perfqr_cad.solid.kernel import booleans as kernel
from perfqr_cad.solid.kernel import occ
from perfqr_cad.solid.kernel.occ import EDGE, FACE, FORWARD, REVERSED, direction, pnt, spline_curve_2d
from perfqr_cad.solid.kernel.to_shape import BUILDER, solid_of

if TYPE_CHECKING:
    from OCP.Geom import Geom_Surface
    from OCP.TopoDS import TopoDS_Edge, TopoDS_Solid

# Surfaces whose images run on across a seam.
CROSSED = (
    Geom_Plane,
    Geom_CylindricalSurface,
    Geom_ConicalSurface,
    Geom_ToroidalSurface,
    Geom_SurfaceOfRevolution,
)
RIM = 33  # points a side of the square's rim, where its extent in space is taken
BEYOND = 0.2  # of the wall: how far the scoring surface stands out before and behind it
STEP_MM = 0.5  # along edges, when asking which pieces lie within the square
ON_RIM_MM = 1e-4  # rounding of the scored lines
NEAR = 0.1  # of the wall: a piece this near to a face of it belongs there
SAME_MM = 1e-6  # surfaces this near to one another are one
IMAGE_MM = 1e-6  # between an edge and its image on the new face
IMAGE_POINTS = 33  # that an image runs through


def unified(host: Host, placement: HostPlacement, half_mm: float, *, through: bool) -> Host | None:
    """The same part with one face under |u|, |v| ≤ `half_mm` and, for through-holes, one behind it.

    None where the faces there are of different surfaces, or the modeller does not manage.
    """
    box = _extent(host, placement, half_mm, through)
    pieces = _scored(host, placement, box)
    if pieces is None:
        return None
    frame = placement.frame_at_centre
    for share in (0.0, 1.0) if through else (0.0,):
        within = _within(pieces, host, frame, box, share)
        behind = frame.origin - share * placement.thickness_mm * frame.axes[2]
        single = _single_face(within, behind, frame.axes) if within else None
        if single is None:
            return None
        pieces = [*(piece for piece in pieces if not any(piece.IsSame(w) for w in within)), single]
    solid = _solid(pieces)
    return Host(host.name, solid) if kernel.is_valid(solid) else None


def _extent(host: Host, placement: HostPlacement, half_mm: float, through: bool) -> tuple[float, ...]:
    """The box of the holes in the frame of the code's centre: x, y, and heights from behind the wall."""
    frame, line = placement.frame_at_centre, np.linspace(-half_mm, half_mm, RIM)
    at = frame.to_frame(placement.point(np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)))
    (x0, y0, _), (x1, y1, _) = at.min(axis=0), at.max(axis=0)
    x, y = (a.ravel() for a in np.meshgrid(np.linspace(x0, x1, RIM), np.linspace(y0, y1, RIM)))
    flat = frame.to_space(np.column_stack([x, y, np.zeros(x.size)]))
    met = probe(host.body, flat, np.tile(frame.axes[2], (x.size, 1)))
    wall = met.wall_mm if through else np.minimum(met.wall_mm, placement.thickness_mm)
    proud = BEYOND * placement.thickness_mm
    low, high = np.nanmin(met.offset_mm - wall), np.nanmax(met.offset_mm)
    return x0, x1, y0, y1, low - proud, high + proud


def _scored(host: Host, placement: HostPlacement, box: tuple[float, ...]) -> list[TopoDS_Face] | None:
    """The faces of the part, cut along the sides of the box."""
    x0, x1, y0, y1, low, high = box
    sides = BRepOffsetAPI_ThruSections(False, True)
    for height in (low, high):
        polygon = BRepBuilderAPI_MakePolygon()
        corners = np.array([[x0, y0, height], [x1, y0, height], [x1, y1, height], [x0, y1, height]])
        for corner in placement.frame_at_centre.to_space(corners):
            polygon.Add(pnt(corner))
        polygon.Close()
        sides.AddWire(polygon.Wire())
    arguments, cutters = TopTools_ListOfShape(), TopTools_ListOfShape()
    arguments.Append(host.shape)
    cutters.Append(sides.Shape())
    splitter = BRepAlgoAPI_Splitter()
    splitter.SetArguments(arguments)
    splitter.SetTools(cutters)
    splitter.SetNonDestructive(True)
    splitter.Build()
    if not splitter.IsDone():
        return None
    # The scoring surface's own faces stand between two solids, or inside one.
    found = [TopoDS.Face_s(f) for f in occ.explore(splitter.Shape(), FACE)]
    outer = [f for f in found if f.Orientation() in (FORWARD, REVERSED)]
    numbers = occ.distinct(splitter.Shape(), FACE)
    uses = np.bincount([numbers.FindIndex(f) for f in outer], minlength=numbers.Extent() + 1)
    return [f for f in outer if uses[numbers.FindIndex(f)] == 1]


def _within(
    pieces: Sequence[TopoDS_Face], host: Host, frame: Frame, box: tuple[float, ...], share: float
) -> list[TopoDS_Face]:
    """Those of the pieces whose edges lie in the box, `share` of the wall behind its front: 0 or 1."""
    x0, x1, y0, y1, low, high = box
    found: list[TopoDS_Face] = []
    for piece in pieces:
        points = np.vstack([*kernel.edge_points(piece, STEP_MM), np.empty((0, 3))])
        x, y, h = frame.to_frame(points).T
        inside = (x > x0 - ON_RIM_MM) & (x < x1 + ON_RIM_MM) & (y > y0 - ON_RIM_MM) & (y < y1 + ON_RIM_MM)
        if not (len(points) and inside.all() and (h > low).all() and (h < high).all()):
            continue
        met = probe(host.body, points, np.tile(frame.axes[2], (len(points), 1)))
        off = met.offset_mm - share * met.wall_mm  # of the wall's face from the edge
        if np.nanmedian(np.abs(off) / met.wall_mm) < NEAR:
            found.append(piece)
    return found


def _single_face(pieces: Sequence[TopoDS_Face], centre: Array, axes: Array) -> TopoDS_Face | None:
    """One face in the place of several of the same surface; None where they are not, or not simply joined."""
    first = pieces[0]
    surface = _turned(_bare(BRep_Tool.Surface_s(first)), centre, axes)
    if surface is None or not all(_lies_on(piece, surface) for piece in pieces):
        return None
    edges = _chained(pieces)
    if edges is None:
        return None
    for edge in edges:
        _draw(edge, surface, centre)
    wire = TopoDS_Wire()
    BUILDER.MakeWire(wire)
    for edge in edges:
        BUILDER.Add(wire, edge)
    wire.Closed(True)
    face = TopoDS_Face()
    BUILDER.MakeFace(face, surface, BRep_Tool.Tolerance_s(first))
    # The chain runs as seen from outside.
    BUILDER.Add(face, wire if first.Orientation() == FORWARD else wire.Reversed())
    fixer = ShapeFix_Face(face)  # raises the tolerance of edges and vertices to what their images ask for
    fixer.Perform()
    return TopoDS.Face_s(fixer.Face().Oriented(first.Orientation()))


def _bare(surface: Any) -> Any:
    """The surface without a trim."""
    return surface.BasisSurface() if isinstance(surface, Geom_RectangularTrimmedSurface) else surface


def _turned(surface: Any, centre: Array, axes: Array) -> Geom_Surface | None:
    """The surface as an object of its own; a sphere with its poles and seam away from the code. None for
    kinds whose seam cannot be crossed."""
    if isinstance(surface, Geom_SphericalSurface):
        middle = np.array(surface.Location().Coord())
        frame = gp_Ax3(pnt(middle), direction(axes[1]), direction(-axes[2]))
        if not surface.Position().Direct():
            frame.YReverse()
        return Geom_SphericalSurface(frame, surface.Radius())
    return surface.Copy() if isinstance(surface, CROSSED) else None


def _lies_on(piece: TopoDS_Face, surface: Geom_Surface) -> bool:
    """Whether a face's surface is of the same kind, and its edges lie on it."""
    if type(_bare(BRep_Tool.Surface_s(piece))) is not type(surface):
        return False
    seeker = ShapeAnalysis_Surface(surface)
    for points in kernel.edge_points(piece, STEP_MM):
        for point in points[:: max(1, len(points) // 4)]:
            seeker.ValueOfUV(pnt(point), SAME_MM)
            if seeker.Gap() > SAME_MM:
                return False
    return True


def _chained(pieces: Sequence[TopoDS_Face]) -> list[TopoDS_Edge] | None:
    """The edges that only one of the pieces has, head to tail as seen from outside; None unless they make
    one ring."""
    edges = [TopoDS.Edge_s(e) for piece in pieces for e in occ.explore(piece, EDGE)]
    left = [
        e for e in edges if not BRep_Tool.Degenerated_s(e) and sum(e.IsSame(other) for other in edges) == 1
    ]
    chain = left[:1]
    while left := [e for e in left if not any(e.IsSame(c) for c in chain)]:
        end = TopExp.LastVertex_s(chain[-1], True)
        following = next((e for e in left if TopExp.FirstVertex_s(e, True).IsSame(end)), None)
        if following is None:
            return None
        chain.append(following)
    closed = chain and TopExp.LastVertex_s(chain[-1], True).IsSame(TopExp.FirstVertex_s(chain[0], True))
    return chain if closed else None


def _draw(edge: TopoDS_Edge, surface: Geom_Surface, centre: Array) -> None:
    """Give an edge its image on a surface, in the period nearest to the centre's; planes need none."""
    if isinstance(surface, Geom_Plane):
        return
    seeker = ShapeAnalysis_Surface(surface)
    curve = BRep_Tool.Curve_s(edge, 0.0, 0.0)
    first, last = BRep_Tool.Range_s(edge)
    at = np.linspace(first, last, IMAGE_POINTS)
    found = [seeker.ValueOfUV(p, SAME_MM) for p in (pnt(centre), *map(curve.Value, at.tolist()))]
    (middle, *uv) = [(p.X(), p.Y()) for p in found]
    image = interpolated(at, _near(np.array(uv), np.array(middle), _periods(surface)))
    drawn = spline_curve_2d(image.poles, image.knots, DEGREE)
    BUILDER.UpdateEdge(edge, drawn, surface, TopLoc_Location(), IMAGE_MM)


def _periods(surface: Geom_Surface) -> Array:
    """Periods in u and v, infinite where there is none."""
    u = surface.UPeriod() if surface.IsUPeriodic() else np.inf
    return np.array([u, surface.VPeriod() if surface.IsVPeriodic() else np.inf])


def _near(uv: Array, middle: Array, periods: Array) -> Array:
    """Parameters (k, 2) moved by whole periods to within half a period of the middle."""
    return uv - np.where(
        np.isinf(periods), 0.0, np.round((uv - middle) / periods) * np.where(np.isinf(periods), 1.0, periods)
    )


def _solid(faces: Sequence[TopoDS_Face]) -> TopoDS_Solid:
    """The solid of faces, those that share edges in one shell."""
    numbers = TopTools_IndexedMapOfShape()
    first: dict[int, int] = {}
    pairs: list[tuple[int, int]] = []
    for i, face in enumerate(faces):
        for edge in occ.explore(face, EDGE):
            pairs.append((first.setdefault(numbers.Add(edge), i), i))
    shell = components(np.array(pairs), len(faces))
    return solid_of(
        *([f for f, s in zip(faces, shell, strict=True) if s == k] for k in range(max(shell) + 1))
    )
