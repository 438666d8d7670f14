"""Meshes of tiles and structures condensed tile by tile, against one mesh and one matrix."""

from dataclasses import replace

import numpy as np
import pytest
import shapely
from shapely.geometry import Point, Polygon, box

from perfqr_cad.errors import AnalysisError
from perfqr_cad.pattern import PatternSpec, build
from perfqr_cad.structure import Case, Finger, Load, Part, Pressure, StressField, Weight, analyse_part
from perfqr_cad.structure.analysis import prepare
from perfqr_cad.structure.elements import mindlin_plate as plate
from perfqr_cad.structure.elements.assembly import System
from perfqr_cad.structure.mesh.gmsh_mesher import Face, triangulate_all, twice_areas
from perfqr_cad.structure.mesh.light_region import ThinPart, thin_parts
from perfqr_cad.structure.mesh.seeding import MeshSize
from perfqr_cad.structure.mesh.tile_meshes import TileMeshes
from perfqr_cad.structure.mesh.tiled_mesh import tiled_mesh
from perfqr_cad.structure.mesh.tiling import TileLattice, cut
from perfqr_cad.structure.shell_model import Model, forces_of
from perfqr_cad.surface import Plane
from perfqr_cad.symbol import encode

SIZE = MeshSize(edge_mm=1.4, corner_mm=0.4, layer_mm=0.3, tolerance_mm=0.02)
HOLES = shapely.union_all([box(x, y, x + 2, y + 2) for x in range(-8, 8, 4) for y in range(-8, 8, 4)])
GRATE = box(-11, -11, 11, 11).difference(HOLES)
LATTICE = TileLattice(2.0)


def grate_model(size: float = 1.4) -> Model:
    part = Part(GRATE, Plane(2.0), lattice=LATTICE)
    return prepare(part, Case.of(Pressure(1e-3)), MeshSize.graded(size, 0.4))


def solve(part: Part, load: Load, edge_mm: float, support: str = "clamped") -> StressField:
    return analyse_part(part, Case.of(load, support=support), MeshSize.graded(edge_mm, 0.4))


def test_tiles_that_look_alike_are_one_kind() -> None:
    tiling = cut([GRATE], LATTICE)
    assert len(tiling.places) == 12 * 12
    assert len(tiling.contents) < 30


@pytest.mark.parametrize(
    "region",
    [
        GRATE,
        Point(0.3, 0.2).buffer(7.3).difference(Point(1, 1).buffer(2.9)),
        # Edges along would-be cuts, a needle and a notch.
        Polygon(
            [(-5, -5), (5, -5), (5, 1), (0.4, 1), (5, 1.3), (5, 5), (-5, 5), (-5, 2), (-3, 2), (-5, 1.8)]
        ),
    ],
)
@pytest.mark.parametrize("pitch", [2.0, 3.7])
def test_a_tiled_mesh_covers_its_region_and_has_no_open_seams(region: Polygon, pitch: float) -> None:
    mesh = tiled_mesh([region], TileLattice(pitch), TileMeshes(SIZE)).mesh
    assert float(mesh.area_mm2.sum()) == pytest.approx(region.area, rel=2e-3)
    ends = mesh.nodes[mesh.boundary[:, :2]]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum()
    assert length == pytest.approx(region.length, rel=5e-3)
    assert np.asarray(region.boundary.distance(shapely.points(ends.reshape(-1, 2)))).max() < 0.03


