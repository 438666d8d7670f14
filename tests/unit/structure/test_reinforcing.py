from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import scipy.sparse as sp
from shapely.geometry import Point, Polygon

from perfqr_cad.errors import AnalysisError
from perfqr_cad.pattern import Pattern, PatternSpec, build
from perfqr_cad.pattern.choice import easiest
from perfqr_cad.structure import Case, Part, Pressure, Reinforcement, reinforce
from perfqr_cad.structure.analysis import prepare
from perfqr_cad.structure.elements import mindlin_plate as plate
from perfqr_cad.structure.elements import mindlin_shell as shell
from perfqr_cad.structure.elements.assembly import System
from perfqr_cad.structure.elements.solvers import factorise
from perfqr_cad.structure.measure import von_mises
from perfqr_cad.structure.mesh.seeding import MeshSize
from perfqr_cad.structure.mesh.tiling import TileLattice
from perfqr_cad.structure.mesh.triangle import Floats
from perfqr_cad.structure.part import lattice_of
from perfqr_cad.structure.reinforcement.bar_candidates import Allowance, Budget, Candidates, affordable
from perfqr_cad.structure.reinforcement.bar_stiffness import bar_tensors, couplings
from perfqr_cad.structure.reinforcement.lattice_bars import lattice_candidates
from perfqr_cad.structure.reinforcement.reanalysis import Reanalysis, stress_operator
from perfqr_cad.structure.reinforcement.relief import TENSOR, Shortlist, greedy
from perfqr_cad.structure.shell_model import Model
from perfqr_cad.surface import Cylinder, Placement, Plane
from perfqr_cad.symbol import encode, layout

LOAD = Pressure(1e-3)
# The loop is tested here, not the stress: discs and elements are coarse.
EDGE_MM, NOZZLE_MM = 3.0, 1.2


@cache
def pattern() -> Pattern:
    spec = PatternSpec(size_mm=58.0, bars=1, bar_width_mm=0.8)
    return build(encode("REINFORCE ME", version=1, level="M"), spec)


@cache
def bars() -> Candidates:
    return lattice_candidates(pattern(), Allowance.of(pattern()), (pattern().spec.web_mm,))


def begin(
    placement: Placement | None = None, solver: str | None = None, lattice: TileLattice | None = None
) -> Reanalysis:
    size = pattern().module_mm
    part = Part(pattern().polygon, placement or Plane(2.0), lattice=lattice)
    model = prepare(part, Case.of(LOAD), MeshSize(size, size, 0.25 * size, 0.02))
    return Reanalysis(model, model.factorise(solver), model.pressure_forces(1e-3), 0.4)


@cache
def optimal(limit: float) -> Reinforcement:
    case = Case.of(LOAD, yield_mpa=limit, nozzle_mm=NOZZLE_MM)
    return reinforce(pattern(), Plane(2.0), case, edge_mm=EDGE_MM)


def test_candidates_cross_one_hole_from_light_to_light() -> None:
    from shapely.geometry import LineString

    region = pattern().polygon
    assert len(bars()) > 20
    for start, end in zip(bars().start, bars().end, strict=True):
        line = LineString([start, end])
        assert line.intersection(region).length < 0.05 * line.length
        assert max(region.distance(Point(*p)) for p in (start, end)) < 0.05


def asked(start: list[tuple[float, float]], end: list[tuple[float, float]], width: float) -> Candidates:
    widths = np.full(len(start), width)
    return affordable(pattern(), Allowance.of(pattern()), np.array(start), np.array(end), widths)


def test_no_bar_enters_a_finder_ring() -> None:
    m = pattern().module_mm
    ring, below = (-8.5 * m, 10.0 * m), (-8.5 * m, 1.0 * m)  # the finder's dark ring, and data modules
    found = asked([(x - m, y) for x, y in (ring, below)], [(x + m, y) for x, y in (ring, below)], 0.1 * m)
    assert len(found) == 1
    assert found.start[0, 1] == below[1]


