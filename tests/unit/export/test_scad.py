from __future__ import annotations

import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from perfqr_cad.export import scad

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


@OPENSCAD
def test_curved_part_is_a_polyhedron(wrapped, tmp_path):
    scad.write(wrapped, tmp_path / "part.scad")
    assert "polyhedron(" in (tmp_path / "part.scad").read_text()
    mesh = rendered(tmp_path)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(wrapped.solid.volume_mm3, rel=1e-5)


def test_a_flat_part_of_other_volume_is_no_extrusion(plate):
    assert scad.is_extrusion(plate)
    flared = replace(plate, solid=replace(plate.solid, volume_mm3=plate.solid.volume_mm3 * 0.99))
    assert not scad.is_extrusion(flared)
