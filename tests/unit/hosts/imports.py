"""Small solids, meshes and patterns for the tests of imported parts."""

from pathlib import Path

import numpy as np
import trimesh
from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeCylinder, BRepPrimAPI_MakeSphere
from OCP.gp import gp_Pnt
from OCP.Interface import Interface_Static
from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer
from OCP.TopoDS import TopoDS_Shape

from perfqr_cad.geometry import Triangles
from perfqr_cad.geometry.outline import Arc, Circle, Line, Loop, Region
from perfqr_cad.pattern import Pattern, PatternSpec, build
from perfqr_cad.profile.walls import Walls
from perfqr_cad.surface import Placement
from perfqr_cad.symbol import encode

SHARED = Path(__file__).parents[4] / "shared" / "data"


def write_step(shape: TopoDS_Shape, path: Path, unit: str = "MM") -> Path:
    writer = STEPControl_Writer()
    Interface_Static.SetCVal_s("write.step.unit", unit)
    writer.Transfer(shape, STEPControl_StepModelType.STEPControl_AsIs)
    writer.Write(str(path))
    Interface_Static.SetCVal_s("write.step.unit", "MM")
    return path


def difference(a: TopoDS_Shape, b: TopoDS_Shape) -> TopoDS_Shape:
    return BRepAlgoAPI_Cut(a, b).Shape()


def tray(wall: float = 2.0) -> TopoDS_Shape:
    """A box of 60 × 50 × 30 mm, open at the top."""
    outer = BRepPrimAPI_MakeBox(gp_Pnt(-30, -25, 0), 60, 50, 30).Shape()
    inner = BRepPrimAPI_MakeBox(
        gp_Pnt(-30 + wall, -25 + wall, wall), 60 - 2 * wall, 50 - 2 * wall, 40
    ).Shape()
    return difference(outer, inner)


def tube(radius: float = 30.0, wall: float = 2.0) -> TopoDS_Shape:
    return difference(
        BRepPrimAPI_MakeCylinder(radius, 50).Shape(), BRepPrimAPI_MakeCylinder(radius - wall, 50).Shape()
    )


def ball(radius: float = 30.0, wall: float = 2.0) -> TopoDS_Shape:
    return difference(BRepPrimAPI_MakeSphere(radius).Shape(), BRepPrimAPI_MakeSphere(radius - wall).Shape())


def few_holes() -> Region:
    """A square of 20 mm with a square hole, a slot with round ends and a round hole: no mirror symmetry."""
    square = Loop.from_points([(-7.0, 3.0), (-3.0, 3.0), (-3.0, 7.0), (-7.0, 7.0)])
    slot = Loop(
        (
            Line((0.0, -6.0), (4.0, -6.0)),
            Arc((4.0, -6.0), (4.0, -4.0), (4.0, -5.0), True),
            Line((4.0, -4.0), (0.0, -4.0)),
            Arc((0.0, -4.0), (0.0, -6.0), (0.0, -5.0), True),
        )
    )
    round_hole = Loop((Circle((5.0, 5.0), 2.0, True),))
    outer = Loop.from_points([(-10.0, -10.0), (10.0, -10.0), (10.0, 10.0), (-10.0, 10.0)])
    return Region(outer, tuple(h.oriented(ccw=False) for h in (square, slot, round_hole)))


def holes_area(region: Region) -> float:
    return -sum(hole.area for hole in region.holes)


class Sketch:
    """As much of a pattern as carving needs."""

    def __init__(self, region: Region, size_mm: float) -> None:
        self.region, self.size_mm, self.spec = region, size_mm, PatternSpec(size_mm=size_mm)
        self.front, self.recessed = (region,), ()


SKETCH = Sketch(few_holes(), 20.0)
STRAIGHT = Walls()
SHADE_MM = 0.3  # what lies further behind the face is dark


def code(text: str, size_mm: float) -> Pattern:
    return build(
        encode(text, version=1, level="L"), PatternSpec(size_mm=size_mm, nozzle_mm=0.2, quiet_modules=2)
    )


def seen(triangles: Triangles, placement: Placement, size_mm: float, pixels: int = 400) -> np.ndarray:
    """What the reader before a code in a convex host sees, uint8 (row 0 at the top): the face light; holes,
    the far side of a hollow part and bars in the shade of their slots dark."""
    mesh = trimesh.Trimesh(triangles.vertices, triangles.faces, process=False)
    line = (np.arange(pixels) + 0.5) / pixels * size_mm * 1.2 - size_mm * 0.6
    x, y = np.meshgrid(line, -line)
    frame = placement.frame_at_centre
    points = frame.to_space(np.column_stack([x.ravel(), y.ravel(), np.full(x.size, size_mm)]))

    def distances(body: trimesh.Trimesh) -> np.ndarray:
        away = np.tile(-frame.axes[2], (len(points), 1))
        location, ray, _ = body.ray.intersects_location(points, away, multiple_hits=False)
        found = np.full(len(points), np.inf)
        found[ray] = np.linalg.norm(location - points[ray], axis=1)
        return found

    light = distances(mesh) < distances(mesh.convex_hull) + SHADE_MM
    return np.where(light, 230, 20).astype(np.uint8).reshape(pixels, pixels)
