"""The target `mesh`: a code carved into a triangle mesh, as the paper does with the Bunny (§5.2)."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry import Triangles
from perfqr_cad.hosts.body import Body, body_of_mesh
from perfqr_cad.hosts.lay import Projected
from perfqr_cad.hosts.mesh.spot import place
from perfqr_cad.hosts.step.target import GRID, LEAST_MODULES, MARGIN
from perfqr_cad.hosts.wall import Survey, survey
from perfqr_cad.hosts.wish import Wish

if TYPE_CHECKING:
    from perfqr_cad.pattern import Pattern
    from perfqr_cad.profile.walls import Walls
    from perfqr_cad.solid.shape import Solid
    from perfqr_cad.surface import Placement

Triple = tuple[float, float, float]

# A mesh is often thicker than a CAD wall and stays readable from the front: the paper's Bunny is.
MAX_WALL_MODULES = 5.0
SMOOTHED = 2.0  # samples: half a module of the smallest code


@dataclass(frozen=True)
class MeshTarget:
    """A spot on a triangle mesh.

    path       STL, OBJ, PLY, OFF or 3MF; `part` numbers one of several separate bodies, 1 the greatest
    scale      factor on the file's coordinates; or `extent_mm`, the longest edge of the bounding box wanted
    point, direction   where the reader is and looks, mm, after scaling; a point on the surface needs no
               direction; None: the flattest spot that takes the code
    up         what points up in the code; default +z, or +y where the spot looks along z
    hollow_mm  make the body a shell of that thickness first
    depth_mm   blind pockets of that depth instead of through-holes
    exact      give back the panel under the code as an exact B-spline solid instead of the carved mesh
    """

    path: str | Path | None = None
    point: Triple | None = None
    direction: Triple | None = None
    scale: float = 1.0
    extent_mm: float | None = None
    hollow_mm: float | None = None
    depth_mm: float | None = None
    part: int | None = None
    up: Triple | None = None
    exact: bool = False
    mesh: Triangles | None = field(default=None, repr=False)

    @staticmethod
    def of(mesh: Triangles, **place: Any) -> MeshTarget:
        """A mesh in memory, mm; `place` as above."""
        return MeshTarget(mesh=mesh, **place)

    @property
    def behind(self) -> None:
        """Nothing: what is seen through the holes is the body's own inside, or the ground."""

    @cached_property
    def outer(self) -> Triangles:
        """The mended, scaled body. Raises `KernelError` or `DesignError` for what cannot be mended."""
        from perfqr_cad.hosts.mesh.reader import read_body, scaled
        from perfqr_cad.hosts.mesh.repair import mend

        if self.mesh is None and not self.path:
            raise DesignError("no mesh is given: name an STL, OBJ, PLY, OFF or 3MF file")
        if self.mesh is None:
            return read_body(str(self.path), self.scale, self.extent_mm, self.part)
        return mend(scaled(self.mesh, self.scale, self.extent_mm), self.part).triangles

    @cached_property
    def body(self) -> Body:
        """The body that is carved: the outer one, or the shell made of it."""
        if self.hollow_mm is None:
            return body_of_mesh(self.outer)
        from perfqr_cad.hosts.mesh.hollow import hollowed

        return body_of_mesh(hollowed(self.outer, self.hollow_mm))

    def placement(self, size_mm: float) -> Placement:
        """Where a code of that edge lies. Raises `DesignError` with the reason and what works instead."""
        longest = float(np.ptp(self.outer.vertices, axis=0).max())
        if size_mm > longest:
            raise DesignError(
                f"a code of {size_mm:.4g} mm does not fit a body of {longest:.3g} mm: take it smaller, or if "
                f"the file is not in mm give the longest edge (extent) or a factor (scale: 1000 for metres)"
            )
        found = place(self.body, Wish(None, self.point, self.direction, self.up), size_mm, self._problem)
        laid = _projected(self.body, found, found.sheet_mm(self.depth_mm))
        laid.check(size_mm)
        return laid

    def solid(self, pattern: Pattern, placement: Placement, walls: Walls) -> Solid:
        """The carved mesh (a `Solid` of triangles only), or with `exact` the B-spline panel under the
        code.
        """
        from perfqr_cad.hosts.mesh.patch import fit_patch
        from perfqr_cad.hosts.mesh.result import mesh_solid
        from perfqr_cad.hosts.motif import Motif
        from perfqr_cad.hosts.tool import carved_mesh
        from perfqr_cad.profile.recess import NoRecess
        from perfqr_cad.profile.walls import Walls

        if not isinstance(placement, Projected):
            raise DesignError("a mesh takes its own placement: use the one this target returned")
        if walls.depth_mm is None and self.depth_mm is not None:
            walls = Walls(walls.draft_deg, walls.lip_mm, self.depth_mm)
        if self.exact:
            return fit_patch(self.body, placement, pattern.size_mm).solid(pattern, walls)
        motif = Motif.of(pattern)
        try:
            carved = carved_mesh(self.body, motif.fitted(self.body, placement), placement, walls)
        except NoRecess as reason:
            flush = carved_mesh(self.body, motif.flushed(), placement, walls)
            return mesh_solid(flush, self.name, (str(reason),))
        return mesh_solid(carved, self.name)

    @property
    def name(self) -> str:
        """The file's name without its ending."""
        return Path(self.path).stem if self.path else "mesh"

    def _problem(self, found: Survey) -> str | None:
        limit = MAX_WALL_MODULES * found.size_mm / LEAST_MODULES
        reason = found.front_problem() or found.wall_problem(self.depth_mm, limit)
        if reason is not None and "set depth" in reason and self.hollow_mm is None:
            return f"{reason}, or hollow (mm) for a shell"
        return reason


def _projected(body: Body, found: Survey, thickness_mm: float) -> Projected:
    """The projection of a code at a surveyed place on a sheet of a thickness: the mesh with the kinks between
    its facets smoothed; the rim's heights are kept on beyond the code.
    """
    near = survey(body, found.frame, found.size_mm, GRID)
    span = MARGIN * found.size_mm
    line, wider = (np.linspace(-s / 2, s / 2, GRID) for s in (found.size_mm, span))
    from scipy.interpolate import RegularGridInterpolator
    from scipy.ndimage import gaussian_filter

    heights = RegularGridInterpolator(
        (line, line),
        gaussian_filter(near.height_mm, SMOOTHED, mode="nearest"),
        bounds_error=False,
        fill_value=None,  # pyright: ignore[reportArgumentType] - None extrapolates; the stub knows numbers only
    )
    grid = np.stack(np.meshgrid(wider, wider, indexing="ij"), axis=-1)
    return Projected(found.frame, span, heights(grid), thickness_mm)
