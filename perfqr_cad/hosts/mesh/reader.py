"""Reading triangle meshes: STL, OBJ, PLY, OFF through trimesh, 3MF by its own XML."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.errors import KernelError
from perfqr_cad.geometry import Triangles
from perfqr_cad.geometry.arrays import Array

FORMATS = ("stl", "obj", "ply", "off", "3mf")
# 3MF core specification 1.3, §3.4: the units a model may be in.
MM_PER_UNIT = {
    "micron": 1e-3,
    "millimeter": 1.0,
    "centimeter": 10.0,
    "inch": 25.4,
    "foot": 304.8,
    "meter": 1000.0,
}
MOST_XML_BYTES = 1 << 30  # of an unpacked model part: more is no part but an attack


def read_mesh(path: str | Path, scale: float = 1.0) -> Triangles:
    """The triangles of a file as they are, not welded or checked, times `scale`.

    3MF declares its unit and is converted to mm; the others have none and are taken as mm.
    Raises `KernelError`
    for a file that is missing, unreadable, of another kind or without triangles.
    """
    path = Path(path)
    kind = path.suffix.lower().lstrip(".")
    if kind not in FORMATS:
        raise KernelError(f"{path.name} is no mesh this program reads: give one of {', '.join(FORMATS)}")
    if not path.is_file():
        raise KernelError(f"{path}: no such file")
    vertices, faces = _read_3mf(path) if kind == "3mf" else _read_plain(path, kind)
    if not len(faces):
        raise KernelError(f"{path.name} holds no triangles: export the mesh again")
    if not np.isfinite(vertices).all():
        raise KernelError(f"{path.name} has coordinates that are not numbers: export the mesh again")
    return Triangles(vertices * scale, faces)


def _read_plain(path: Path, kind: str) -> tuple[Array, NDArray[np.int64]]:
    import trimesh

    try:
        loaded: Any = trimesh.load(path, file_type=kind, force="mesh", process=False)
    except (ValueError, IndexError, KeyError, TypeError, AttributeError, EOFError, OSError) as error:
        reason = " ".join(str(error).split())[:80]
        raise KernelError(
            f"{path.name} cannot be read as {kind.upper()} ({reason}): export the mesh again"
        ) from error
    faces = np.asarray(getattr(loaded, "faces", np.empty((0, 3))), np.int64)
    return np.asarray(loaded.vertices, np.float64), faces


def _read_3mf(path: Path) -> tuple[Array, NDArray[np.int64]]:
    """All build items of a 3MF package, placed, in mm."""
    try:
        with zipfile.ZipFile(path) as package:
            model = next(
                (i for i in package.infolist() if i.filename.lower().endswith("3dmodel.model")), None
            )
            if model is None or model.file_size > MOST_XML_BYTES:
                raise KernelError(f"{path.name} holds no 3-D model part: export it again")
            root = ElementTree.fromstring(package.read(model))
    except (zipfile.BadZipFile, ElementTree.ParseError, EOFError) as error:
        raise KernelError(f"{path.name} is no readable 3MF package ({error}): export it again") from error
    unit = root.get("unit", "millimeter")
    objects = {o.get("id", ""): o for o in root.iterfind("{*}resources/{*}object")}
    placed = [
        piece
        for item in root.iterfind("{*}build/{*}item")
        for piece in _objects(objects, item.get("objectid", ""), _matrix(item.get("transform")), 0)
    ]
    if not placed:
        raise KernelError(f"{path.name} places no object in its build: export it again")
    offsets = np.cumsum([0, *(len(v) for v, _ in placed[:-1])])
    vertices = np.vstack([v for v, _ in placed]) * MM_PER_UNIT.get(unit, 1.0)
    return vertices, np.vstack([f + o for (_, f), o in zip(placed, offsets, strict=True)])


def _objects(
    objects: dict[str, ElementTree.Element], key: str, place: Array, depth: int
) -> list[tuple[Array, NDArray[np.int64]]]:
    """The meshes of an object and of its components, moved by a (4, 3) matrix (3MF's row convention)."""
    if key not in objects or depth > len(objects):
        raise KernelError(f"3MF object {key!r} is missing or contains itself: export the file again")
    found: list[tuple[Array, NDArray[np.int64]]] = []
    mesh = objects[key].find("{*}mesh")
    if mesh is not None:
        vertices = [[float(v.get(a, "nan")) for a in "xyz"] for v in mesh.iterfind("{*}vertices/{*}vertex")]
        faces = [
            [int(t.get(a, "0")) for a in ("v1", "v2", "v3")]
            for t in mesh.iterfind("{*}triangles/{*}triangle")
        ]
        points = np.array(vertices, float).reshape(-1, 3)
        corners = np.array(faces, np.int64).reshape(-1, 3)
        if len(corners) and not 0 <= corners.min() <= corners.max() < len(points):
            raise KernelError("a 3MF triangle names a vertex that is not there: export the file again")
        turned = corners[:, ::-1] if np.linalg.det(place[:3]) < 0 else corners
        found.append((points @ place[:3] + place[3], turned))
    for part in objects[key].iterfind("{*}components/{*}component"):
        inner = _matrix(part.get("transform"))
        both = np.vstack([inner[:3] @ place[:3], inner[3] @ place[:3] + place[3]])
        found += _objects(objects, part.get("objectid", ""), both, depth + 1)
    return found


def _matrix(text: str | None) -> Array:
    """A 3MF transform: twelve numbers, (4, 3) by rows, applied from the right."""
    if text is None:
        return np.vstack([np.eye(3), np.zeros(3)])
    values = [float(x) for x in text.split()]
    if len(values) != 12:
        raise KernelError(f"a 3MF transform has {len(values)} numbers instead of 12: export the file again")
    return np.array(values).reshape(4, 3)
