"""The part that is filmed: its triangles in the frame of the code that it carries."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.errors import KernelError
from perfqr_cad.geometry import Triangles
from perfqr_cad.geometry.mesh_files import read_mesh
from perfqr_cad.scan.camera.camera import CodeFrame
from perfqr_cad.surface import Placement

PLATE_LEVELS = 64  # faces, lip, recess and flares of a plate end at fewer heights; a curved mesh has more
SAME_DECIMALS = 8  # of a mm: corners that agree so far are one
PLATE_SLENDERNESS = 0.25  # thickness over width: thicker than this, it is a block


@dataclass(frozen=True)
class FilmedPart:
    """Vertices (k, 3) mm and faces (m, 3) of a closed mesh, the code it shows, and whether it is a plate.

    behind   a body of the ground's colour behind the code: no part of the part, but seen through its holes
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.int64]
    code: CodeFrame
    flat: bool
    behind: Triangles | None = None

    def in_frame(self) -> NDArray[np.float64]:
        """Vertices (k, 3) with the code's centre as origin and its normal as z."""
        return self._to_frame(self.vertices)

    def behind_in_frame(self) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """Vertices (k, 3), as `in_frame`, and faces (m, 3) of what is behind; empty when nothing is."""
        if self.behind is None:
            return np.zeros((0, 3)), np.zeros((0, 3), np.int64)
        return self._to_frame(self.behind.vertices), np.asarray(self.behind.faces, np.int64)

    def _to_frame(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        return (np.asarray(points, np.float64) - self.code.centre_mm) @ self.code.axes.T


def place(
    triangles: Triangles,
    placement: Placement | None = None,
    *,
    edge_mm: float | None = None,
    behind: Triangles | None = None,
) -> FilmedPart:
    """The part in front of the camera.

    Without a placement the code is taken to lie on the top (largest z) of the mesh, centred on its
    bounding box, with the reader above; `edge_mm` is then the longer side of that box. A part with a body
    `behind` it is filmed by rays even if it is a plate.
    """
    vertices = np.asarray(triangles.vertices, np.float64)
    faces = np.asarray(triangles.faces, np.int64)
    if len(faces) == 0:
        raise KernelError("the part has 0 triangles: at least 4 make a solid, so check how it was meshed")
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    if not np.count_nonzero(high - low) >= 2:
        raise KernelError("the part has no area that could be filmed: check how it was meshed")
    if placement is None:
        centre, axes = np.array([(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, high[2]]), np.eye(3)
    else:
        centre, axes = placement.point((0.0, 0.0))[0], placement.reader_axes()
    edge = edge_mm if edge_mm is not None else float((high - low)[:2].max())
    part = FilmedPart(vertices, faces, CodeFrame(centre, axes, edge), flat=False, behind=behind)
    level = behind is None and (placement is None or placement.is_flat)
    return replace(part, flat=level and _is_plate(part.in_frame()) and _encloses(faces))


def _encloses(faces: NDArray[np.int64]) -> bool:
    """Whether faces (m, 3) bound a volume: every edge is passed as often one way as the other. Bodies that
    touch share edges, so that there may be more than two faces at one."""
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    count = int(faces.max()) + 1
    return np.array_equal(np.sort(start * count + end), np.sort(end * count + start))


def _is_plate(vertices: NDArray[np.float64]) -> bool:
    """A mesh is filmed as a plate when nothing of it but walls lies between a few levels."""
    levels = np.unique(np.round(vertices[:, 2], 3))
    span = np.ptp(vertices, axis=0)
    return len(levels) <= PLATE_LEVELS and span[2] < PLATE_SLENDERNESS * max(span[0], span[1])


def load_mesh(path: Path | str) -> Triangles:
    """Triangles of an .stl, .3mf, .ply, .obj or .off file, equal corners made one.

    KernelError if it cannot be read.
    """
    mesh = read_mesh(path)
    corners = mesh.vertices[mesh.faces].reshape(-1, 3)
    _, first, faces = np.unique(
        np.round(corners, SAME_DECIMALS), axis=0, return_index=True, return_inverse=True
    )
    return Triangles(corners[first], faces.reshape(-1, 3))
