"""The triangles of a 3MF package: all items of its build, placed, in mm.

The model part is parsed as it is unpacked, so that nothing but numbers is kept of it. A package may name one
object many times over; how many triangles that makes is known before they are made.
"""

from __future__ import annotations

import io
import zipfile
from array import array
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any
from xml.parsers import expat

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.bounded import MIB
from perfqr_cad.errors import KernelError

Array = NDArray[np.float64]
Mesh = tuple[Array, NDArray[np.int64]]

# 3MF core specification 1.3, §3.4: the units a model may be in.
MM_PER_UNIT = {
    "micron": 1e-3,
    "millimeter": 1.0,
    "centimeter": 10.0,
    "inch": 25.4,
    "foot": 304.8,
    "meter": 1000.0,
}
MAX_ENTRIES = 10_000  # files in the package
MAX_XML_BYTES = 384 * MIB  # of the unpacked model part: 4 million triangles
CHUNK_BYTES = MIB
MAX_XML_DEPTH = 64
MAX_NESTING = 32  # objects in objects
MAX_COPIES = 100_000  # of objects, placed
AGAIN = "export it again"


def placed_triangles(content: bytes, name: str, most: int) -> Mesh:
    """Vertices (k, 3) mm and faces (m, 3) of a package with at most that many triangles. KernelError says
    what is wrong with one."""
    model = _Model(name)
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as package:
            _parse(package, model)
    except (zipfile.BadZipFile, expat.ExpatError, EOFError, OSError) as error:
        raise KernelError(f"{name} is no readable 3MF package ({error}): {AGAIN}") from error
    pieces = list(_placed(model, most))
    if not pieces:
        raise KernelError(f"{name} places no object in its build: {AGAIN}")
    offsets = np.cumsum([0, *(len(v) for v, _ in pieces[:-1])])
    vertices = np.vstack([v for v, _ in pieces]) * model.mm_per_unit
    return vertices, np.vstack([f + o for (_, f), o in zip(pieces, offsets, strict=True)])


@dataclass
class _Object:
    """An object of the model: its own mesh, and others in it by their ids and places."""

    vertices: array[float] = field(default_factory=lambda: array("d"))
    corners: array[int] = field(default_factory=lambda: array("q"))
    components: list[tuple[str, Array]] = field(default_factory=list[tuple[str, Array]])


