# pyright: reportAttributeAccessIssue=false
# The modeller's stubs are incomplete.
"""The finished part: an exact boundary, what was measured on it, and its triangles."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from perfqr_cad.surface import Triangles

from .brep import Brep

if TYPE_CHECKING:
    from OCP.TopoDS import TopoDS_Solid

    from .lettering import Lettering

Corner = tuple[float, float, float]
Colour = tuple[float, float, float]

LIGHT: Colour = (0.92, 0.92, 0.90)  # sRGB of the part and, behind it, of the dark tone
DARK: Colour = (0.05, 0.05, 0.06)


@dataclass(frozen=True)
class Solid:
    """A solid in mm. `valid` says that every check passed; `problems` says which did not.

    exact                the boundary as tables, or a shape of the modeller where that was carved; None when
                         there are triangles only (a carved mesh)
    expected_volume_mm3  from the outline and the surface, without the boundary; None where there is no such
                         figure
    bbox_mm              least and greatest corner
    notes                what was made otherwise than asked, and why
    extras               further solids of the same part, such as a backing plate
    lettering            what is written on the face, in the pattern plane; None without
    """

    exact: Brep | TopoDS_Solid | None
    triangles: Triangles
    valid: bool
    solids: int
    faces: int
    edges: int
    volume_mm3: float
    bbox_mm: tuple[Corner, Corner]
    expected_volume_mm3: float | None = None
    problems: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    name: str = "perforated-qr"
    colour: Colour = LIGHT
    extras: tuple[Solid, ...] = ()
    lettering: Lettering | None = None

    @cached_property
    def brep(self) -> Brep | None:
        """The boundary as tables."""
        if self.exact is None or isinstance(self.exact, Brep):
            return self.exact
        from . import occ
        from .survey import brep_of

        with occ.kernel("reading the solid", "repair it in a CAD program"):
            return brep_of(self.exact)

    @cached_property
    def shape(self) -> TopoDS_Solid | None:
        """The boundary as a shape of the modeller, made when it is first asked for."""
        if not isinstance(self.exact, Brep):
            return self.exact
        from .kernel_shape import KernelShape

        return KernelShape(self.exact).solid()
