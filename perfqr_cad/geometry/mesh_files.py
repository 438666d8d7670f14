"""Triangles from STL, OBJ, PLY, OFF and 3MF files, whoever wrote them.

The files are read in a process of their own, by trimesh and, for 3MF, by `threemf_file`; what comes back are
numbers, looked through before they are believed.
"""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.bounded import MIB, read_bytes
from perfqr_cad.errors import KernelError
from perfqr_cad.geometry.triangles import Triangles
from perfqr_cad.isolated import Message, Refusal, once

FORMATS = ("stl", "obj", "ply", "off", "3mf")
MAX_BYTES = 256 * MIB
MAX_TRIANGLES = 4_000_000  # of 50 bytes each in STL
MAX_COORDINATE = 1e7  # 10 km in mm, 10 m in micrometres


def read_mesh(path: str | Path, scale: float = 1.0) -> Triangles:
    """The triangles of a file as they are, not welded, times `scale`.

    3MF declares its unit and is converted to mm; the others have none and are taken as mm. Raises
    `KernelError` for a file that is missing, unreadable, of another kind, without triangles or beyond limits.
    """
    vertices, faces = ask(f"{__name__}:reader", path).arrays
    return Triangles(vertices * scale, faces)


def ask(job: str, path: str | Path, *arguments: Any) -> Message:
    """What a job makes of a mesh file in a process of its own, called with its kind, name and `arguments`.

    `KernelError` if the file is none, or cannot be read within limits.
    """
    path = Path(path)
    kind = path.suffix.lower().lstrip(".")
    if kind not in FORMATS:
        raise KernelError(f"{path.name} is no mesh this program reads: give one of {', '.join(FORMATS)}")
    content = read_bytes(path, MAX_BYTES, KernelError, f"a mesh file ({', '.join(FORMATS)})")
    return once(
        job,
        (kind, path.name, *arguments),
        Message(None, (np.frombuffer(content, np.uint8),)),
        Refusal(KernelError, f"{path.name} cannot be read as {kind.upper()}", "export the mesh again as STL"),
    )


def reader(kind: str, name: str) -> Callable[[Message], Message]:
    """The job of the process: a file's bytes are answered by its vertices (k, 3) and faces (m, 3)."""

    def answer(request: Message) -> Message:
        mesh = triangles_of(request.arrays[0].tobytes(), kind, name)
        return Message(None, (mesh.vertices, mesh.faces))

    return answer


def triangles_of(content: bytes, kind: str, name: str) -> Triangles:
    """What `read_mesh` gives, from a file's bytes, by this process itself."""
    load = _load_3mf if kind == "3mf" else _load_plain
    vertices, faces = load(content, kind, name)
    _look_through(vertices, faces, name)
    return Triangles(vertices, faces)


def _load_plain(content: bytes, kind: str, name: str) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    import trimesh

    loaded: Any = trimesh.load(io.BytesIO(content), file_type=kind, force="mesh", process=False)
    faces = np.asarray(getattr(loaded, "faces", ()), np.int64).reshape(-1, 3)
    if not len(faces):
        raise KernelError(f"{name} holds no triangles: export the mesh again")
    return np.asarray(loaded.vertices, np.float64), faces


def _load_3mf(content: bytes, kind: str, name: str) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    from perfqr_cad.geometry.threemf_file import placed_triangles

    del kind
    return placed_triangles(content, name, MAX_TRIANGLES)


def require_size(vertices: NDArray[np.float64], name: str) -> None:
    """`KernelError` for coordinates that are no finite numbers, or beyond `MAX_COORDINATE`."""
    if not np.isfinite(vertices).all():
        raise KernelError(f"{name} has coordinates that are no finite numbers: export it again")
    largest = float(np.abs(vertices).max(initial=0))
    if largest > MAX_COORDINATE:
        raise KernelError(
            f"{name} has a coordinate of {largest:g} mm, the limit is {MAX_COORDINATE:g}: check its unit"
        )


def _look_through(vertices: NDArray[np.float64], faces: NDArray[np.int64], name: str) -> None:
    """KernelError for triangles that are none: too many, of no finite numbers, of no area."""
    if not 0 < len(faces) <= MAX_TRIANGLES:
        raise KernelError(
            f"{name} holds {len(faces):,} triangles, the limits are 1 and {MAX_TRIANGLES:,}: reduce the mesh"
        )
    if not 0 <= faces.min() <= faces.max() < len(vertices):
        raise KernelError(
            f"{name} has a triangle of corners {faces.min()} to {faces.max()}, there are {len(vertices)}: "
            "export the mesh again"
        )
    require_size(vertices, name)
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    if not np.cross(b - a, c - a).any():
        raise KernelError(
            f"{name} has {len(faces):,} triangles, none with an area: export a body, not points or lines"
        )
