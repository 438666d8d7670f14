from dataclasses import replace

import numpy as np
import pytest
from shapely.affinity import translate
from shapely.geometry import MultiPolygon, Point, Polygon, box

from perfqr_cad.errors import AnalysisError
from perfqr_cad.structure import (
    Case,
    Finger,
    Hold,
    Part,
    Pressure,
    StressField,
    Support,
    Weight,
    analyse_part,
)
from perfqr_cad.structure.elements.solvers import cholmod
from perfqr_cad.structure.mesh.seeding import MeshSize
from perfqr_cad.surface import Cylinder, HeightField, Placement, Plane

PLATE = box(-20, -20, 20, 20).difference(box(-5, -5, 5, 5))
PUSH = Pressure(0.001)


def solve(
    polygon: Polygon = PLATE,
    placement: Placement | None = None,
    load: object = PUSH,
    edge_mm: float = 2.0,
    **settings: object,
) -> StressField:
    case = Case.of(load, **settings)  # type: ignore[arg-type]
    return analyse_part(Part(polygon, placement or Plane(2.0)), case, MeshSize.graded(edge_mm, 0.4))


def test_reactions_balance_the_load() -> None:
    field = solve()
    assert field.load_n == pytest.approx((0, 0, -0.001 * PLATE.area))
    assert np.add(field.load_n, field.reactions_n) == pytest.approx(0, abs=1e-9 * 0.001 * PLATE.area)
    assert field.balance < 1e-9


def test_symmetric_plate_has_symmetric_field() -> None:
    field = solve(edge_mm=1.0)
    index = {tuple(p): i for i, p in enumerate(np.round(field.uv_mm, 6))}
    pairs = [(i, index[(-x, y)]) for (x, y), i in index.items() if (-x, y) in index]
    assert len(pairs) > 50
    left, right = np.transpose(pairs)
    assert (
        np.abs(field.deflection_mm[left] - field.deflection_mm[right]).max() < 2e-3 * field.max_deflection_mm
    )


def test_answer_is_linear_in_load_and_arrays_are_read_only() -> None:
    one, two = solve(), solve(load=Pressure(0.002))
    assert two.max_stress_mpa == pytest.approx(2 * one.max_stress_mpa)
    assert two.safety_factor == pytest.approx(one.safety_factor / 2)
    with pytest.raises(ValueError, match="read-only"):
        one.displacement_mm[0] = 1.0


def test_unloaded_part_is_infinitely_safe() -> None:
    field = solve(load=Pressure(0.0))
    assert field.max_stress_mpa == 0.0
    assert field.safety_factor == float("inf")


def test_pressure_pushes_the_front_backwards() -> None:
    field = solve()
    assert field.deflection_mm.min() == pytest.approx(-field.max_deflection_mm)


@pytest.mark.parametrize("hold", ["clamped", "simple", "two-sides", "corners"])
def test_supports_order_by_stiffness(hold: str) -> None:
    clamped, other = solve(), solve(support=hold)
    assert other.support == hold
    assert other.max_deflection_mm >= clamped.max_deflection_mm
    assert other.balance < 1e-9


def test_finger_finds_a_place_at_least_as_bad_as_the_middle() -> None:
    plate = box(-20, -20, 20, 20)
    middle = solve(plate, load=Finger(10.0, 4.0, (0.0, 0.0)))
    assert middle.load_n[2] == pytest.approx(-10.0)
    assert solve(plate, load=Finger(10.0, 4.0)).max_stress_mpa >= 0.98 * middle.max_stress_mpa


def test_finger_over_a_hole_is_refused() -> None:
    with pytest.raises(AnalysisError, match=r"no material under a finger of radius 2 mm at \(0, 0\)"):
        solve(load=Finger(10.0, 2.0, (0.0, 0.0)))


def test_weight_into_the_front_is_the_same_as_plate_and_as_shell() -> None:
    plate, shell = solve(load=Weight()), solve(load=Weight((0, 0, -1)))
    assert plate.load_n[2] == pytest.approx(-PLATE.area * 2.0 * 1240e-9 * 9.80665)
    assert shell.unknowns > 1.9 * plate.unknowns
    assert shell.max_deflection_mm == pytest.approx(plate.max_deflection_mm, rel=1e-6)
    assert shell.max_stress_mpa == pytest.approx(plate.max_stress_mpa, rel=1e-6)


def test_curved_panel_of_large_radius_is_the_flat_one() -> None:
    flat, bent = solve(), solve(placement=Cylinder(1e5, 2.0))
    assert bent.max_deflection_mm == pytest.approx(flat.max_deflection_mm, rel=1e-3)
    assert bent.max_stress_mpa == pytest.approx(flat.max_stress_mpa, rel=5e-3)