def test_condensed_answer_is_that_of_the_whole_matrix() -> None:
    model = grate_model()
    matrices = plate.stiffness(model.mesh, model.section)
    whole = System(model.mesh.elements, model.system.dofs, matrices, model.fixed)
    right = np.random.default_rng(1).normal(size=(len(model.fixed), 3)) * ~model.fixed[:, None]
    right[: len(right) // 2, 1] = 0.0
    condensed, direct = model.factorise(), whole.factorise()
    exact = direct.solve(right)
    assert condensed.solve(right) == pytest.approx(exact, abs=1e-9 * np.abs(exact).max())
    assert condensed.work(right) == pytest.approx(direct.work(right))
    held = model.system.held_forces(exact[:, 0])
    assert held == pytest.approx(whole.held_forces(exact[:, 0]), abs=1e-9 * np.abs(held).max())


def test_tiling_does_not_move_the_answer() -> None:
    answers = [
        solve(Part(GRATE, Plane(2.0), lattice=TileLattice(pitch)), Pressure(1e-3), 0.7)
        for pitch in (2.0, 3.3)
    ]
    assert answers[0].max_deflection_mm == pytest.approx(answers[1].max_deflection_mm, rel=5e-3)
    assert answers[0].max_stress_mpa == pytest.approx(answers[1].max_stress_mpa, rel=0.05)


def test_thin_part_bends_as_thin_and_weighs_as_thin() -> None:
    strip = box(0, 0, 20, 4)
    thin = ThinPart(box(0, 0, 10, 4), 1.0)
    whole, half, all_thin, every = (
        solve(part, Weight(), 1.0, "two-sides")
        for part in (
            Part(strip, Plane(2.0)),
            Part(strip, Plane(2.0), (thin,)),
            Part(strip, Plane(1.0)),
            Part(strip, Plane(2.0), (replace(thin, polygon=strip),)),
        )
    )
    assert half.load_n == pytest.approx(np.multiply(0.75, whole.load_n))
    assert half.max_stress_at_mm[0] < 10.0
    assert whole.max_deflection_mm < half.max_deflection_mm
    assert every.max_deflection_mm == pytest.approx(all_thin.max_deflection_mm, rel=1e-6)


@pytest.mark.parametrize("size", [2.0, 1.1, 0.8, 0.5, 0.3])
def test_a_thin_bar_is_joined_to_the_walls_at_both_ends(size: float) -> None:
    bar = box(-0.5, -0.45, 0.5, 0.45)
    part = shapely.union_all([box(-9, -9, 9, 9).difference(box(-0.5, -4, 0.5, 4)), bar])
    model = prepare(
        Part(part, Plane(2.0), (ThinPart(bar, 0.4),), LATTICE), Case.of(Weight()), MeshSize.graded(size, 0.4)
    )
    ends = model.mesh.nodes[model.mesh.boundary[:, :2]]
    assert np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum() == pytest.approx(part.length)


def test_part_thicker_than_its_wall_is_refused() -> None:
    with pytest.raises(AnalysisError, match=r"3.0 mm thick in a wall of 2.0 mm"):
        solve(Part(GRATE, Plane(2.0), (ThinPart(box(0, 0, 1, 1), 3.0),)), Weight(), 2.0)


def test_loads_act_together() -> None:
    model = grate_model(2.0)
    factor = model.factorise()
    loads = (Pressure(1e-3), Weight(), Finger(2.0, 3.0, (1.0, 1.0)))
    parts = sum(forces_of(model, (load,), factor) for load in loads)
    assert forces_of(model, loads, factor) == pytest.approx(parts)
    roaming = forces_of(model, (Pressure(1e-3), Finger(2.0, 3.0)), factor)
    assert roaming.sum() == pytest.approx(forces_of(model, (Pressure(1e-3),), factor).sum() - 2.0)


def test_recessed_bars_are_thin_where_the_wall_has_room_for_their_slot() -> None:
    pattern = build(
        encode("BARS", version=1), PatternSpec(size_mm=50.0, finder="recessed", bar_height_mm=0.6)
    )
    bars = thin_parts(pattern, 2.0)
    assert [bar.thickness_mm for bar in bars] == [0.6] * len(pattern.recessed) != []
    assert all(pattern.polygon.buffer(1e-6).covers(bar.polygon) for bar in bars)
    assert thin_parts(pattern, 0.9) == ()


@pytest.mark.parametrize("sense", [1, -1])
def test_a_hole_that_turned_over_on_the_grid_is_a_hole(sense: int) -> None:
    """The corners of a sliver are put on a grid, by which it may turn over; a mesh has no sense."""
    outer = np.array([(0.0, 0.0), (1.2, 0.0), (1.2, 1.2), (0.0, 1.2)])
    sliver = np.array([(0.45, 0.05), (0.475, 0.0001), (0.4054, 0.1446)])[::sense]
    vertices, triangles = triangulate_all([Face((outer, sliver))], 0.5)[0]
    assert abs(twice_areas(vertices, triangles)).sum() / 2 == pytest.approx(
        1.44 - Polygon(sliver).area, rel=1e-9
    )
