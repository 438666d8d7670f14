"""Reading the solids of a STEP file: named, coloured, placed, in mm, or the reason why there are none.

The reader's own repairs are quadratic on perforated faces and can be left out for files of `write_step`.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from OCP.BRep import BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeSolid
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
from perfqr_cad.isolated import Message, without_files
from perfqr_cad.profile.colour import Colour
from perfqr_cad.solid.kernel import occ
from perfqr_cad.solid.kernel.occ import FACE, SHELL, SOLID, explore
from perfqr_cad.solid.step.envelope import AGAIN, ask, require_readable
from perfqr_cad.solid.step.transfer import StepPart, packed, unpacked

# The reader's healing steps, all of which look again at every wire of a face; a sound file needs none.
HEALING = (
    "FixFreeShellMode", "FixFreeFaceMode", "FixFreeWireMode", "FixSolidMode", "FixShellMode", "FixFaceMode",
    "FixWireMode", "FixVertexPositionMode", "FixSelfIntersectionMode", "FixIntersectingWiresMode",
    "FixSelfIntersectingEdgeMode", "FixIntersectingEdgesMode", "FixNonAdjacentIntersectingEdgesMode",
    "FixOrientationMode", "FixMissingSeamMode", "FixLoopWiresMode", "FixSplitFaceMode", "FixNotchedEdgesMode",
    "FixAddNaturalBoundMode", "FixSmallAreaWireMode",
)  # fmt: skip


def read_step(path: str | Path, *, heal: bool = True) -> tuple[StepPart, ...]:
    """The solids of a STEP file in file order, in mm whatever its unit; where there are none, its closed
    shells as solids. `heal` False skips the reader's repairs.

    Raises `KernelError` for a file that is missing, not STEP, cut short, damaged, or without a closed body,
    or that the modeller cannot read within limits.
    """
    return unpacked(ask(f"{__name__}:parts_reader", path, heal))


def parts_reader(name: str, heal: bool) -> Callable[[Message], Message]:
    """The job of a process: a file's bytes are answered by its parts."""
    return lambda request: packed(parts_of(request.arrays[0].tobytes(), name, heal=heal))


def parts_of(content: bytes, name: str, *, heal: bool = True) -> tuple[StepPart, ...]:
    """What `read_step` gives, from a file's bytes, by this process itself."""
    require_readable(content, name)
    with without_files():  # a file may name others
        document = _transferred(content, name, heal)
    colours = XCAFDoc_DocumentTool.ColorTool_s(document.Main())
    roots = TDF_LabelSequence()
    XCAFDoc_DocumentTool.ShapeTool_s(document.Main()).GetFreeShapes(roots)
    leaves = [leaf for root in _each(roots) for leaf in _leaves(root, TopLoc_Location(), "")]
    parts = [part for leaf in leaves for part in leaf.solids(colours)]
    parts = parts or [part for leaf in leaves for part in leaf.closed_shells(colours)]
    if not parts:
        shells, faces = (sum(len(explore(leaf.shape, kind)) for leaf in leaves) for kind in (SHELL, FACE))
        raise KernelError(
            f"{name} holds no solid, only {shells} open shells and {faces} faces: close and stitch "
            f"them to a solid in the CAD system and export again"
        )
    return tuple(parts)


def _transferred(content: bytes, name: str, heal: bool) -> TDocStd_Document:
    """The file's assembly tree, its shapes translated."""
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
    with occ.kernel(f"reading {name}", AGAIN):
        read = reader.ReadStream(name, io.BytesIO(content)) == IFSelect_ReturnStatus.IFSelect_RetDone
        if not (read and reader.Transfer(document)):
            raise KernelError(f"{name} has a damaged data section: {AGAIN}")
    return document


@dataclass(frozen=True)
class _Leaf:
    """A shape of the assembly tree that is no assembly, where it was modelled, and where the tree puts it."""

    name: str
    shape: TopoDS_Shape
    place: TopLoc_Location

    def solids(self, colours: XCAFDoc_ColorTool) -> Iterator[StepPart]:
        for solid in explore(self.shape, SOLID):
            yield self._part(solid, TopoDS.Solid_s(solid), colours)

    def closed_shells(self, colours: XCAFDoc_ColorTool) -> Iterator[StepPart]:
        for shell in explore(self.shape, SHELL):
            if BRep_Tool.IsClosed_s(shell):
                yield self._part(shell, BRepBuilderAPI_MakeSolid(TopoDS.Shell_s(shell)).Solid(), colours)

    def _part(self, shape: TopoDS_Shape, solid: TopoDS_Solid, colours: XCAFDoc_ColorTool) -> StepPart:
        return StepPart(
            TopoDS.Solid_s(solid.Moved(self.place)), self.name, _colour(colours, shape, self.shape)
        )


def _leaves(label: TDF_Label, place: TopLoc_Location, name: str) -> Iterator[_Leaf]:
    """Walk an assembly: components carry the place, their prototypes the shape, either the name."""
    name = _name(label) or name
    if XCAFDoc_ShapeTool.IsAssembly_s(label):
        components = TDF_LabelSequence()
        XCAFDoc_ShapeTool.GetComponents_s(label, components)
        for component in _each(components):
            prototype = TDF_Label()
            XCAFDoc_ShapeTool.GetReferredShape_s(component, prototype)
            here = place.Multiplied(XCAFDoc_ShapeTool.GetLocation_s(component))
            yield from _leaves(prototype, here, _name(component) or name)
    else:
        yield _Leaf(name, XCAFDoc_ShapeTool.GetShape_s(label), place)


def _each(labels: TDF_LabelSequence) -> Iterator[TDF_Label]:
    return (labels.Value(i) for i in range(1, labels.Length() + 1))


def _name(label: TDF_Label) -> str:
    found = TDataStd_Name()
    return (
        unscrambled(found.Get().ToExtString()) if label.FindAttribute(TDataStd_Name.GetID_s(), found) else ""
    )


def unscrambled(name: str) -> str:
    """A name without blanks around it. Some writers encode UTF-8 twice, so that ö arrives as two letters: a
    name that is UTF-8 read as Latin-1 is read again.
    """
    try:
        return name.encode("latin-1").decode("utf-8").strip()
    except UnicodeError:
        return name.strip()


def _colour(colours: XCAFDoc_ColorTool, *shapes: TopoDS_Shape) -> Colour | None:
    """The colour given to the first of the shapes that has one, as sRGB."""
    found = Quantity_Color()
    for shape in shapes:
        for kind in (XCAFDoc_ColorType.XCAFDoc_ColorSurf, XCAFDoc_ColorType.XCAFDoc_ColorGen):
            if colours.GetColor(shape, kind, found):
                red, green, blue = found.Values(Quantity_TypeOfColor.Quantity_TOC_sRGB)
                return red, green, blue
    return None
