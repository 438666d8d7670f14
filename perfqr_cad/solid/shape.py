"""The finished part: an exact boundary, what was measured on it, and its triangles."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from perfqr_cad.geometry import Region, Triangles
from perfqr_cad.geometry.triangles import Corner
from perfqr_cad.profile.colour import LIGHT, Colour
from perfqr_cad.solid.tables.brep import Brep

if TYPE_CHECKING:
    from OCP.TopoDS import TopoDS_Solid


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
    letters              of a caption, in the pattern plane; they stand relief_mm out of the front, or, where
                         that is below 0, are sunk into it
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
    letters: tuple[Region, ...] = ()
    relief_mm: float = 0.0

    @property
    def is_carved(self) -> bool:
        """Whether it was carved into a body of the user's: there is more of it than the pattern."""
        return not isinstance(self.exact, Brep)

    @cached_property
    def brep(self) -> Brep | None:
        """The boundary as tables."""
        if self.exact is None or isinstance(self.exact, Brep):
            return self.exact
        from perfqr_cad.solid.kernel import occ
        from perfqr_cad.solid.kernel.from_shape import brep_of

        with occ.kernel("reading the solid", "repair it in a CAD program"):
            return brep_of(self.exact)

    @cached_property
    def shape(self) -> TopoDS_Solid | None:
        """The boundary as a shape of the modeller, made when it is first asked for."""
        if not isinstance(self.exact, Brep):
            return self.exact
        from perfqr_cad.solid.kernel.to_shape import KernelShape

        return KernelShape(self.exact).solid()
