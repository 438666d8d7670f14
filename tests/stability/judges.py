"""Judges from outside: trimesh and zxing-cpp of what was made, plain rules of what was refused."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any, NoReturn

import cv2
import numpy as np
import resvg_py
import trimesh
import zxingcpp
from numpy.typing import NDArray
from PIL import Image

from perfqr_cad.errors import PerfQRError
from perfqr_cad.pipeline.kinds import Kind

from .drawn import BY_FIELD, Asked

FILES = ("part.stl", "part.svg", "design.json")
EXIT_CODES = (2, 3)  # bad input; asked for by name and not held
FLAT_TOL, CURVED_TOL = 2e-3, 1e-2  # share of the volume that chords of a mesh may differ by
AREA_TOL = 2e-2  # a row of pixels at the edge
PICTURE_PX, DPI = 900, 96
SKIN_MM = 0.01  # behind the front, where it is cut
READER = "zxing-cpp"
TRIED = "which was tried"
_OPTION = re.compile(r"(no )?--([a-z][a-z-]*)(?:[ =]([^\s;:()|]+))?")
_BETWEEN = re.compile(r", | or ")  # remedies of which one is enough
_BY_OPTION = {declared.option: declared for declared in BY_FIELD.values()}


@dataclass(frozen=True)
class Outcome:
    """What came back from a door: exit code, what was said on standard error, and the folder of files."""

    code: int
    said: str
    folder: Path

    @property
    def made(self) -> bool:
        return self.code == 0


def faults(asked: Asked, outcome: Outcome) -> list[str]:
    """Everything that is not as it should be; empty for a sound part and for a proper refusal."""
    return list(_of_part(asked, outcome.folder) if outcome.made else _of_refusal(outcome))


def remedies(message: str) -> list[dict[str, Any]]:
    """Changes of settings that a refusal names, by name in Python; None takes a setting out.

    >>> remedies("weak: use --bars 2 --thickness 3, which was tried")
    [{'bars': 2, 'thickness_mm': 3.0}]
    >>> remedies("too fine: use --caption-height 2 --frame 5, no --caption or a finer nozzle")
    [{'caption_height_mm': 2.0, 'frame_mm': 5.0}, {'caption': None}]
    """
    said, _, _ = message.partition("tried without success")
    before, _, named = said.rpartition(": use ")
    together = [_together(_changes(one)) for one in _BETWEEN.split(named.partition(TRIED)[0])]
    helping = [change for change in together if change]
    return helping if TRIED in said else [*_changes(before), *helping]


def _together(changes: list[dict[str, Any]]) -> dict[str, Any]:
    return {name: value for change in changes for name, value in change.items()}


def _changes(said: str) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = []
    for no, name, value in _OPTION.findall(said):
        declared = _BY_OPTION.get(f"--{name}")
        if declared is None:
            continue
        if no:
            found.append({declared.field: None})
        elif declared.kind is Kind.FLAG:
            found.append({declared.field: True})
        elif value := value.rstrip(",."):
            try:
                found.append({declared.field: declared.read(value)})
            except PerfQRError:  # "--size or a finer nozzle" names no value
                continue
    return found


def _of_refusal(outcome: Outcome) -> Iterator[str]:
    lines = outcome.said.splitlines()
    if outcome.code not in EXIT_CODES:
        yield f"exit code {outcome.code}: {lines[-1] if lines else ''}"
    elif len(lines) != 1 or not lines[0].startswith("error: "):
        yield f"{len(lines)} lines instead of one: {outcome.said[:300]}"
    left = sorted(path.name for path in outcome.folder.rglob("*"))
    if left:
        yield f"a refusal leaves {', '.join(left)}"


def _of_part(asked: Asked, folder: Path) -> Iterator[str]:
    missing = [name for name in FILES if not (folder / name).is_file()]
    if missing:
        yield f"not written: {', '.join(missing)}"
        return
    try:
        certificate = json.loads((folder / "design.json").read_bytes(), parse_constant=_no_constant)
    except ValueError as failure:
        yield f"certificate: {failure}"
        return
    if "text" in asked.settings and certificate["payload"] != asked.settings["text"]:
        yield f"payload {certificate['payload']!r}"
    broken = [promise["name"] for promise in certificate["promises"] if not promise["kept"]]
    if broken or not certificate["promises"]:
        yield f"promises not kept: {', '.join(broken) or 'none is there'}"
    yield from _of_mesh(asked, folder / "part.stl", certificate)
    if asked.template == "plate":
        yield from _of_plate(folder, certificate)
    left = sorted(path.name for path in folder.iterdir() if path.name not in FILES)
    if left:
        yield f"beside the files: {', '.join(left)}"


def _of_mesh(asked: Asked, path: Path, certificate: dict[str, Any]) -> Iterator[str]:
    mesh: Any = trimesh.load_mesh(path)
    solid = certificate["solid"]
    if not mesh.is_watertight or not mesh.is_winding_consistent:
        yield "trimesh: not watertight"
    if mesh.body_count != solid["solids"]:
        yield f"trimesh: {mesh.body_count} bodies, the certificate says {solid['solids']}"
    off = abs(mesh.volume / solid["volume_mm3"] - 1)
    if off > (FLAT_TOL if asked.template == "plate" else CURVED_TOL):
        yield f"trimesh: volume {mesh.volume:.6g} mm³, the certificate says {solid['volume_mm3']:.6g} mm³"


def _of_plate(folder: Path, certificate: dict[str, Any]) -> Iterator[str]:
    """The code as zxing-cpp reads it in the front face and, where no bars are recessed, in the drawing."""
    asks, area_mm2 = certificate["request"], certificate["connectivity"]["area_mm2"]
    front_mm = (
        SKIN_MM if asks["mirror"] else asks["thickness_mm"] - SKIN_MM
    )  # a mirrored part lies on its front
    pictures = {"front face": _cut(folder / "part.stl", front_mm)}
    if asks["svg"] == "filled":
        drawn, pixel_mm2 = _drawing(folder / "part.svg")
        off = abs(drawn.sum() / 255 * pixel_mm2 / area_mm2 - 1)
        if off > AREA_TOL:
            yield f"resvg: the area of the SVG is {100 * off:.3g} % off the certificate's {area_mm2:.6g} mm²"
        if asks["finder"] != "recessed":  # those are drawn as thick as the sheet
            pictures["SVG"] = drawn
    if certificate["scan"]["decoders"].get(READER, {}).get("frontal"):
        for name, material in pictures.items():
            texts = _read(material, inverted=asks["tone"] == "inverted", mirrored=asks["mirror"])
            if certificate["payload"] not in texts:
                yield f"{READER} reads {sorted(texts)} in the {name}, not {certificate['payload']!r}"


def _drawing(path: Path) -> tuple[NDArray[np.uint8], float]:
    """The material of a drawing, 255 where there is some, and the area of a pixel in mm²."""
    svg = path.read_text()
    png = resvg_py.svg_to_bytes(svg_string=svg, width=PICTURE_PX, dpi=DPI)
    with Image.open(BytesIO(bytes(png))) as drawn:
        material = np.array(drawn.convert("RGBA"))[..., 3]
    width, height = (float(edge) for edge in re.findall(r'(?:width|height)="([\d.]+)mm"', svg)[:2])
    return material, width * height / material.size


def _cut(path: Path, height_mm: float) -> NDArray[np.uint8]:
    """The same of a mesh, cut at a height."""
    mesh: Any = trimesh.load_mesh(path)
    cut = mesh.section(plane_origin=(0, 0, height_mm), plane_normal=(0, 0, 1))
    loops = [loop[:, :2] for loop in cut.discrete]
    low, high = np.min(cut.vertices, axis=0)[:2], np.max(cut.vertices, axis=0)[:2]
    scale = PICTURE_PX / float(np.max(high - low))
    picture = np.zeros(np.ceil((high - low) * scale).astype(int)[::-1], np.uint8)
    pixels = [np.rint((loop - low) * scale).astype(np.int32) for loop in loops]
    cv2.fillPoly(picture, pixels, (255,))  # all at once: even-odd
    return np.flipud(picture)


def _read(material: NDArray[np.uint8], *, inverted: bool, mirrored: bool) -> set[str]:
    """What is read where the material is light, or dark."""
    picture = np.pad(255 - material if inverted else material, PICTURE_PX // 10, constant_values=255)
    found = zxingcpp.read_barcodes(np.ascontiguousarray(picture[:, ::-1] if mirrored else picture))
    return {text for code in found for text in (code.text, bytes(code.bytes).decode(errors="replace"))}


def _no_constant(word: str) -> NoReturn:
    raise ValueError(f"{word} is no JSON")
