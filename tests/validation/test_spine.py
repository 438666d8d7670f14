"""The main job end to end, judged by others: gmsh opens the STEP, trimesh the STL, decoders read a cut of it.

The pictures that the decoders see here are drawn by shapely and Pillow from the written STL, without the
package's own camera.
"""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import pytest
import trimesh
import zxingcpp
from PIL import Image, ImageDraw
from pyzbar import pyzbar

from perfqr_cad.cli import main

PX_PER_MM = 10
QUIET = 4  # modules
TEXT = "https://example.com/p/1234567"


@dataclass(frozen=True)
class Made:
    folder: Path
    certificate: dict


@pytest.fixture(scope="session", params=["text", "picture"])
def made(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Made:
    folder = tmp_path_factory.mktemp(request.param)
    out = folder / "out"
    if request.param == "text":
        source = [TEXT, "--size", "60"]
    else:
        example = Path(__file__).parents[2] / "examples" / "picture_code.py"
        picture = folder / "flower.png"
        old, sys.argv = sys.argv, [str(example), str(picture)]
        try:
            exec(compile(example.read_text(), example, "exec"), {"__name__": "__main__"})
        finally:
            sys.argv = old
        source = ["--image", str(picture)]
    with pytest.raises(SystemExit) as stop:
        main(["make", *source, "-o", f"{out}/"])
    assert stop.value.code == 0
    return Made(out, json.loads((out / "design.json").read_text()))


def seen_from_above(path: Path) -> np.ndarray:
    """The mesh cut at half its height: material white, holes black."""
    mesh = trimesh.load(path)
    low, high = mesh.bounds
    section = mesh.section(plane_origin=(low + high) / 2, plane_normal=(0, 0, 1))
    loops = [np.asarray(loop)[:, :2] for loop in section.discrete]
    size = np.ceil((high - low)[:2] * PX_PER_MM).astype(int)
    inside = np.zeros(size[::-1], bool)
    for loop in loops:  # even-odd
        layer = Image.new("1", tuple(size.tolist()))
        points = (loop - low[:2]) * PX_PER_MM
        ImageDraw.Draw(layer).polygon([(x, size[1] - y) for x, y in points], fill=1)
        inside ^= np.array(layer)
    return np.where(inside, 255, 0).astype(np.uint8)


def test_every_file_is_there_and_listed(made: Made) -> None:
    listed = {f["path"]: f["bytes"] for f in made.certificate["files"]}
    assert {"part.step", "part.stl", "part.png", "part.svg"} <= set(listed)
    for name, size in listed.items():
        assert (made.folder / name).stat().st_size == size


def test_the_mesh_is_watertight_and_one_body(made: Made) -> None:
    mesh = trimesh.load(made.folder / "part.stl")
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.body_count == 1
    assert made.certificate["connectivity"]["components"] == 1
    assert mesh.volume == pytest.approx(made.certificate["solid"]["volume_mm3"], rel=1e-3)


def test_decoders_read_the_exact_payload(made: Made) -> None:
    gray = seen_from_above(made.folder / "part.stl")
    payload = made.certificate["payload"]
    assert [code.text for code in zxingcpp.read_barcodes(gray)] == [payload]
    assert [code.data.decode() for code in pyzbar.decode(gray)] == [payload]
    texts, _ = cv2.wechat_qrcode_WeChatQRCode().detectAndDecode(gray)
    assert list(texts) == [payload]


def finder_corners(gray: np.ndarray, modules: int) -> list[bool]:
    """Whether a finder stands top left, top right, bottom left, bottom right: 49 modules, but for a bar."""
    pitch = gray.shape[1] / (modules + 2 * QUIET)
    away = np.maximum(*np.abs(np.mgrid[-3:4, -3:4]))
    finder = away != 2  # dark core, light ring, dark ring (ISO/IEC 18004 §6.3.3)
    found = []
    for row, column in ((0, 0), (0, modules - 7), (modules - 7, 0), (modules - 7, modules - 7)):
        y = ((QUIET + row + 0.5 + np.arange(7)) * pitch).astype(int)
        x = ((QUIET + column + 0.5 + np.arange(7)) * pitch).astype(int)
        found.append(bool(np.sum((gray[np.ix_(y, x)] == 0) != finder) <= 4))
    return found


def test_the_part_is_not_mirrored(made: Made) -> None:
    gray = seen_from_above(made.folder / "part.stl")
    modules = made.certificate["symbol"]["modules"]
    assert finder_corners(gray, modules) == [True, True, True, False]
    assert finder_corners(np.fliplr(gray), modules) == [True, True, False, True]


@pytest.mark.parametrize("made", ["text"], indirect=True)  # OCC reads the picture's 12,000 faces in minutes
def test_gmsh_opens_the_step_as_one_volume(made: Made) -> None:
    import gmsh

    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        entities = gmsh.model.occ.importShapes(str(made.folder / "part.step"))
        gmsh.model.occ.synchronize()
        volumes = [tag for dimension, tag in entities if dimension == 3]
        assert len(volumes) == 1
        volume = gmsh.model.occ.getMass(3, volumes[0])
    finally:
        gmsh.finalize()
    assert volume == pytest.approx(made.certificate["solid"]["volume_mm3"], rel=1e-6)


def test_the_certificate_says_who_read_it(made: Made) -> None:
    read = {name for name, found in made.certificate["scan"]["decoders"].items() if found["frontal"]}
    assert {"zxing-cpp", "zbar", "wechat"} <= read


def test_the_certificate_has_every_key(made: Made) -> None:
    sections = (
        "payload",
        "symbol",
        "readability",
        "connectivity",
        "structure",
        "solid",
        "scan",
        "files",
        "timings_s",
    )
    assert set(sections) <= set(made.certificate)
    assert made.certificate["structure"]["max_stress_mpa"] > 0
    assert made.certificate["structure"]["max_deflection_mm"] > 0
