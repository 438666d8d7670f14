from __future__ import annotations

import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from perfqr_cad.export import scad
from perfqr_cad.pattern import Hole, Surround

OPENSCAD = pytest.mark.skipif(not shutil.which("openscad"), reason="openscad is not installed")


def rendered(folder, *arguments):
    command = ["openscad", "-q", "-o", "part.stl", *arguments, "part.scad"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False, cwd=folder)
    assert done.returncode == 0, done.stderr
    assert "WARNING" not in done.stderr
    return trimesh.load_mesh(folder / "part.stl")


def test_parameters_stand_on_top_with_ranges(plate, tmp_path):
    scad.write(plate, tmp_path / "part.scad")
    lines = (tmp_path / "part.scad").read_text().splitlines()
    assert lines[0] == "// test-part: a perforated QR code. Units: mm."
    assert lines[2:8] == [
        "// Width of the part, mm",
        "size = 20; // [20:1:80]",
        "// Thickness of the part, mm",
        "thickness = 2; // [0.2:0.1:20]",
        "// Thickness of a closed plate behind the part, mm; 0 for none",
        "backing = 0; // [0:0.1:10]",
    ]
    assert "letters" not in (tmp_path / "part.scad").read_text()


@OPENSCAD
def test_openscad_makes_the_part(plate, tmp_path):
    scad.write(plate, tmp_path / "part.scad")
    mesh = rendered(tmp_path)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(plate.pattern.region.area * 2, rel=2e-3)
    assert mesh.bounds == pytest.approx(np.array([[-10, -5, 0], [10, 5, 2]]))


@OPENSCAD
def test_parameters_act(plate, tmp_path):
    scad.write(plate, tmp_path / "part.scad")
    mesh = rendered(tmp_path, "-D", "size=40", "-D", "thickness=3", "-D", "backing=1")
    assert mesh.is_watertight
    assert mesh.bounds[:, 2] == pytest.approx([-1, 3])
    outer = plate.pattern.region.outer.area * 4
    assert mesh.volume == pytest.approx(plate.pattern.region.area * 4 * 3 + outer, rel=2e-3)


def used(folder, call):
    """What another file makes of the part's module."""
    (folder / "other.scad").write_text(f"use <part.scad>\n{call}\n")
    command = ["openscad", "-q", "-o", "other.stl", "other.scad"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False, cwd=folder)
    return trimesh.load_mesh(folder / "other.stl") if done.returncode == 0 else None


@OPENSCAD
def test_another_file_uses_the_module_in_a_size_of_its_own(plate, tmp_path):
    scad.write(plate.with_backing(), tmp_path / "part.scad")
    mesh = used(tmp_path, "perforated_qr(size = 40, thickness = 3, backing = 0);")
    assert mesh.is_watertight
    assert mesh.bounds == pytest.approx(np.array([[-20, -10, 0], [20, 10, 3]]))
    assert mesh.volume == pytest.approx(plate.pattern.region.area * 4 * 3, rel=2e-3)
    drawn = used(tmp_path, "perforated_qr();")
    assert drawn.bounds == pytest.approx(np.array([[-10, -5, -1], [10, 5, 2]]))
    assert used(tmp_path, "perforated_code();") is None  # no such module: the check can fail


@OPENSCAD
def test_a_flat_part_with_flared_holes_takes_size_and_thickness(plate, tmp_path):
    flared = replace(plate, solid=replace(plate.solid, volume_mm3=0.9 * plate.solid.volume_mm3))
    scad.write(flared.with_backing(), tmp_path / "part.scad")
    text = (tmp_path / "part.scad").read_text()
    assert "polyhedron(" in text
    assert "\nthickness = 2; // [0.2:0.1:20]\n" in text
    mesh = used(tmp_path, "perforated_qr(size = 40, thickness = 3, backing = false);")
    assert mesh.bounds == pytest.approx(np.array([[-20, -10, 0], [20, 10, 3]]))
    assert mesh.volume == pytest.approx(plate.solid.triangles.volume_mm3 * 4 * 1.5, rel=1e-5)


def test_a_curved_part_has_a_size_and_no_thickness(wrapped, tmp_path):
    scad.write(wrapped, tmp_path / "part.scad")
    text = (tmp_path / "part.scad").read_text()
    assert "module perforated_qr(size = " in text
    assert "thickness" not in text


@OPENSCAD
def test_curved_part_is_a_polyhedron(wrapped, tmp_path):
    scad.write(wrapped, tmp_path / "part.scad")
    assert "polyhedron(" in (tmp_path / "part.scad").read_text()
    mesh = rendered(tmp_path)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(wrapped.solid.volume_mm3, rel=1e-5)


@OPENSCAD
@pytest.mark.parametrize("relief_mm", [0.4, -0.5])
def test_letters_and_backing_are_in_the_extrusion(plate, tmp_path, relief_mm):
    design = plate.with_backing().with_letter(relief_mm)
    scad.write(design, tmp_path / "part.scad")
    assert "polyhedron(" not in (tmp_path / "part.scad").read_text()
    mesh = rendered(tmp_path)
    assert mesh.is_watertight
    assert mesh.bounds[:, 2] == pytest.approx([-1, 2 + max(relief_mm, 0)])
    (backing,) = design.solid.extras
    outer = plate.pattern.region.outer.area  # the fake backing has sharp corners, the source rounds them
    assert backing.volume_mm3 == pytest.approx(200.0)
    assert mesh.volume == pytest.approx(plate.pattern.region.area * 2 + 0.64 * relief_mm + outer, rel=2e-3)


@OPENSCAD
def test_mounting_holes_go_through_the_backing(plate, tmp_path):
    hole = Hole(-6, 0, 3.0)
    spec = replace(plate.pattern.spec, surround=Surround(holes=(hole,)))
    design = replace(plate.with_backing(), pattern=replace(plate.pattern, spec=spec))
    scad.write(design, tmp_path / "part.scad")
    outer, opened = plate.pattern.region.outer.area, hole.diameter_mm**2 * np.pi / 4
    volume = plate.pattern.region.area * 2 + outer - opened
    assert rendered(tmp_path).volume == pytest.approx(volume, rel=2e-3)


@OPENSCAD
def test_a_backing_behind_a_polyhedron(wrapped, tmp_path):
    plate_mm3 = wrapped.with_backing().solid.extras[0].volume_mm3
    scad.write(wrapped.with_backing(), tmp_path / "part.scad")
    both = rendered(tmp_path).volume
    alone = rendered(tmp_path, "-D", "backing=false").volume
    assert alone == pytest.approx(wrapped.solid.volume_mm3, rel=1e-5)
    assert both == pytest.approx(alone + plate_mm3, rel=1e-5)