class _Model:
    """Takes in the elements of a model part as an XML parser meets them."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.mm_per_unit = 1.0
        self.objects: dict[str, _Object] = {}
        self.items: list[tuple[str, Array]] = []
        self._path: list[str] = []
        self._object = _Object()

    def parser(self) -> Any:
        """An XML parser that fills this model."""
        parser = expat.ParserCreate(namespace_separator=" ")
        parser.StartElementHandler = self._begin
        parser.EndElementHandler = self._end
        parser.StartDoctypeDeclHandler = self._doctype
        return parser

    def _begin(self, tag: str, attributes: dict[str, str]) -> None:
        element = tag.rpartition(" ")[2]
        self._path.append(element)
        if len(self._path) > MAX_XML_DEPTH:
            raise KernelError(f"{self.name} nests over {MAX_XML_DEPTH} elements, the limit: {AGAIN}")
        match element:
            case "vertex":
                self._object.vertices.extend([self._number(attributes, axis) for axis in "xyz"])
            case "triangle":
                self._object.corners.extend(
                    [self._index(attributes, corner) for corner in ("v1", "v2", "v3")]
                )
            case "component":
                self._object.components.append(self._reference(attributes))
            case "object":
                self._object = self.objects[attributes.get("id", "")] = _Object()
            case "item":
                self.items.append(self._reference(attributes))
            case "model":
                self.mm_per_unit = self._unit(attributes)
            case _:
                pass

    def _end(self, tag: str) -> None:
        del tag
        self._path.pop()

    def _doctype(self, *declared: Any) -> None:
        del declared
        raise KernelError(f"{self.name} declares a document type, which 3MF does not allow: {AGAIN}")

    def _number(self, attributes: dict[str, str], key: str) -> float:
        try:
            return float(attributes.get(key, ""))
        except ValueError:
            raise self._none(attributes, key, "a number") from None

    def _index(self, attributes: dict[str, str], key: str) -> int:
        text = attributes.get(key, "")
        if not (text.isascii() and text.isdecimal() and len(text) < 10):
            raise self._none(attributes, key, "a vertex")
        return int(text)

    def _none(self, attributes: dict[str, str], key: str, wanted: str) -> KernelError:
        said = attributes.get(key, "")[:40]
        return KernelError(f"{self.name} has {key}={said!r} where {wanted} is due: {AGAIN}")

    def _reference(self, attributes: dict[str, str]) -> tuple[str, Array]:
        return attributes.get("objectid", ""), self._matrix(attributes.get("transform"))

    def _matrix(self, text: str | None) -> Array:
        """A transform: twelve numbers, (4, 3) by rows, applied from the right (§3.3)."""
        if text is None:
            return np.vstack([np.eye(3), np.zeros(3)])
        try:
            matrix = np.array([float(x) for x in text.split()]).reshape(4, 3)
        except ValueError:
            raise KernelError(f"{self.name} has a transform that is not 12 numbers: {AGAIN}") from None
        if not np.isfinite(matrix).all():
            raise KernelError(f"{self.name} has a transform of numbers that are not finite: {AGAIN}")
        return matrix

    def _unit(self, attributes: dict[str, str]) -> float:
        unit = attributes.get("unit", "millimeter")
        if unit not in MM_PER_UNIT:
            known = ", ".join(MM_PER_UNIT)
            raise KernelError(f"{self.name} is in the unit {unit[:40]!r}: export it in one of {known}")
        return MM_PER_UNIT[unit]


def _parse(package: zipfile.ZipFile, model: _Model) -> None:
    """Unpack the model part into a model, piece by piece."""
    entries = package.infolist()
    part = next((entry for entry in entries if entry.filename.lower().endswith("3dmodel.model")), None)
    if part is None or len(entries) > MAX_ENTRIES:
        raise KernelError(f"{model.name} has no 3-D model among {len(entries)} entries: {AGAIN}")
    if part.flag_bits & 1:
        raise KernelError(f"{model.name} is encrypted: export it without a password")
    if part.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise KernelError(
            f"{model.name} is packed by method {part.compress_type}: export it with deflate (8)"
        )
    if part.file_size > MAX_XML_BYTES:
        raise KernelError(
            f"{model.name} unpacks to {part.file_size:,} bytes, the limit is {MAX_XML_BYTES:,}: reduce it"
        )
    parser = model.parser()
    with package.open(part) as unpacked:
        while chunk := unpacked.read(CHUNK_BYTES):
            parser.Parse(chunk, False)
    parser.Parse(b"", True)


def _placed(model: _Model, most: int) -> Iterator[Mesh]:
    """The meshes of all items with their components, moved."""
    counts: dict[str, tuple[int, int]] = {}
    totals = [_count(model, key, counts, 0) for key, _ in model.items]
    triangles, copies = sum(t for t, _ in totals), sum(c for _, c in totals)
    if triangles > most or copies > MAX_COPIES:
        raise KernelError(
            f"{model.name} places {triangles:,} triangles in {copies:,} objects, the limits are {most:,} and "
            f"{MAX_COPIES:,}: reduce it"
        )
    for key, place in model.items:
        yield from _moved(model, key, place)


def _count(model: _Model, key: str, known: dict[str, tuple[int, int]], depth: int) -> tuple[int, int]:
    """Triangles and objects that an object makes with all that is in it."""
    if key not in model.objects or depth > MAX_NESTING:
        raise KernelError(
            f"object {key[:40]!r} of {model.name} is missing, contains itself or nests over {MAX_NESTING} "
            f"deep: {AGAIN}"
        )
    if key not in known:
        this = model.objects[key]
        inner = [_count(model, part, known, depth + 1) for part, _ in this.components]
        triangles = len(this.corners) // 3 + sum(t for t, _ in inner)
        known[key] = triangles, 1 + sum(c for _, c in inner)
    return known[key]


def _moved(model: _Model, key: str, place: Array) -> Iterator[Mesh]:
    """The mesh of an object and of its components, moved by a (4, 3) matrix."""
    this = model.objects[key]
    points = np.array(this.vertices, float).reshape(-1, 3)
    corners = np.array(this.corners, np.int64).reshape(-1, 3)
    if len(corners):
        if corners.max() >= len(points):
            raise KernelError(
                f"{model.name} has a triangle with vertex {corners.max()} of {len(points)}: {AGAIN}"
            )
        turned = corners[:, ::-1] if np.linalg.det(place[:3]) < 0 else corners
        yield points @ place[:3] + place[3], turned
    for part, inner in this.components:
        both = np.vstack([inner[:3] @ place[:3], inner[3] @ place[:3] + place[3]])
        yield from _moved(model, part, both)
