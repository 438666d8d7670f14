"""The target `mesh`: a code carved into a triangle mesh, as the paper does with the Bunny (§5.2)."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry import Triangles
from perfqr_cad.hosts.body import Body, body_of_mesh
from perfqr_cad.hosts.host_placement import GRID, MARGIN, Projected
from perfqr_cad.hosts.mesh.mesh_search import place
from perfqr_cad.hosts.place import PlaceRequest
from perfqr_cad.hosts.survey import Survey, survey

if TYPE_CHECKING:
    from perfqr_cad.pattern import Pattern
    from perfqr_cad.profile.walls import Walls
    from perfqr_cad.solid.shape import Solid
    from perfqr_cad.surface import Placement

Triple = tuple[float, float, float]

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
    exact      give back the panel under the code as an exact B-spline solid instead of the carved mesh

    >>> import trimesh
    >>> plate = trimesh.creation.box((40, 40, 2))
    >>> target = MeshTarget.of(Triangles(plate.vertices, plate.faces), point=(0, 0, 1))
    >>> round(target.placement(24.0).thickness_mm, 6)
    2.0
    """

    path: str | Path | None = None
    point: Triple | None = None
    direction: Triple | None = None
    scale: float = 1.0
    extent_mm: float | None = None
    hollow_mm: float | None = None
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
        return mend(scaled(self.mesh, self.scale, self.extent_mm), self.part)

    @cached_property
    def body(self) -> Body:
        """The body that is carved: the outer one, or the shell made of it."""
        if self.hollow_mm is None:
            return body_of_mesh(self.outer)
        from perfqr_cad.hosts.mesh.hollow import hollowed

        return body_of_mesh(hollowed(self.outer, self.hollow_mm))

    def placement(self, size_mm: float, depth_mm: float | None = None) -> Placement:
        """Where a code of that edge lies, as through-holes or as pockets `depth_mm` deep.

        Raises `DesignError` with the reason and what works instead.
        """
        longest = float(np.ptp(self.outer.vertices, axis=0).max())
        if size_mm > longest:
            raise DesignError(
                f"a code of {size_mm:.4g} mm does not fit a body of {longest:.3g} mm: take it smaller, or if "
                f"the file is not in mm give the longest edge (extent) or a factor (scale: 1000 for metres)"
            )
        wanted = PlaceRequest(None, self.point, self.direction, self.up)
        found = place(self.body, wanted, size_mm, partial(self._problem, depth_mm=depth_mm))
        placement = _projected(self.body, found, found.sheet_mm(depth_mm))
        placement.check(size_mm)
        return placement

    def solid(self, pattern: Pattern, placement: Placement, walls: Walls) -> Solid:
        """The carved mesh (a `Solid` of triangles only), or with `exact` the B-spline panel under the
        code."""
        from perfqr_cad.hosts.cutters import carved_mesh
        from perfqr_cad.hosts.host_profile import host_profile, with_fitted_bars
        from perfqr_cad.hosts.mesh.fitted_panel import fit_panel
        from perfqr_cad.hosts.mesh.result import mesh_solid
        from perfqr_cad.profile.recess import NoRecess

        if not isinstance(placement, Projected):
            raise DesignError("a mesh takes its own placement: use the one this target returned")
        if self.exact:
            return fit_panel(self.body, placement, pattern.size_mm).solid(pattern, walls)
        profile = host_profile(pattern)
        try:
            carved = carved_mesh(self.body, with_fitted_bars(profile, self.body, placement), placement, walls)
        except NoRecess as reason:
            flush = carved_mesh(self.body, profile.with_flush_bars(), placement, walls)
            return mesh_solid(flush, self.name, (str(reason),))
        return mesh_solid(carved, self.name)

    @property
    def name(self) -> str:
        """The file's name without its ending."""
        return Path(self.path).stem if self.path else "mesh"

    def _problem(self, found: Survey, depth_mm: float | None) -> str | None:
        reason = found.problem(depth_mm)
        if reason is not None and "set depth" in reason and self.hollow_mm is None:
            return f"{reason}, or hollow (mm) for a shell"
        return reason


def _projected(body: Body, found: Survey, thickness_mm: float) -> Projected:
    """The projection of a code at a surveyed place on a sheet of a thickness: the mesh with the kinks between
    its facets smoothed; the rim's heights are kept on beyond the code."""
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
