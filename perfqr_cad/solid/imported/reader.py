# pyright: reportAttributeAccessIssue=false
# The modeller's stubs are incomplete.
"""Reading the solids of a STEP file: parts by name, in millimetres, or the reason why there are none."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from perfqr_cad.errors import DesignError, KernelError
from perfqr_cad.solid.imported import kernel

if TYPE_CHECKING:
    from OCP.TDF import TDF_Label
    from OCP.TopLoc import TopLoc_Location
    from OCP.TopoDS import TopoDS_Shape, TopoDS_Solid

STEP_MAGIC = b"ISO-10303-21"
STEP_END = b"END-ISO-10303-21;"
LISTED_NAMES = 12  # names shown in a message before "…"


@dataclass(frozen=True)
class Part:
    """One solid of a STEP file, in mm, with the name its file gives it."""

    name: str
    shape: TopoDS_Solid


def read_part(path: str | Path, part: str | int | None = None) -> Part:
    """The solid of a STEP file, or that of its parts which is named (or numbered from 1) by `part`.

    Lengths are converted to mm from whatever unit the file declares. Raises `KernelError` for a file that
    cannot be read or holds no closed solid, and `DesignError` listing the names when there are several solids
    and `part` does not choose one.
    """
    parts = read_parts(path)
    if part is None or part == "":
        if len(parts) == 1:
            return parts[0]
        raise DesignError(
            f"{Path(path).name} is an assembly of {len(parts)} solids: choose part={_names(parts)}"
        )
    chosen = [p for p in parts if p.name == str(part)]
    if not chosen and str(part).isdigit() and 1 <= int(part) <= len(parts):
        chosen = [parts[int(part) - 1]]
    if len(chosen) == 1:
        return chosen[0]
    if len(chosen) > 1:
        raise DesignError(f"{len(chosen)} parts are called {part!r}: choose by number, 1 to {len(parts)}")
    raise DesignError(f"no part {part!r} in {Path(path).name}: choose one of {_names(parts)}")


def read_parts(path: str | Path) -> tuple[Part, ...]:
    """All solids of a STEP file in file order; a closed shell counts as a solid.

    Raises `KernelError` when the file is missing, not STEP, cut short, or holds no closed solid.
    """
    path = Path(path)
    _check_envelope(path)
    named = _transfer(path)
    parts = [Part(name, solid) for name, shape in named for solid in kernel.solids(shape)]
    if not parts:
        shells = [shell for _, shape in named for shell in kernel.explore(shape, "SHELL")]
        parts = [
            Part(name, solid)
            for name, shape in named
            for shell in kernel.explore(shape, "SHELL")
            if (solid := kernel.solid_of_shell(shell)) is not None
        ]
        if not parts:
            faces = sum(len(kernel.explore(shape, "FACE")) for _, shape in named)
            raise KernelError(
                f"{path.name} holds no solid, only {len(shells)} open shells and {faces} faces: "
                "close and stitch them to a solid in the CAD system and export again"
            )
    return tuple(_numbered([Part(p.name, kernel.sound(p.shape, p.name)) for p in parts]))


def _check_envelope(path: Path) -> None:
    try:
        data = path.read_bytes()
    except OSError as error:
        raise KernelError(f"cannot read {path}: {error.strerror}") from error
    if STEP_MAGIC not in data[:512]:
        raise KernelError(f"{path.name} is not a STEP file (no ISO-10303-21 header): export it as STEP")
    if STEP_END not in data[-512:]:
        raise KernelError(
            f"{path.name} is cut short after {len(data)} bytes (no end mark): copy or export it again"
        )


def _transfer(path: Path) -> list[tuple[str, TopoDS_Shape]]:
    """Named leaf shapes of the file, placed, in mm."""
    from OCP.IFSelect import IFSelect_ReturnStatus
    from OCP.Standard import Standard_Failure
    from OCP.STEPCAFControl import STEPCAFControl_Reader
    from OCP.TCollection import TCollection_ExtendedString
    from OCP.TDF import TDF_LabelSequence
    from OCP.TDocStd import TDocStd_Document
    from OCP.TopLoc import TopLoc_Location
    from OCP.XCAFDoc import XCAFDoc_DocumentTool

    document = TDocStd_Document(TCollection_ExtendedString("XmlOcaf"))
    reader = STEPCAFControl_Reader()
    reader.SetNameMode(True)
    reader.SetColorMode(False)
    with kernel.quiet():
        try:
            read = reader.ReadFile(str(path)) == IFSelect_ReturnStatus.IFSelect_RetDone
            transferred = read and reader.Transfer(document)
        except Standard_Failure as error:
            raise KernelError(f"{path.name} cannot be translated ({error}): export it again") from error
    if not transferred:
        raise KernelError(f"{path.name} cannot be read as STEP: its data section is damaged, export it again")
    roots = TDF_LabelSequence()
    XCAFDoc_DocumentTool.ShapeTool_s(document.Main()).GetFreeShapes(roots)
    leaves: list[tuple[str, TopoDS_Shape]] = []
    for i in range(1, roots.Length() + 1):
        _collect(roots.Value(i), TopLoc_Location(), "", leaves)
    return leaves


def _collect(
    label: TDF_Label, location: TopLoc_Location, name: str, out: list[tuple[str, TopoDS_Shape]]
) -> None:
    """Walk an assembly: components carry the place, their prototypes the shape."""
    from OCP.TDF import TDF_Label, TDF_LabelSequence
    from OCP.XCAFDoc import XCAFDoc_ShapeTool

    prototype = TDF_Label()
    if XCAFDoc_ShapeTool.GetReferredShape_s(label, prototype):
        placed = location.Multiplied(XCAFDoc_ShapeTool.GetLocation_s(label))
        _collect(prototype, placed, _label_name(label) or name, out)
        return
    name = _label_name(label) or name
    if XCAFDoc_ShapeTool.IsAssembly_s(label):
        components = TDF_LabelSequence()
        XCAFDoc_ShapeTool.GetComponents_s(label, components)
        for i in range(1, components.Length() + 1):
            _collect(components.Value(i), location, name, out)
        return
    out.append((name or "part", XCAFDoc_ShapeTool.GetShape_s(label).Moved(location)))


def _label_name(label: TDF_Label) -> str:
    from OCP.TDataStd import TDataStd_Name

    attribute = TDataStd_Name()
    if not label.FindAttribute(TDataStd_Name.GetID_s(), attribute):
        return ""
    return attribute.Get().ToExtString().strip()


def _numbered(parts: list[Part]) -> list[Part]:
    """Equal names get a number, so that each can be chosen."""
    names = [p.name for p in parts]
    if len(set(names)) == len(names):
        return parts
    return [
        Part(f"{p.name} {names[: i + 1].count(p.name)}" if names.count(p.name) > 1 else p.name, p.shape)
        for i, p in enumerate(parts)
    ]


def _names(parts: tuple[Part, ...]) -> str:
    listed = ", ".join(repr(p.name) for p in parts[:LISTED_NAMES])
    return listed + (", …" if len(parts) > LISTED_NAMES else "") + f" (or 1 to {len(parts)})"
