"""A solid that receives a code: its exact faces, its mesh, and where things are on it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry.arrays import Array
from perfqr_cad.hosts.body import Body, body_of_solid
from perfqr_cad.hosts.frame import Frame, frame_at
from perfqr_cad.hosts.step.exact_face import ExactFace
from perfqr_cad.solid.kernel import booleans as kernel
from perfqr_cad.solid.kernel import occ

if TYPE_CHECKING:
    from OCP.TopoDS import TopoDS_Face, TopoDS_Solid

EDGE_STEP_MM = 1.0
ROUGH = 1e-3  # of the volume: what a mesh may be off by
PRECISE = 1e-5  # of the volume, where the kernel's quick one is off by more


@dataclass(frozen=True)
class Host:
    """A valid solid in mm and views of it, each made when first asked for."""

    name: str
    shape: TopoDS_Solid

    @staticmethod
    def of(shape: Any) -> Host:
        """The one solid of a kernel shape, a build123d object or a CadQuery object or workplane."""
        if callable(getattr(shape, "vals", None)):  # a CadQuery workplane
            shape = shape.val()
        label = getattr(shape, "label", "") or "part"
        found = kernel.solids(getattr(shape, "wrapped", shape))
        if len(found) != 1:
            raise DesignError(f"the shape has {len(found)} solids: give one solid to carve the code into")
        return Host(label, kernel.sound(found[0], label))

    @cached_property
    def faces(self) -> list[TopoDS_Face]:
        """Faces in the kernel's order."""
        return kernel.faces(self.shape)

    @cached_property
    def exact_faces(self) -> list[ExactFace]:
        """The same as exact surfaces."""
        return [ExactFace(face) for face in self.faces]

    @cached_property
    def body(self) -> Body:
        """The same as tagged triangles."""
        return body_of_solid(self.shape, self.faces)

    @cached_property
    def volume_mm3(self) -> float:
        """Volume, by as many points as it takes to agree with the mesh."""
        quick, mesh = occ.volume(self.shape), self.body.triangles.volume_mm3
        return quick if abs(quick - mesh) < ROUGH * mesh else occ.volume(self.shape, PRECISE)

    @cached_property
    def edge_points(self) -> Array:
        """Points (k, 3) along all edges, seams included, at most `EDGE_STEP_MM` apart on edges of common
        length."""
        return np.vstack([p for face in self.faces for p in kernel.edge_points(face, EDGE_STEP_MM)])

    def has_edges_under(self, frame: Frame, size_mm: float, depth_mm: float) -> bool:
        """Whether an edge runs through the box under a code, from just before its front to `depth_mm`
        behind."""
        x, y, h = frame.to_frame(self.edge_points).T
        return bool(
            np.any((np.maximum(np.abs(x), np.abs(y)) < size_mm / 2) & (h < depth_mm) & (h > -depth_mm))
        )

    def frame_near(self, face: int, point: Array, up: ArrayLike | None) -> Frame | None:
        """The frame at the exact point of a face nearest to a point; None where it has no normal."""
        foot = self.exact_faces[face].foot(point)
        if foot is None:
            return None
        return frame_at(*foot, up)
