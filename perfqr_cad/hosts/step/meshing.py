"""Triangles of a solid, for those who only want to look at it. The modeller is loaded when it is needed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from perfqr_cad.geometry import Triangles
from perfqr_cad.geometry.mesh_files import require_size
from perfqr_cad.isolated import Message
from perfqr_cad.solid.step.envelope import ask

if TYPE_CHECKING:
    from perfqr_cad.solid.step.transfer import StepPart


def mesh_step(path: str | Path) -> Triangles:
    """All solids of a STEP file as triangles where they stand, mm. `KernelError` for an unsound one."""
    vertices, faces = ask(f"{__name__}:mesher", path).arrays
    return Triangles(vertices, faces)


def mesher(name: str) -> Callable[[Message], Message]:
    """The job of a process: a file's bytes are answered by the vertices and faces of its parts."""
    from perfqr_cad.solid.step.reader import parts_of

    def answer(request: Message) -> Message:
        first, *others = (_triangles(part) for part in parts_of(request.arrays[0].tobytes(), name))
        whole = first.joined(*others)
        require_size(whole.vertices, name)
        return Message(None, (whole.vertices, whole.faces))

    return answer


def mesh_shape(shape: Any) -> Triangles:
    """The one solid of a kernel shape, build123d or CadQuery object as triangles, mm.

    Raises `DesignError` for a shape of no or several solids, `KernelError` for an unsound one.
    """
    from perfqr_cad.hosts.step.host import Host

    return Host.of(shape).body.triangles


def _triangles(part: StepPart) -> Triangles:
    """A part's mesh, outside out. Where it is closed it tells the whole boundary; the solid itself, which the
    modeller takes longer to check than to mesh, is looked at and mended only where it is not."""
    from perfqr_cad.hosts.step.host import Host
    from perfqr_cad.solid.kernel import booleans as kernel

    mesh = Host(part.name, part.shape).body.triangles
    if not mesh.closed:
        return Host(part.name, kernel.sound(part.shape, part.name)).body.triangles
    return mesh if mesh.volume_mm3 > 0 else Triangles(mesh.vertices, mesh.faces[:, ::-1])
