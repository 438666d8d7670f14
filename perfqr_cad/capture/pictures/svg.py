"""SVG drawings as PNG, by resvg: looked through before it draws them, for what it has no limits for.

A drawing may not refer to anything outside itself but by a `data:` address, nor define entities of entities
or of files; its elements are counted, and how deep they nest. What is left (filters, patterns and copies
without end) meets the limits of the process in which it is drawn.
"""

from __future__ import annotations

import gzip
import io
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any
from xml.parsers import expat

import numpy as np

from perfqr_cad.bounded import MIB
from perfqr_cad.errors import CaptureError
from perfqr_cad.isolated import Message, without_files

SIDE_PX = 1600  # longest side of a rasterised drawing: 9 px a module at version 40
MAX_BYTES = 16 * MIB
MAX_UNITS = 100_000.0  # longer drawings cost the renderer memory before they are scaled
MAX_ELEMENTS = 500_000  # version 40 in halftone has 280,000 squares
MAX_DEPTH = 200  # the renderer walks a drawing by recursion
MAX_ENTITY = 1000  # letters: some programs define their namespaces so
LINK = "a"  # the element whose address is for a reader to follow, not for a renderer


def is_svg(content: bytes) -> bool:
    """Whether bytes are to be read as a drawing, packed by gzip or not."""
    head = content[:2] == b"\x1f\x8b" or b"<svg" in content[:4096].lower()
    return head and not content.startswith((b"\x89PNG", b"\xff\xd8"))


def drawer() -> Callable[[Message], Message]:
    """The job of the process: `{"name": ...}` and a file's bytes are answered by the bytes of a PNG."""
    import resvg_py

    def answer(request: Message) -> Message:
        name = request.value["name"]
        text, (width, height) = looked_through(request.arrays[0].tobytes(), name)
        scale = SIDE_PX / max(width, height)
        try:
            with without_files():
                png = resvg_py.svg_to_bytes(
                    svg_string=text,
                    width=max(1, round(width * scale)),
                    height=max(1, round(height * scale)),
                    skip_system_fonts=True,
                )
        except ValueError as error:
            reason = " ".join(str(error).split())[:120]
            raise CaptureError(f"{name} is no SVG that can be drawn ({reason}): save it again") from error
        return Message(None, (np.frombuffer(png, np.uint8),))

    return answer


def looked_through(content: bytes, name: str) -> tuple[str, tuple[float, float]]:
    """A drawing's text and its size in its own units. CaptureError for what no renderer may meet."""
    text = _text(content, name)
    drawing = _Drawing(name)
    parser = expat.ParserCreate("utf-8")
    parser.StartElementHandler = drawing.begin
    parser.EndElementHandler = drawing.end
    parser.EntityDeclHandler = drawing.entity
    try:
        parser.Parse(text.encode(), True)
    except (expat.ExpatError, UnicodeEncodeError) as error:
        raise CaptureError(f"{name} is a damaged SVG ({error}): save it again") from error
    return text, drawing.size


def _text(content: bytes, name: str) -> str:
    try:
        if content[:2] == b"\x1f\x8b":
            with gzip.GzipFile(fileobj=io.BytesIO(content)) as packed:
                content = packed.read(MAX_BYTES + 1)
        if len(content) > MAX_BYTES:
            raise CaptureError(f"{name} has over {MAX_BYTES} bytes of SVG, the limit: simplify it")
        return content.decode("utf-8-sig")
    except (OSError, EOFError, zlib.error, UnicodeDecodeError) as error:
        raise CaptureError(f"{name} is a damaged SVG ({error}): save it again") from error


@dataclass
class _Drawing:
    """Counts what an XML parser meets."""

    name: str
    size: tuple[float, float] = (0.0, 0.0)
    elements: int = 0
    depth: int = 0

    def begin(self, element: str, attributes: dict[str, str]) -> None:
        """An element begins."""
        if not self.elements:
            self.size = self._size(attributes)
        self.elements += 1
        self.depth += 1
        if self.elements > MAX_ELEMENTS:
            raise CaptureError(
                f"{self.name} has over {MAX_ELEMENTS} elements, the limit: simplify the drawing"
            )
        if self.depth > MAX_DEPTH:
            raise CaptureError(
                f"{self.name} nests elements over {MAX_DEPTH} deep, the limit: take its groups apart"
            )
        if element.rpartition(":")[2] != LINK:
            for key, value in attributes.items():
                if key.rpartition(":")[2] == "href":
                    self._require_inside(value.strip())

    def end(self, element: str) -> None:
        """An element ends."""
        del element
        self.depth -= 1

    def entity(self, name: str, is_parameter: bool, value: str | None, *elsewhere: Any) -> None:
        """An entity is declared; without a value it stands elsewhere."""
        del elsewhere
        if is_parameter or value is None or "&" in value or len(value) > MAX_ENTITY:
            raise CaptureError(
                f"{self.name} defines the entity {name[:40]!r} by other entities, by a file or by over "
                f"{MAX_ENTITY} letters: save it as plain SVG"
            )

    def _require_inside(self, address: str) -> None:
        if address and not address.startswith(("#", "data:")):
            raise CaptureError(
                f"{self.name} refers to {address[:60]!r}, which is not read: embed the picture in the drawing"
            )

    def _size(self, root: dict[str, str]) -> tuple[float, float]:
        """Width and height in the drawing's own units, from the view box or the two attributes."""
        sizes = root.get("viewBox", "").replace(",", " ").split()[2:4] or [
            root.get("width", ""),
            root.get("height", ""),
        ]
        try:
            width, height = (float(size.rstrip("%ptxmcinPTXMCIN")) for size in sizes)
        except ValueError:
            width = height = 0.0
        if not (0 < width <= MAX_UNITS and 0 < height <= MAX_UNITS):
            raise CaptureError(
                f"{self.name} has no size between 0 and {MAX_UNITS:g} units: give the SVG a viewBox or "
                "width and height"
            )
        return width, height
