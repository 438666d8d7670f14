"""A stranger's file, whatever it holds: one line that says what is wrong, within bounds."""

from __future__ import annotations

import os
import resource
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from perfqr_cad import catalog
from perfqr_cad.capture import attempts, load_image, read, recognition
from perfqr_cad.capture.pictures import image
from perfqr_cad.errors import (
    AnalysisError,
    CaptureError,
    DesignError,
    KernelError,
    PerfQRError,
    TemplateError,
)
from perfqr_cad.geometry.mesh_files import read_mesh
from perfqr_cad.hosts.mesh import MeshTarget
from perfqr_cad.hosts.step.meshing import mesh_step
from perfqr_cad.hosts.step.reader import read_part
from perfqr_cad.isolated import Limits
from perfqr_cad.pipeline.chain import scan_part
from tests.stability import hostile

MOST_CPU_S, MOST_KB = 60.0, 2_000_000  # stated for any file that is refused

Door = Callable[[Path], Any]
# What reads a kind of file, the error that it raises, and the files.
DOORS: dict[str, tuple[Door, type[PerfQRError], dict[str, bytes]]] = {
    "picture": (load_image, CaptureError, hostile.PICTURES),
    "drawing": (load_image, CaptureError, hostile.DRAWINGS),
    "mesh": (read_mesh, KernelError, hostile.MESHES | hostile.PACKAGES),
    "solid": (mesh_step, KernelError, hostile.STEPS),
    "set": (lambda path: catalog.read_parameter_set(path, "a"), TemplateError, hostile.SETS),
    "template": (catalog.load, TemplateError, hostile.TEMPLATES),
    "design": (scan_part, DesignError, hostile.DESIGNS),
}
CASES = [(door, name) for door, (_, _, files) in DOORS.items() for name in files]


