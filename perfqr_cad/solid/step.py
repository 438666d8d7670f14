# pyright: reportAttributeAccessIssue=false
# The modeller's stubs are incomplete.
"""STEP files: written in linear time, read without the healing that is quadratic on perforated faces."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.Quantity import Quantity_Color, Quantity_TypeOfColor
from OCP.Resource import Resource_DataMapOfAsciiStringAsciiString
from OCP.STEPCAFControl import STEPCAFControl_Reader
from OCP.TCollection import TCollection_AsciiString, TCollection_ExtendedString
from OCP.TDataStd import TDataStd_Name
from OCP.TDF import TDF_Label, TDF_LabelSequence
from OCP.TDocStd import TDocStd_Document
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS, TopoDS_Shape, TopoDS_Solid
from OCP.XCAFDoc import XCAFDoc_ColorTool, XCAFDoc_ColorType, XCAFDoc_DocumentTool, XCAFDoc_ShapeTool

from perfqr_cad.errors import KernelError

from . import occ
from .occ import SOLID, explore
from .shape import Colour, Solid
from .step_document import Body, Document
from .step_tessellation import tessellated
from .step_text import Part21
from .step_topology import Topology

# The reader's healing steps, all of which look again at every wire of a face; a sound file needs none.
HEALING = (
    "FixFreeShellMode", "FixFreeFaceMode", "FixFreeWireMode", "FixSolidMode", "FixShellMode", "FixFaceMode",
    "FixWireMode", "FixVertexPositionMode", "FixSelfIntersectionMode", "FixIntersectingWiresMode",
    "FixSelfIntersectingEdgeMode", "FixIntersectingEdgesMode", "FixNonAdjacentIntersectingEdgesMode",
    "FixOrientationMode", "FixMissingSeamMode", "FixLoopWiresMode", "FixSplitFaceMode", "FixNotchedEdgesMode",
    "FixAddNaturalBoundMode", "FixSmallAreaWireMode",
)  # fmt: skip


@dataclass(frozen=True)
class StepPart:
    """A solid of a STEP file, in mm where the assembly puts it, with its product's name and its colour."""

    shape: TopoDS_Solid
    name: str
    colour: Colour | None


def write_step(solid: Solid, path: str | Path, *, product: str | None = None) -> None:
    """Write a solid and its extras as AP242: exact faces, or the triangles of a body that has no others.

    Raises `KernelError` for a body with neither.
    """
    bodies = (solid, *solid.extras)
    part = Part21()
    document, topology = Document(part), Topology(part)
    written: list[Body] = []
    with occ.kernel("writing STEP", "rebuild the faces of other kinds as B-spline surfaces"):
        for body in bodies:
            if body.brep is None:
                written.append(tessellated(part, body))
            else:
                written.append(Body(topology.solid(body.brep, body.name), body.name, body.colour))
    title = product or solid.name
    document.write(written, title)
    Path(path).write_text(part.file(f"{title}.step", title), "ascii")


def read_step(path: str | Path, *, heal: bool = True) -> tuple[StepPart, ...]:
    """The solids of a STEP file, in mm whatever its unit. `heal` False skips the reader's repairs: a file of
    `write_step` needs none, and they take time quadratic in the holes.

    Raises `KernelError` for a file that cannot be read or holds no solid.
    """
    occ.silence()
    document = TDocStd_Document(TCollection_ExtendedString("perfqr"))
    reader = STEPCAFControl_Reader()
    reader.SetNameMode(True)
    reader.SetColorMode(True)
    if not heal:
        off = Resource_DataMapOfAsciiStringAsciiString()
        for step in HEALING:
            off.Bind(TCollection_AsciiString(f"FixShape.{step}"), TCollection_AsciiString("0"))
        reader.SetShapeFixParameters(off)
    source = Path(path)
    if not source.is_file():
        raise KernelError(f"{source}: no such file; give a STEP file")
    remedy = "export it again as STEP AP203, AP214 or AP242"
    with occ.kernel(f"reading {source.name}", remedy):
        done = reader.ReadFile(str(source)) == IFSelect_ReturnStatus.IFSelect_RetDone and reader.Transfer(
            document
        )
    if not done:
        raise KernelError(f"{source.name} is no readable STEP file (cut short?): {remedy}")
    shapes, colours = (
        XCAFDoc_DocumentTool.ShapeTool_s(document.Main()),
        XCAFDoc_DocumentTool.ColorTool_s(document.Main()),
    )
    roots = TDF_LabelSequence()
    shapes.GetFreeShapes(roots)
    parts = [
        p
        for i in range(1, roots.Length() + 1)
        for p in _parts(roots.Value(i), colours, TopLoc_Location(), "")
    ]
    if not parts:
        raise KernelError(f"{source.name} holds no solid: sew its faces into one and export it again")
    return tuple(parts)


def _parts(label: TDF_Label, colours: XCAFDoc_ColorTool, place: TopLoc_Location, name: str) -> list[StepPart]:
    """The solids under a label of the assembly tree, moved to where the tree puts them."""
    if XCAFDoc_ShapeTool.IsAssembly_s(label):
        children = TDF_LabelSequence()
        XCAFDoc_ShapeTool.GetComponents_s(label, children)
        found: list[StepPart] = []
        for i in range(1, children.Length() + 1):
            child, part = children.Value(i), TDF_Label()
            XCAFDoc_ShapeTool.GetReferredShape_s(child, part)
            here = place.Multiplied(XCAFDoc_ShapeTool.GetLocation_s(child))
            found += _parts(part, colours, here, _name(part))
        return found
    whole = XCAFDoc_ShapeTool.GetShape_s(label)
    return [
        StepPart(TopoDS.Solid_s(solid.Moved(place)), name or _name(label), _colour(colours, solid, whole))
        for solid in explore(whole, SOLID)
    ]


def _name(label: TDF_Label) -> str:
    name = TDataStd_Name()
    return name.Get().ToExtString() if label.FindAttribute(TDataStd_Name.GetID_s(), name) else ""


def _colour(colours: XCAFDoc_ColorTool, *shapes: TopoDS_Shape) -> Colour | None:
    """The colour given to the first of the shapes that has one, as sRGB."""
    found = Quantity_Color()
    for shape in shapes:
        for kind in (XCAFDoc_ColorType.XCAFDoc_ColorSurf, XCAFDoc_ColorType.XCAFDoc_ColorGen):
            if colours.GetColor(shape, kind, found):
                red, green, blue = found.Values(Quantity_TypeOfColor.Quantity_TOC_sRGB)
                return red, green, blue
    return None
