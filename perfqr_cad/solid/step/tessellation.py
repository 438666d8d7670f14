"""A body of triangles in STEP (ISO 10303-42, tessellated shape model): what a carved mesh is, no more."""

from __future__ import annotations

from perfqr_cad.errors import KernelError
from perfqr_cad.solid.shape import Solid
from perfqr_cad.solid.step.document import StepBody
from perfqr_cad.solid.step.text import Part21, reals, text
from perfqr_cad.solid.step.validation import measured

REPRESENTATION = "TESSELLATED_SHAPE_REPRESENTATION"


def tessellated(part: Part21, solid: Solid) -> StepBody:
    """Write the triangles of a solid as one tessellated solid. Raises `KernelError` where there are none."""
    vertices, faces = solid.triangles.vertices, solid.triangles.faces
    if not len(faces):
        raise KernelError(f"{solid.name} has 0 faces and 0 triangles: build it again")
    points = ",".join(map(reals, vertices.tolist()))
    corners = ",".join(f"({a},{b},{c})" for a, b, c in (faces + 1).tolist())
    coordinates = part.add(f"COORDINATES_LIST('',{len(vertices)},({points}))")
    face = part.add(f"TRIANGULATED_FACE('',#{coordinates},{len(vertices)},(),$,(),({corners}))")
    body = part.add(f"TESSELLATED_SOLID({text(solid.name)},(#{face}),$)")
    return StepBody(body, solid.name, solid.colour, measured(solid), REPRESENTATION)
