"""STEP files, written in linear time."""

from __future__ import annotations

from pathlib import Path

from perfqr_cad.solid.shape import Solid
from perfqr_cad.solid.step.document import Document, StepBody
from perfqr_cad.solid.step.tessellation import tessellated
from perfqr_cad.solid.step.text import Part21
from perfqr_cad.solid.step.topology import Topology
from perfqr_cad.solid.step.validation import measured


def write_step(solid: Solid, path: str | Path, *, product: str | None = None) -> None:
    """Write a solid and its extras as AP242: exact faces, or the triangles of a body that has no others.

    Raises `KernelError` for a body with neither.
    """
    bodies = (solid, *solid.extras)
    part = Part21()
    document, topology = Document(part), Topology(part)
    written: list[StepBody] = []
    for body in bodies:
        if body.brep is None:
            written.append(tessellated(part, body))
        else:
            written.append(
                StepBody(topology.solid(body.brep, body.name), body.name, body.colour, measured(body))
            )
    title = product or solid.name
    document.write(written, title)
    Path(path).write_text(part.file(f"{title}.step", title), "ascii")
