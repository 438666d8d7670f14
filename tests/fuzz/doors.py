"""Fuzz targets, one for each kind of file that a stranger may hand in: `python tests/fuzz/doors.py DOOR`.

Needs atheris (`pip install -e '.[fuzz]'`); options of libFuzzer follow the door's name, such as -runs=100000.
A finding is an exception that is none of ours, a value that should have been refused, or no end. What native
parsers do with a file is not looked at here: they run in processes of their own.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable
from itertools import accumulate
from pathlib import Path

import atheris
import numpy as np

with atheris.instrument_imports(include=["perfqr_cad"]):
    from perfqr_cad import catalog
    from perfqr_cad.bounded import read_json
    from perfqr_cad.capture.pictures import svg
    from perfqr_cad.errors import PerfQRError
    from perfqr_cad.geometry.mesh_files import MAX_COORDINATE, triangles_of
    from perfqr_cad.solid.step import envelope

sys.path.insert(0, str(Path(__file__).parents[2]))
from tests.stability import hostile

SCRATCH = Path(tempfile.mkdtemp(prefix="perfqr-fuzz-"))
SECONDS = 20  # that one input may take


def drawing(data: bytes) -> None:
    """What is let through names nothing outside itself."""
    text, size = svg.looked_through(data, "a.svg")
    assert min(size) > 0
    assert "<!ENTITY" not in text or "SYSTEM" not in text.split("<!ENTITY")[1].split(">")[0]


def mesh(data: bytes) -> None:
    """STL, OBJ, PLY and OFF, by the first byte. trimesh raises what it likes, within its process."""
    kind = ("stl", "obj", "ply", "off")[data[0] % 4] if data else "stl"
    try:
        found = triangles_of(data[1:], kind, f"a.{kind}")
    except PerfQRError:
        return
    except Exception:  # noqa: BLE001
        return
    assert np.abs(found.vertices).max() <= MAX_COORDINATE
    assert 0 <= found.faces.min() <= found.faces.max() < len(found.vertices)


def package(data: bytes) -> None:
    """3MF: the model part, or by an odd first byte the package."""
    content = data[1:] if data[:1] and data[0] % 2 else hostile.package(data[1:])
    triangles_of(content, "3mf", "a.3mf")


def step(data: bytes) -> None:
    """What is let through nests no deeper than is allowed."""
    envelope.require_readable(data, "a.step")
    if b"'" not in data:
        steps = [1 if sign == ord("(") else -1 for sign in data if sign in b"()"]
        assert max(accumulate(steps), default=0) <= envelope.MAX_DEPTH


def parameters(data: bytes) -> None:
    """Parameter sets."""
    path = SCRATCH / "a.json"
    path.write_bytes(data)
    read_json(path, 10**6, PerfQRError, "a file")
    catalog.read_parameter_set(path, "a")


def template(data: bytes) -> None:
    """Templates are read without running them."""
    path = SCRATCH / "a.py"
    path.write_bytes(data)
    catalog.load(path)


# A door, and files to begin with; those of meshes and packages are led by the byte that tells their kind.
DOORS: dict[str, tuple[Callable[[bytes], None], list[bytes]]] = {
    "svg": (drawing, [content for content in hostile.DRAWINGS.values() if len(content) < 5000]),
    "mesh": (
        mesh,
        [
            bytes([("stl", "obj", "ply", "off").index(name[-3:])]) + content
            for name, content in hostile.MESHES.items()
        ],
    ),
    "3mf": (package, [b"\0" + hostile.model(hostile.ONE).encode(), b"\1" + hostile.package("")]),
    "step": (step, [content for content in hostile.STEPS.values() if len(content) < 5000]),
    "json": (parameters, [*hostile.SETS.values(), b'{"parameterSets": {"a": {"size": 3}}}']),
    "template": (template, [b"size = 5  # [1:10]\ndef build(p):\n    return None\n"]),
}


def main(door: str, options: list[str]) -> None:
    """Fuzz one door until something is found, or as the options say."""
    target, seeds = DOORS[door]
    corpus = SCRATCH / door
    corpus.mkdir()
    for number, seed in enumerate(seeds):
        (corpus / str(number)).write_bytes(seed)

    def once(data: bytes) -> None:
        try:
            target(data)
        except PerfQRError as error:
            if "\n" in str(error):
                raise AssertionError(f"lines: {error}") from error

    atheris.Setup([sys.argv[0], str(corpus), f"-timeout={SECONDS}", *options], once)
    atheris.Fuzz()


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