@pytest.fixture(autouse=True)
def bounds() -> Iterator[None]:
    """No test may take more than is stated for a file."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    yield
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    assert after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime < MOST_CPU_S
    assert after.ru_maxrss < MOST_KB


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    """What never ends is ended soon."""
    monkeypatch.setattr(image, "DECODING", Limits(cpu_s=1.0))
    monkeypatch.setattr(image, "DRAWING", Limits(cpu_s=1.0))


def refused(door: Door, path: Path, error: type[PerfQRError]) -> str:
    """The line with which a door refuses a file."""
    with pytest.raises(error) as caught:
        door(path)
    line = str(caught.value)
    assert type(caught.value) is error
    assert "\n" not in line
    assert ": " in line
    assert len(line) < 500
    return line


@pytest.mark.parametrize(("door", "name"), CASES)
def test_a_hostile_file_is_one_line(tmp_path: Path, door: str, name: str) -> None:
    opened, error, files = DOORS[door]
    (tmp_path / name).write_bytes(files[name])
    assert Path(name).stem in refused(opened, tmp_path / name, error)


SUFFIX = {"picture": "png", "drawing": "svg", "mesh": "stl", "solid": "step", "set": "json",
          "template": "py", "design": "json"}  # fmt: skip


@pytest.mark.parametrize("kind", ["device", "pipe", "folder", "missing", "linked", "circular", "long"])
@pytest.mark.parametrize("door", DOORS)
def test_what_is_no_file_is_not_opened(tmp_path: Path, door: str, kind: str) -> None:
    opened, error, _ = DOORS[door]
    path = tmp_path / f"a.{SUFFIX[door]}"
    match kind:
        case "device":
            path.symlink_to("/dev/zero")
        case "pipe":
            os.mkfifo(path)
        case "folder":
            path.mkdir()
        case "linked":
            os.mkfifo(tmp_path / "pipe")
            path.symlink_to(tmp_path / "pipe")
        case "circular":
            path.symlink_to(path)
        case "long":
            path = tmp_path / f"{'a' * 300}.{SUFFIX[door]}"
        case _:
            pass
    line = refused(opened, path, error)
    says = {"device": "a device", "pipe": "a pipe", "linked": "a pipe", "folder": "a folder"}
    assert says.get(kind, "cannot be read") in line


def test_a_file_beyond_its_size_is_not_read(tmp_path: Path) -> None:
    for door, (opened, error, _) in DOORS.items():
        path = tmp_path / f"{door}.{SUFFIX[door]}"
        with path.open("wb") as file:
            file.truncate(2**40)  # a hole: it takes no room on the disk
        assert "the limit is" in refused(opened, path, error)


@pytest.mark.parametrize("name", [*hostile.STEPS])
def test_a_hostile_solid_gets_no_code(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_bytes(hostile.STEPS[name])
    refused(read_part, tmp_path / name, KernelError)


@pytest.mark.parametrize("count", [100, 3000])
def test_a_soup_of_triangles_gets_no_code(tmp_path: Path, count: int) -> None:
    (tmp_path / "soup.stl").write_bytes(hostile.soup(count))
    assert len(read_mesh(tmp_path / "soup.stl").faces) == count  # it is a mesh, but no body
    refused(lambda path: MeshTarget(path=path).outer, tmp_path / "soup.stl", KernelError)
    with pytest.raises(AnalysisError, match="decoders read nothing"):
        scan_part(tmp_path / "soup.stl")


def test_a_jpeg_of_thousands_of_scans_ends(tmp_path: Path) -> None:
    (tmp_path / "scans.jpg").write_bytes(hostile.many_scans())
    assert "no end after 1 s" in refused(load_image, tmp_path / "scans.jpg", CaptureError)


def test_a_search_in_noise_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(attempts, "SEARCHED_PX", 4e6)
    monkeypatch.setattr(recognition, "SEARCHED_PX", 4e6)  # named in the message
    noise = np.random.default_rng(0).integers(0, 256, (1500, 1500), np.uint8)
    with pytest.raises(CaptureError, match=r"no QR code .* within the 4 megapixels .*: crop the picture"):
        read(noise)


def test_drawings_within_limits_are_drawn(tmp_path: Path) -> None:
    sound = {
        "data": "<image width='9' height='9' href='data:image/png;base64,iVBORw0KGgo='/><rect width='50' "
        "height='50'/>",
        "link": "<a xlink:href='https://example.com'><rect width='50' height='50'/></a>",
        "copy": "<defs><rect id='r' width='50' height='50'/></defs><use xlink:href='#r'/>",
        "deep": "<g>" * 150 + "<rect width='50' height='50'/>" + "</g>" * 150,
    }
    names = '<!DOCTYPE svg [<!ENTITY ns "http://www.w3.org/2000/svg">]>'
    drawings = {name: hostile.svg(body) for name, body in sound.items()}
    drawings["names"] = hostile.svg("<rect width='50' height='50'/>", names)
    for name, content in drawings.items():
        (tmp_path / f"{name}.svg").write_bytes(content)
        picture = load_image(tmp_path / f"{name}.svg")
        assert picture.shape[:2] == (1600, 1600)
        assert (np.asarray(picture[400, 400]) == 0).all(), name
        assert (np.asarray(picture[1200, 1200]) == 255).all(), name


def test_a_package_within_limits_is_read(tmp_path: Path) -> None:
    build = '<item objectid="2" transform="2 0 0 0 1 0 0 0 1 5 0 0"/><item objectid="1"/>'
    parts = hostile.ONE + '<object id="2"><components><component objectid="1"/></components></object>'
    (tmp_path / "two.3mf").write_bytes(hostile.package(hostile.model(parts, build, unit="centimeter")))
    mesh = read_mesh(tmp_path / "two.3mf")
    assert mesh.faces.shape == (8, 3)
    assert mesh.volume_mm3 == pytest.approx((2 + 1) * 60**3 / 6 * 10**3)