def test_curvature_stiffens_a_clamped_panel() -> None:
    assert solve(placement=Cylinder(30.0, 2.0)).max_deflection_mm < 0.8 * solve().max_deflection_mm


def test_large_deflection_is_warned_about() -> None:
    assert solve().warnings == ()
    assert "arms that end freely" in solve(load=Pressure(10.0)).warnings[0]


def test_superlu_and_cholmod_agree_and_say_who_they_are() -> None:
    fallback = solve(solver="SuperLU")
    assert fallback.solver == "SuperLU"
    if cholmod() is None:
        pytest.skip("scikit-sparse is not installed: nothing to compare SuperLU with")
    best = solve()
    assert best.solver == "CHOLMOD"
    assert fallback.max_stress_mpa == pytest.approx(best.max_stress_mpa, rel=1e-8)


def test_outline_with_near_coincident_points_is_cleaned_before_it_is_meshed() -> None:
    whole = box(-20, -20, 20, 20)
    ring = np.repeat(np.array(whole.exterior.coords), 40, axis=0)
    crowded = Polygon(ring + np.random.default_rng(0).uniform(0, 1e-9, ring.shape))
    assert solve(crowded).max_deflection_mm == pytest.approx(solve(whole).max_deflection_mm, rel=1e-3)


class Wall(Plane):
    """A plane that skips the placement's own check."""

    def __post_init__(self) -> None:
        pass


@pytest.mark.parametrize("thickness", [0.0, -1.0, float("nan")])
def test_thickness_without_meaning_is_refused(thickness: float) -> None:
    with pytest.raises(AnalysisError, match="thickness is"):
        solve(placement=Wall(thickness))


def test_two_pieces_are_refused_and_located() -> None:
    loose = translate(Point(0, 0).buffer(1), 0.5, 0.25)
    with pytest.raises(AnalysisError, match=r"2 pieces; loose ones near \(0\.\d, 0\.\d\) mm"):
        solve(MultiPolygon([PLATE, loose]))


@pytest.mark.filterwarnings("ignore:invalid value encountered in linearrings:RuntimeWarning")
def test_points_that_are_no_numbers_are_refused() -> None:
    broken = Polygon([(0, 0), (10, 0), (float("nan"), 10), (0, 0)])
    with pytest.raises(AnalysisError, match=r"1 points .* not finite"):
        solve(broken)


def test_empty_region_is_refused() -> None:
    with pytest.raises(AnalysisError, match="empty"):
        solve(Polygon())


def test_disc_held_at_two_sides_touches_them_in_no_edge() -> None:
    with pytest.raises(AnalysisError, match=r"left support \(x = -20.00 mm\)"):
        solve(Point(0, 0).buffer(20), support="two-sides")


def test_corner_pads_without_material_are_refused() -> None:
    with pytest.raises(AnalysisError, match=r"no material on the 1.00 mm corner pad"):
        solve(Point(0, 0).buffer(20), support=Support(Hold.CORNERS, 1.0))


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"material": "cheese"}, "material 'cheese' is unknown"),
        ({"support": "magnets"}, "support 'magnets' is unknown"),
        ({"solver": "abacus"}, "solver 'abacus' is unknown"),
        ({"edge_mm": 0.0}, "mesh size is 0.0 mm"),
        ({"nozzle_mm": float("inf")}, "nozzle is inf mm"),
    ],
)
def test_settings_out_of_range_are_refused(settings: dict[str, object], message: str) -> None:
    with pytest.raises(AnalysisError, match=message):
        solve(**settings)


def test_load_that_is_no_number_is_refused() -> None:
    with pytest.raises(AnalysisError, match="pressure is nan MPa"):
        Pressure(float("nan"))
    with pytest.raises(AnalysisError, match="finger radius"):
        replace(Finger(1.0), radius_mm=0.0)


def test_a_wall_thicker_than_its_surface_is_curved_is_refused() -> None:
    wavy = HeightField.of(lambda x, y: 2 * np.cos(1.5 * x), 12.0, 6.0)
    with pytest.raises(AnalysisError, match=r"the wall of 6 mm folds over itself near \("):
        solve(box(-10, -10, 10, 10), wavy, edge_mm=1.5)


@pytest.mark.parametrize("load", [1e300, -1e300, float("nan"), float("inf")])
def test_a_load_beyond_all_bounds_is_refused(load: float) -> None:
    with pytest.raises(AnalysisError, match=r"pressure is .* no more than 1e\+09 MPa"):
        Pressure(load)


def test_a_yield_stress_that_is_no_number_is_refused() -> None:
    with pytest.raises(AnalysisError, match="yield stress is nan MPa"):
        Case.of(PUSH, yield_mpa=float("nan"))
