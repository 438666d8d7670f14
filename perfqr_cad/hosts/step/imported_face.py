"""The target that is a face of an imported solid."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from perfqr_cad.errors import DesignError
from perfqr_cad.hosts.host_placement import GRID, MARGIN, HostPlacement, Projected
from perfqr_cad.hosts.place import PlaceRequest
from perfqr_cad.hosts.step.face_search import place
from perfqr_cad.hosts.survey import Survey, survey

if TYPE_CHECKING:
    from perfqr_cad.geometry import Triangles
    from perfqr_cad.hosts.step.host import Host
    from perfqr_cad.pattern import Pattern
    from perfqr_cad.profile.walls import Walls
    from perfqr_cad.solid.shape import Solid
    from perfqr_cad.surface import Placement

Triple = tuple[float, float, float]

# Of a wrapped code's edge: what the reader before the centre sees of it on a strongly bent face.
WRAP_SEEN = 0.8


@dataclass(frozen=True)
class ImportedFace:
    """A face of a solid in a STEP file.

    path       the file; `part` names (or numbers from 1) a solid of an assembly
    face       number from 1, as CAD programs count; None or 0: by `point`, else the largest that takes the
               code
    point, direction   where the reader is and looks, mm; a point on the surface needs no direction
    up         what points up in the code; default +z, or +y on faces that look along z
    wrap       lay the code along the face (lengths kept) instead of projecting it along the centre's normal
    shape      a solid in memory instead of a file: see `of`
    behind     a dark body that the part sits on, seen through its holes: only the camera knows of it (see
               `mesh_shape`)

    >>> from build123d import Box
    >>> target = ImportedFace.of(Box(40, 40, 2), point=(0, 0, 1))
    >>> placement = target.placement(24.0)
    >>> round(placement.thickness_mm, 6), placement.normal((0, 0)).round(6).tolist()
    (2.0, [[0.0, 0.0, 1.0]])
    """

    path: str | Path | None = None
    face: int | None = None
    point: Triple | None = None
    direction: Triple | None = None
    part: str | int | None = None
    up: Triple | None = None
    wrap: bool = False
    shape: Any = field(default=None, repr=False)
    behind: Triangles | None = field(default=None, repr=False)

    @staticmethod
    def of(shape: Any, **place: Any) -> ImportedFace:
        """A face of a solid in memory: a kernel shape, build123d object or CadQuery workplane; `place` as
        above."""
        return ImportedFace(shape=shape, **place)

    @cached_property
    def host(self) -> Host:
        """The solid. Raises `KernelError` or `DesignError` for a file without one to choose."""
        from perfqr_cad.hosts.step.host import Host
        from perfqr_cad.hosts.step.reader import read_part

        if self.shape is not None:
            return Host.of(self.shape)
        if not self.path:
            raise DesignError("no STEP file is given: name one, or pass a solid")
        chosen = read_part(self.path, self.part)
        return Host(chosen.name, chosen.shape)

    def placement(self, size_mm: float, depth_mm: float | None = None) -> Placement:
        """Where a code of that edge lies, as through-holes or as pockets `depth_mm` deep.

        Raises `DesignError` with the reason and what works instead.
        """
        wanted = PlaceRequest(self.face or None, self.point, self.direction, self.up)
        seen = WRAP_SEEN if self.wrap else 1.0
        found = place(self.host, wanted, size_mm, lambda survey: survey.problem(depth_mm), seen)
        placement = (
            self._wrapped(found, size_mm, depth_mm)
            if self.wrap
            else projected(self.host, found, found.sheet_mm(depth_mm))
        )
        placement.check(size_mm)
        return placement

    def solid(self, pattern: Pattern, placement: Placement, walls: Walls) -> Solid:
        """The imported solid with the pattern in its wall."""
        from perfqr_cad.hosts.host_profile import host_profile
        from perfqr_cad.hosts.step.carve import carve

        if not isinstance(placement, HostPlacement):
            raise DesignError("an imported face takes its own placement: use the one this target returned")
        return carve(self.host, host_profile(pattern), placement, walls)

    def _wrapped(self, found: Survey, size_mm: float, depth_mm: float | None) -> HostPlacement:
        from perfqr_cad.hosts.step.wrap import survey_wrapped, wrapped

        middle = found.front.shape[0] // 2
        face = self.host.exact_faces[int(found.front[middle, middle])]
        placement = wrapped(face, found.frame, MARGIN * size_mm, found.sheet_mm(depth_mm))
        placement.check(size_mm)
        along = survey_wrapped(self.host.body, placement, size_mm)
        if (reason := along.problem(depth_mm)) is not None:
            raise DesignError(
                f"a code of {size_mm:.4g} mm cannot be wrapped here: {reason}; project it, move it or "
                f"take it smaller"
            )
        return replace(placement, thickness_mm=along.sheet_mm(depth_mm))


def projected(host: Host, found: Survey, thickness_mm: float) -> Projected:
    """The projection of a code at a surveyed place on a sheet of a thickness, exact on the solid's faces."""
    frame, span = found.frame, MARGIN * found.size_mm
    line = np.linspace(-span / 2, span / 2, GRID)
    x, y = (a.ravel() for a in np.meshgrid(line, line))
    near = survey(host.body, frame, found.size_mm, GRID)
    faces = near.front.ravel()
    flat = frame.to_space(np.column_stack([x, y, np.zeros(x.size)]))
    guesses = flat + np.outer(near.height_mm.ravel(), frame.axes[2])
    heights = np.empty(x.size)
    frames = np.broadcast_to(frame.axes, (x.size, 3, 3))
    for face in np.unique(faces):
        on = faces == face
        exact = host.exact_faces[face].meet(flat[on], frames[on], guesses[on], span)[1]
        heights[on] = frame.to_frame(exact)[:, 2]
    return Projected(frame, span, heights.reshape(GRID, GRID), thickness_mm)
