"""Binary glTF 2.0 for viewers: metres, +z towards the reader, one coloured mesh per body."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from perfqr_cad.export.design_view import DesignView
from perfqr_cad.units import linear_from_srgb

if TYPE_CHECKING:
    from perfqr_cad.solid import Solid

METRES_PER_MM = 1e-3
MAGIC, VERSION, JSON_CHUNK, BINARY_CHUNK = 0x46546C67, 2, 0x4E4F534A, 0x004E4942  # glTF 2.0 §4.4
FLOAT, UNSIGNED_INT = 5126, 5125  # component types
ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER = 34962, 34963
ROUGHNESS = 0.8  # a printed surface


def write(design: DesignView, path: Path) -> None:
    """Write the part and what belongs to it; faces are flat-shaded, as a mesh without normals is."""
    bodies = [design.solid, *design.solid.extras]
    chunks = [chunk for body in bodies for chunk in _buffers(body)]
    binary = b"".join(chunks)
    text = json.dumps(_document(bodies, chunks), separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    length = 12 + 8 + len(text) + 8 + len(binary)
    path.write_bytes(
        struct.pack("<III", MAGIC, VERSION, length)
        + struct.pack("<II", len(text), JSON_CHUNK)
        + text
        + struct.pack("<II", len(binary), BINARY_CHUNK)
        + binary
    )


def _buffers(body: Solid) -> tuple[bytes, bytes]:
    vertices = (body.triangles.vertices * METRES_PER_MM).astype("<f4")
    return vertices.tobytes(), body.triangles.faces.astype("<u4").tobytes()


def _document(bodies: list[Solid], chunks: list[bytes]) -> dict[str, Any]:
    starts = np.cumsum([0, *map(len, chunks)]).tolist()
    targets = [ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER] * len(bodies)
    return {
        "asset": {"version": "2.0", "generator": "perfqr-cad"},
        "scene": 0,
        "scenes": [{"nodes": list(range(len(bodies)))}],
        "nodes": [{"name": body.name, "mesh": i} for i, body in enumerate(bodies)],
        "meshes": [
            {
                "name": body.name,
                "primitives": [{"attributes": {"POSITION": 2 * i}, "indices": 2 * i + 1, "material": i}],
            }
            for i, body in enumerate(bodies)
        ],
        "materials": [_material(body) for body in bodies],
        "accessors": [accessor for i, body in enumerate(bodies) for accessor in _accessors(2 * i, body)],
        "bufferViews": [
            {"buffer": 0, "byteOffset": start, "byteLength": len(chunk), "target": target}
            for start, chunk, target in zip(starts, chunks, targets, strict=False)
        ],
        "buffers": [{"byteLength": starts[-1]}],
    }


def _accessors(view: int, body: Solid) -> tuple[dict[str, Any], dict[str, Any]]:
    vertices = (body.triangles.vertices * METRES_PER_MM).astype("<f4")
    faces = body.triangles.faces
    return (
        {
            "bufferView": view,
            "componentType": FLOAT,
            "type": "VEC3",
            "count": len(vertices),
            "min": vertices.min(axis=0).tolist(),
            "max": vertices.max(axis=0).tolist(),
        },
        {"bufferView": view + 1, "componentType": UNSIGNED_INT, "type": "SCALAR", "count": int(faces.size)},
    )


def _material(body: Solid) -> dict[str, Any]:
    return {
        "name": body.name,
        "pbrMetallicRoughness": {
            "baseColorFactor": [*linear_from_srgb(body.colour).tolist(), 1.0],
            "metallicFactor": 0.0,
            "roughnessFactor": ROUGHNESS,
        },
    }
