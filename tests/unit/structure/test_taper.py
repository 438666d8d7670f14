"""The factor for walls that flare, against the section's own integrals and a solid beam."""

import numpy as np
import pytest
from shapely.geometry import box
from skfem import Basis, ElementTetP2, ElementVector, MeshTet, condense, solve
from skfem.models.elasticity import lame_parameters, linear_elasticity

from perfqr_cad.errors import AnalysisError
from perfqr_cad.pattern import PatternSpec, build
from perfqr_cad.structure import Case, Pressure, analyse
from perfqr_cad.structure.taper import STRAIGHT, Taper, webs
from perfqr_cad.surface import Plane
from perfqr_cad.symbol import encode

WEB, FLARE, THICKNESS = 0.8, 0.4, 2.0


def test_factors_are_those_of_the_section() -> None:
    z = (np.arange(20_000) + 0.5) / 20_000 * THICKNESS
    width = WEB + 2 * FLARE * z / THICKNESS
    centre = (z * width).sum() / width.sum()
    inertia = ((z - centre) ** 2 * width).sum() * THICKNESS / len(z)
    front = WEB + 2 * FLARE
    found = Taper.of(WEB, FLARE)
    assert found.deflection == pytest.approx(front * THICKNESS**3 / 12 / inertia, rel=1e-6)
    assert found.stress == pytest.approx(centre / inertia * front * THICKNESS**2 / 6, rel=1e-6)


def test_upright_walls_add_nothing() -> None:
    found = Taper.of(WEB, 0.0)
    assert (found.stress, found.deflection) == pytest.approx((STRAIGHT.stress, STRAIGHT.deflection))


def tip_deflection(flare_mm: float) -> float:
    """Of a cantilever of 20 mm whose web tapers towards the back, under a unit force."""
    box = MeshTet.init_tensor(np.linspace(0, 20, 21), np.linspace(-0.5, 0.5, 3), np.linspace(0, 1, 4))
    x, y, z = box.p
    mesh = MeshTet(np.stack([x, y * (WEB + 2 * flare_mm * z), THICKNESS * z]), box.t)
    basis = Basis(mesh, ElementVector(ElementTetP2()))
    stiffness = linear_elasticity(*lame_parameters(1000.0, 0.0)).assemble(basis)
    ends = basis.get_dofs(lambda p: p[0] > 20 - 1e-9).all("u^3")
    force = np.zeros(basis.N)
    force[ends] = 1.0 / len(ends)
    held = basis.get_dofs(lambda p: p[0] < 1e-9).all()
    return float(solve(*condense(stiffness, force, D=held))[ends].mean())


def test_a_solid_beam_deflects_as_foretold() -> None:
    front = WEB + 2 * FLARE
    upright = 20.0**3 / (3 * 1000.0 * front * THICKNESS**3 / 12)
    assert tip_deflection(FLARE) == pytest.approx(Taper.of(WEB, FLARE).deflection * upright, rel=0.03)
    assert tip_deflection(FLARE) > 1.1 * upright


def test_a_field_has_the_taper_of_each_web_in_it() -> None:
    pattern = build(encode("FLARE", version=1), PatternSpec(size_mm=58.0))
    straight = analyse(pattern, Plane(2.0), Case.of(Pressure(1e-4)), 3.0)
    flared = analyse(pattern, Plane(2.0), Case.of(Pressure(1e-4), flare_mm=FLARE), 3.0)
    most = Taper.of(pattern.spec.web_mm, FLARE)
    assert straight.max_stress_mpa < flared.max_stress_mpa < most.stress * straight.max_stress_mpa
    assert straight.max_deflection_mm < flared.max_deflection_mm
    assert flared.max_deflection_mm < most.deflection * straight.max_deflection_mm
    assert flared.balance < 1e-8


@pytest.mark.parametrize(("front", "back"), [(0.8, 0.8), (1.6, 0.8), (3.0, 2.2), (20.0, 19.2)])
def test_a_web_has_at_least_the_taper_of_its_width(front: float, back: float) -> None:
    strip = box(0, -front / 2, 60, front / 2)
    (found,) = webs(strip, np.array([[30.0, 0.1]]), 0.8, FLARE)
    own = Taper.of(back, (front - back) / 2)
    assert own.deflection <= found.taper.deflection + 1e-9
    assert found.taper.deflection < 1.2 * own.deflection


@pytest.mark.parametrize(("web", "flare"), [(0.0, 0.1), (0.8, -0.1), (0.8, float("nan"))])
def test_figures_out_of_range_are_refused(web: float, flare: float) -> None:
    with pytest.raises(AnalysisError, match="mm; it must be"):
        Taper.of(web, flare)
