"""Loads of a hand: their names, their balance, and capacities against beams that can be solved by hand."""

from functools import cache

import numpy as np
import pytest
from shapely.geometry import box

from perfqr_cad.errors import AnalysisError
from perfqr_cad.pattern import Pattern, PatternSpec, build
from perfqr_cad.structure import Case, Part, assess, handling_loads
from perfqr_cad.structure.analysis import prepare
from perfqr_cad.structure.assessment import Assessment
from perfqr_cad.structure.handling.capacity import STRESS_MARGIN, Hand, Way
from perfqr_cad.structure.handling.fingertips import worst_fingertips
from perfqr_cad.structure.handling.named_loads import HANDLING, HandlingLoad
from perfqr_cad.structure.handling.places import breaking, breaks_ring, on_ring, place
from perfqr_cad.structure.handling.pushes import fingertip, pushes
from perfqr_cad.structure.mesh.seeding import MeshSize
from perfqr_cad.surface import Cylinder, Placement, Plane
from perfqr_cad.symbol import encode

STRIP = box(0, 0, 100, 10)


def hand(placement: Placement | None = None, support: str = "free") -> Hand:
    case = Case.of((), support=support).for_hands(HANDLING, upright=False)
    model = prepare(Part(STRIP, placement or Plane(1.0)), case, MeshSize.graded(2.0, 0.4))
    return Hand(model, model.factorise(), case)


@cache
def default_part(support: str = "free") -> Assessment:
    case = Case.of((), support=support).for_hands(handling_loads(()), upright=False)
    return assess(pattern(), Plane(2.0), case, 3.0)


@cache
def pattern() -> Pattern:
    return build(encode("IN THE HAND", version=1), PatternSpec(size_mm=58.0, finder="panel"))


def test_a_name_picks_and_newtons_set() -> None:
    usual = {load.name: load.newtons for load in HANDLING}
    assert {load.name: load.newtons for load in handling_loads(())} == usual
    assert {load.name: load.newtons for load in handling_loads(("push=7",))} == usual | {"push": 7.0}
    assert [load.name for load in handling_loads(("bend", "twist=1"))] == ["bend", "twist"]
    assert [load.newtons for load in handling_loads(("handling", "bend=3")) if load.name == "bend"] == [3.0]
    assert handling_loads((), 0.01)[-1].pressure_mpa == 0.01


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ("kick=3", "load 'kick' is unknown; choose one of weight, fingertip"),
        ("bend=much", "has no number of newtons"),
        ("bend=-1", "bend is -1 N; it must be more than 0"),
        ("pressure", "has no usual force"),
    ],
)
def test_loads_that_cannot_be_meant_are_refused(asked: str, message: str) -> None:
    with pytest.raises(AnalysisError, match=message):
        handling_loads((asked,))


@pytest.mark.parametrize("placement", [Plane(1.0), Cylinder(80.0, 1.0)])
@pytest.mark.parametrize("load", [load for load in HANDLING if load.name != "fingertip"])
def test_what_holds_balances_what_presses(load: HandlingLoad, placement: Placement) -> None:
    held = hand(placement)
    for push in pushes(load, held.model.domain):
        forces = held.forces(push)
        resultant = np.einsum("nci,nc->i", held.model.rigid_motions, held.model.moved(forces))
        assert resultant == pytest.approx(0.0, abs=1e-9)
        assert np.abs(forces).sum() > 1.0


def test_pins_of_a_free_part_bear_nothing() -> None:
    held = hand()
    (push,) = pushes(HandlingLoad("twist", 1.0), held.model.domain)
    forces, moved = held.solve([Way(HandlingLoad("twist", 1.0), push)])
    in_pins = held.model.system.held_forces(moved[:, 0]) - np.where(held.model.fixed, forces[:, 0], 0.0)
    assert np.abs(in_pins).max() < 1e-7