def test_bars_along_a_module_edge_turn_nothing_and_through_a_centre_all() -> None:
    m = pattern().module_mm
    dark = pattern().observed.dark
    row, column = next((r, c) for r, c in np.argwhere(dark[9:12, 9:12]) + 9)
    x, y = (column + 0.5 - 10.5) * m, (10.5 - row - 0.5) * m
    start, end = [(x - m / 2, y + m / 2), (x - m / 2, y)], [(x + m / 2, y + m / 2), (x + m / 2, y)]
    found = asked(start, end, m / 3)
    assert (row, column) not in found.turned[0]
    assert found.covered[0] == 0.0
    assert (row, column) in found.turned[1]
    assert found.loss[1] > 0.0


def test_a_budget_keeps_half_of_the_correction() -> None:
    allowance = Allowance.of(pattern())
    today = pattern().readability
    assert allowance.errors == tuple(
        errors + (capacity - errors) // 2
        for errors, capacity in zip(today.errors, today.capacity, strict=True)
    )
    budget = Budget(pattern(), allowance)
    codewords = layout(1, "M").codeword_of
    first = [tuple(np.argwhere(codewords == k)[0].tolist()) for k in range(1 + max(allowance.errors))]
    assert all(budget.spend([module]) for module in first[:-1])
    assert budget.rise([first[-1]]) == np.inf
    assert not budget.spend([first[-1]])


