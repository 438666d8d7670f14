"""A mesh file as one closed body of the size that is wanted: read and mended in one process of its own.

Mending looks at every pair of a mesh's pieces, whoever made them.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry import Triangles
from perfqr_cad.geometry.mesh_files import ask, triangles_of
from perfqr_cad.isolated import Message


def read_body(
    path: str | Path, scale: float = 1.0, extent_mm: float | None = None, part: int | None = None
) -> Triangles:
    """The mended body of a mesh file.

    scale, extent_mm   factor on the coordinates; or the longest edge of the bounding box wanted
    part               number of one of several separate bodies, 1 the greatest

    Raises `KernelError` or `DesignError` for a file that cannot be read or mended, as `read_mesh` and `mend`.
    """
    return Triangles(*ask(f"{__name__}:mender", path, scale, extent_mm, part).arrays)


def mender(
    kind: str, name: str, scale: float, extent_mm: float | None, part: int | None
) -> Callable[[Message], Message]:
    """The job of the process: a file's bytes are answered by the vertices and faces of its body."""
    from perfqr_cad.hosts.mesh.repair import mend

    def answer(request: Message) -> Message:
        raw = triangles_of(request.arrays[0].tobytes(), kind, name)
        body = mend(scaled(raw, scale, extent_mm), part)
        return Message(None, (body.vertices, body.faces))

    return answer


def scaled(mesh: Triangles, scale: float, extent_mm: float | None) -> Triangles:
    """A mesh times a factor, or so that its longest edge is `extent_mm`. DesignError for no such factor."""
    factor = scale
    if extent_mm is not None:
        factor = extent_mm / float(np.ptp(mesh.vertices, axis=0).max())
    if not (np.isfinite(factor) and factor > 0):
        raise DesignError(f"scale {factor:g} is not above 0: give the longest edge in mm, or a factor")
    return Triangles(mesh.vertices * factor, mesh.faces)