def test_three_point_bending_of_a_strip_is_that_of_a_beam() -> None:
    held = hand()
    load = HandlingLoad("bend", 1.0)
    push = pushes(load, held.model.domain)[0]
    _, moved = held.solve([Way(load, push)])
    found = held.answer(Way(load, push), moved[:, 0])
    span, strip = 100.0 - 8.0, 8.0  # between the middles of the edges held; width of what is pressed
    moment = span / 4 - strip / 8
    stress = STRESS_MARGIN * moment / (10.0 * 1.0**2 / 6)
    assert found.stress_mpa == pytest.approx(stress, rel=0.05)
    assert found.bears_n == pytest.approx(found.limit_mpa / stress, rel=0.05)
    assert found.limit_mpa == pytest.approx(50.0 * 0.9 * 0.9 / 2)


def test_weight_held_at_an_edge_is_a_cantilever_and_creeps() -> None:
    held = hand()
    load = HandlingLoad("weight", None)
    push = pushes(load, held.model.domain)[0]
    _, moved = held.solve([Way(load, push)])
    found = held.answer(Way(load, push), moved[:, 0])
    moment = found.asked_n / 100 * 92**2 / 2
    assert found.asked_n == pytest.approx(100 * 10 * 1.0 * 1240e-9 * 9.80665)
    assert found.stress_mpa == pytest.approx(STRESS_MARGIN * moment / (10 / 6), rel=0.06)
    assert found.limit_mpa == pytest.approx(0.4 * 50.0 * 0.9 * 0.9 / 2)


def test_the_worst_fingertip_of_an_arm_is_at_its_tip() -> None:
    arm = box(0, 0, 40, 40).difference(box(4, 4, 36, 17)).difference(box(4, 23, 36, 36))
    arm = arm.difference(box(30, 16, 36, 24))
    case = Case.of((), support="free").for_hands(HANDLING, upright=False)
    model = prepare(Part(arm, Plane(1.0)), case, MeshSize.graded(2.0, 0.4))
    held = Hand(model, model.factorise(), case)
    ((worst,),) = worst_fingertips(held, [lambda _: True], 1)
    assert worst.at_mm == pytest.approx((29.0, 20.0), abs=4.0)


def test_an_assessment_has_every_load_least_first_and_its_field() -> None:
    found = default_part()
    assert {one.load.name for one in found.capacities} == {load.name for load in HANDLING}
    assert [one.use for one in found.capacities] == sorted(
        (one.use for one in found.capacities), reverse=True
    )
    assert found.use == found.capacities[0].use
    assert found.field.max_stress_mpa == pytest.approx(found.capacities[0].stress_mpa)
    assert found.field.balance < 1e-7
    assert found.strong == all(one.enough for one in found.capacities)


def test_a_mounted_part_bears_what_is_done_to_mounted_parts() -> None:
    assert {one.load.name for one in default_part("clamped").capacities} == {"weight", "fingertip"}


def test_a_finger_may_press_where_another_does_not() -> None:
    held = hand()
    with pytest.raises(AnalysisError, match="no material to press"):
        held.forces(fingertip((50.0, 40.0), held.rim))


def test_places_have_words() -> None:
    assert place(pattern(), (15.0, 15.0)) == "on the upper right finder ring"
    bar = next(one for one in pattern().bridges if one.stage == "function")
    assert breaking(pattern(), bar.start).startswith("at the bar of the ring")


def test_the_outer_end_of_a_bar_counts_as_its_ring():
    recessed = build(encode("IN THE HAND", version=1), PatternSpec(size_mm=58.0))
    edge = recessed.symbol.size / 2 * recessed.module_mm
    ends = [end for bar in recessed.recessed for end in (bar.start, bar.end)]
    outer = [end for end in ends if max(abs(end[0]), abs(end[1])) >= edge - 1e-9]
    assert not all(on_ring(recessed, end) for end in outer)
    assert all(breaks_ring(recessed, end) for end in outer)
    assert not breaks_ring(recessed, (0.5 * edge, -0.5 * edge))