@pytest.mark.parametrize(
    ("placement", "solver", "tiled"),
    [
        (Plane(2.0), None, True),
        (Plane(2.0), None, False),
        (Plane(2.0), "SuperLU", True),
        (Cylinder(60.0, 2.0), None, True),
    ],
)
def test_low_rank_update_is_the_direct_solution(
    placement: Placement, solver: str | None, tiled: bool
) -> None:
    analysis = begin(placement, solver, lattice_of(pattern()) if tiled else None)
    model = analysis.model
    some = bars().take(np.arange(0, len(bars()), len(bars()) // 3)[:3])
    coupling = couplings(model, some)
    if model.flat:
        matrices = plate.stiffness(model.mesh, model.section)
    else:
        matrices = shell.stiffness(model.positions, model.frames, model.mesh.elements, model.section)
    lower = System(model.mesh.elements, model.system.dofs, matrices, model.fixed).lower()
    direct = factorise((lower + sp.tril(coupling @ coupling.T, format="csc")).tocsc(), solver)
    forces = np.where(model.fixed, 0.0, model.pressure_forces(1e-3))
    for part in (coupling[:, : coupling.shape[1] // 3], coupling[:, coupling.shape[1] // 3 :]):
        analysis.add(analysis.respond(part), own(model, some, part), np.zeros(0, np.int64))
    exact = direct.solve(forces)
    assert analysis.displacements[:, 0] == pytest.approx(exact, abs=1e-8 * np.abs(exact).max())


def own(model: Model, bars: Candidates, part: sp.csc_matrix) -> Floats:
    modes = 3 if model.flat else 6
    return bar_tensors(model.section, model.wall_mm, bars.take(np.arange(part.shape[1] // modes)), modes)


def test_a_list_of_bars_foretells_what_laying_them_does() -> None:
    analysis = begin(lattice=lattice_of(pattern()))
    model = analysis.model
    some = bars().take(np.arange(0, len(bars()), len(bars()) // 4)[:4])
    coupling = couplings(model, some)
    hot = analysis.critical_places[0][0][:30]
    operator = stress_operator(model, analysis.discs, hot)
    response = analysis.respond(coupling)
    tensors = bar_tensors(model.section, model.wall_mm, some, 3)
    listed = Shortlist(
        now=(operator @ analysis.displacements).reshape(-1, TENSOR),
        load=np.zeros(operator.shape[0] // TENSOR, np.int64),
        relief=analysis.between(sp.csc_matrix(operator.T), response).reshape(-1, 4, 3),
        flexibility=analysis.between(coupling, response).reshape(4, 3, 4, 3),
        strain=(coupling.T @ analysis.displacements).reshape(4, 3, 1),
        own=tensors,
        under=np.zeros((operator.shape[0] // TENSOR, 4), bool),
        clash=np.eye(4, dtype=bool),
    )
    foretold = listed.with_added(2).with_each()[0]
    for k in (2, 0):
        analysis.add(response.take(3 * k + np.arange(3)), tensors[[k]], np.zeros(0, np.int64))
    places = von_mises((operator @ analysis.displacements).reshape(-1, TENSOR))
    in_bars = von_mises(analysis.in_bars()[0])
    assert foretold == pytest.approx(np.concatenate([places, *in_bars]), rel=1e-6)


def test_the_greedy_choice_weighs_relief_against_price_and_leaves_out_what_clashes() -> None:
    bars = Shortlist(
        now=np.array([[10.0, 0, 0, 0, 0]]),
        load=np.zeros(1, np.int64),
        relief=np.array([[1.0, 0.5], [0, 0], [0, 0], [0, 0], [0, 0]])[:, :, None],
        flexibility=np.eye(2).reshape(2, 1, 2, 1),
        strain=np.full((2, 1, 1), 4.0),  # a force of 2 in each: they take off 2 and 1 MPa
        own=np.zeros((2, 1, TENSOR, 1)),
        under=np.zeros((1, 2), bool),
        clash=np.eye(2, dtype=bool),
    )
    assert greedy(bars, np.ones(2), 0.0, 1e-3, 9) == [0, 1]
    assert greedy(bars, np.array([3.0, 1.0]), 0.0, 1e-3, 9) == [1, 0]
    assert greedy(bars, np.ones(2), 8.5, 1e-3, 9) == [0]
    assert greedy(bars, np.ones(2), 0.0, 0.3, 9) == []
    assert greedy(replace(bars, clash=np.ones((2, 2), bool)), np.ones(2), 0.0, 1e-3, 9) == [0]


def test_response_of_bars_is_the_same_on_seams_as_everywhere() -> None:
    analysis = begin(lattice=lattice_of(pattern()))
    model = analysis.model
    coupling = couplings(model, bars().take(np.arange(0, len(bars()), 7)))
    operator = stress_operator(model, analysis.discs, analysis.critical_places[0][0][:20])
    whole = model.factorise().solve(coupling.toarray())
    found = analysis.between(sp.csc_matrix(operator.T), analysis.respond(coupling))
    expected = operator @ whole
    assert found == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize("placement", [Plane(2.0), Cylinder(60.0, 2.0)])
def test_a_bar_resists_no_rigid_motion(placement: Placement) -> None:
    model = begin(placement).model
    free = couplings_without_supports(model)
    rigid = np.zeros((len(model.mesh.nodes), model.system.dofs))
    if model.flat:
        rigid[:, 0], rigid[:, 1] = model.mesh.nodes[:, 0], 1.0
    else:
        turn = np.array([0.3, -0.2, 0.5])
        rigid[:, :3], rigid[:, 3:] = np.cross(turn, model.positions), turn
    stretch = np.abs(free.T @ np.ones(len(model.fixed))).max()
    assert np.abs(free.T @ rigid.ravel()).max() < 1e-6 * max(stretch, 1.0) * np.abs(rigid).max()


def couplings_without_supports(model: object) -> sp.csc_matrix:
    system = replace(model.system, fixed=np.zeros_like(model.system.fixed))  # type: ignore[attr-defined]
    return couplings(replace(model, system=system), bars())  # type: ignore[type-var]


def test_stress_operator_is_the_measure() -> None:
    analysis = begin()
    ((hot, measure),) = analysis.critical_places
    operator = stress_operator(analysis.model, analysis.discs, hot)
    tensors = (operator @ analysis.displacements).reshape(len(hot), -1, 5)
    assert von_mises(tensors).max(axis=1) == pytest.approx(measure)


def test_strong_part_is_left_alone() -> None:
    result = optimal(100.0)
    assert (result.status, result.iterations, result.confirmations) == ("strong", 0, 0)
    assert result.pattern is pattern()
    assert result.history == (result.before.max_stress_mpa,)


def test_bridges_make_it_stronger_or_say_what_would() -> None:
    before = optimal(100.0).before.max_stress_mpa
    result = optimal(0.9 * before)
    assert result.after.max_stress_mpa <= result.before.max_stress_mpa
    assert np.isfinite(result.pattern.readability.total)
    if result.strong:
        assert result.after.max_stress_mpa <= 0.9 * before
        assert result.iterations == len(result.bridges) > 0
        assert {bridge.stage for bridge in result.bridges} == {"structural"}
    else:
        assert result.status == "weak: no affordable bridge is left"
        assert any("thickness" in remedy for remedy in result.remedies)


def test_nothing_saves_a_part_a_thousand_times_too_weak() -> None:
    case = Case.of(LOAD, yield_mpa=1e-3, nozzle_mm=NOZZLE_MM)
    result = reinforce(pattern(), Plane(2.0), case, method="paper", edge_mm=EDGE_MM)
    assert result.status == "weak: no affordable bridge is left"
    assert len(result.remedies) >= 2


def test_settings_out_of_range_are_refused() -> None:
    with pytest.raises(AnalysisError, match="method 'guess' is unknown"):
        reinforce(pattern(), Plane(2.0), Case.of(LOAD), method="guess")  # type: ignore[arg-type]
    with pytest.raises(AnalysisError, match=r"yield stress is 0.0 MPa"):
        Case.of(LOAD, yield_mpa=0.0)


def bars_needed(method: str, version: int, size_mm: float, finder: str, pressure_mpa: float) -> Reinforcement:
    spec = PatternSpec(size_mm=size_mm, finder=finder)  # type: ignore[arg-type]
    drawn = build(
        easiest(encode("https://example.com/p/1234567", version=version), spec, pads=False)[0], spec
    )
    case = Case.of(Pressure(pressure_mpa), flare_mm=0.375)
    return reinforce(drawn, Plane(1.6), case, method=method)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("version", "size_mm", "finder", "pressure_mpa"),
    [(3, 60.0, "panel", 12e-3), (8, 140.0, "diagonal", 1.8e-3)],
)
def test_the_optimal_choice_ends_no_worse_than_the_paper_s(
    version: int, size_mm: float, finder: str, pressure_mpa: float
) -> None:
    paper, best = (bars_needed(m, version, size_mm, finder, pressure_mpa) for m in ("paper", "optimal"))
    assert paper.strong
    assert best.strong
    assert sum(best.pattern.readability.errors) <= sum(paper.pattern.readability.errors)
    fewer = len(best.bridges) <= len(paper.bridges)
    assert fewer or best.after.max_stress_mpa < 0.8 * paper.after.max_stress_mpa
    assert 0 < len(best.bridges) <= 3


def test_bars_are_looked_for_in_holes_that_fall_into_pieces_when_shrunk() -> None:
    spec = PatternSpec(size_mm=60.0, finder="panel")
    drawn = build(easiest(encode("https://example.com/p/1234567", version=3), spec, pads=False)[0], spec)
    found = lattice_candidates(drawn, Allowance.of(drawn), (drawn.spec.web_mm,))
    holes = [Polygon(ring) for ring in drawn.polygon.interiors]
    shrunk = [hole.buffer(-drawn.spec.web_mm / 2 - drawn.spec.gap_mm, join_style="mitre") for hole in holes]
    in_pieces = [hole for hole, left in zip(holes, shrunk, strict=True) if left.geom_type == "MultiPolygon"]
    middles = 0.5 * (found.start + found.end)
    assert in_pieces
    assert sum(hole.contains(Point(middle)) for hole in in_pieces for middle in middles) > 50
