"""The wedge solid: NAFEMS LE10 (The Standard NAFEMS Benchmarks, 1990), and the shell against it."""

import numpy as np
import pytest
from shapely.geometry import box
from shapely.ops import unary_union

from perfqr_cad.structure import Case, Material, Part, Pressure
from perfqr_cad.structure.analysis import prepare
from perfqr_cad.structure.elements.assembly import System
from perfqr_cad.structure.elements.solvers import factorise
from perfqr_cad.structure.elements.wedge import layered, stiffness, stresses
from perfqr_cad.structure.mesh.seeding import MeshSize
from perfqr_cad.structure.mesh.triangle import SIX_POINTS, SIX_WEIGHTS, Mesh, gradients, quadratic, shapes
from perfqr_cad.structure.solid_check import check
from perfqr_cad.surface import Plane

STEEL = Material("LE10", 210e3, 0.3, 100.0, 1000.0, "NAFEMS LE10")


def elliptic_plate(n: int) -> Mesh:
    """A quarter between the ellipses (2, 1) and (3.25, 2.75), mapped."""
    s, t = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1), indexing="ij")
    i = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    a, b, c, d = i[:-1, :-1].ravel(), i[1:, :-1].ravel(), i[1:, 1:].ravel(), i[:-1, 1:].ravel()
    flat = quadratic(np.c_[s.ravel(), t.ravel()], np.r_[np.c_[a, b, c], np.c_[a, c, d]])
    s, t = flat.nodes[:, 0], np.pi / 2 * flat.nodes[:, 1]
    inner, outer = np.c_[2 * np.cos(t), np.sin(t)], np.c_[3.25 * np.cos(t), 2.75 * np.sin(t)]
    return Mesh((1 - s)[:, None] * inner + s[:, None] * outer, flat.elements, flat.corners)


def le10(n: int, layers: int) -> float:
    """σyy at D over -5.38 MPa: a thick plate under 1 MPa on `layers` of wedges, its outer side held."""
    thickness = 0.6 / layers
    mesh = elliptic_plate(n)
    count, levels = len(mesh.nodes), 2 * layers + 1
    frames = np.tile(np.eye(3), (count, 1, 1))
    elements, matrices = [], []
    for k in range(layers):
        positions = np.c_[mesh.nodes, np.full(count, (k + 0.5) * thickness)]
        elements.append(layered(mesh.elements, count) + 2 * k * count)
        matrices.append(stiffness(positions, frames[:, 2], mesh.elements, thickness, STEEL))
    forces = np.zeros((levels, count, 3))
    slope = np.einsum("gpi,mic->mgpc", gradients(SIX_POINTS), mesh.nodes[mesh.elements])
    area = np.cross(
        np.pad(slope[:, :, 0], ((0, 0), (0, 0), (0, 1))), np.pad(slope[:, :, 1], ((0, 0), (0, 0), (0, 1)))
    )
    share = np.einsum("g,gi,mg->mi", SIX_WEIGHTS, shapes(SIX_POINTS), area[..., 2])
    forces[-1, :, 2] = -np.bincount(mesh.elements.ravel(), share.ravel(), minlength=count)
    u, v = mesh.nodes.T
    rim = (u / 3.25) ** 2 + (v / 2.75) ** 2 > 1 - 1e-9
    held = np.zeros((levels, count, 3), bool)
    held[:, u < 1e-9, 0], held[:, v < 1e-9, 1] = True, True
    held[:, rim, :2] = True
    held[layers, rim, 2] = True
    system = System(np.concatenate(elements), 3, np.concatenate(matrices), held.ravel())
    answer = factorise(system.lower()).solve(np.where(held, 0.0, forces).ravel())
    top = answer.reshape(levels, count, 3)[-3:].ravel()
    stress = stresses((positions, frames[:, 2]), frames, mesh.elements, thickness, STEEL, top)
    d = int(np.argmin(np.hypot(u - 2, v)))
    return float(stress[mesh.elements[:, :3] == d][:, 2, 1].mean()) / -5.38


def test_le10() -> None:
    assert le10(16, 2) == pytest.approx(1, abs=0.02)
    assert le10(16, 1) != pytest.approx(1, abs=0.02)


MODULE = 2.4
BARS = unary_union(
    [box(-12, -12, 12, 12).difference(box(-8, -8, 8, 8)), box(-4, -4, 4, 4)]
    + [box(*b) for b in ((-9, -0.6, -3, 0.6), (3, -0.6, 9, 0.6), (-0.6, 3, 0.6, 9))]
)


@pytest.mark.parametrize("thickness", [0.8, 2.0])
def test_shell_agrees_with_the_solid_on_a_plate_held_by_narrow_bars(thickness: float) -> None:
    case = Case.of(Pressure(1e-4))
    model = prepare(Part(BARS, Plane(thickness)), case, MeshSize(1.2, 0.6, 0.3, 0.02))
    found = check(model, case)
    assert found.deflection_ratio == pytest.approx(1, abs=0.03)
    assert found.stress_ratio == pytest.approx(1, abs=0.1)
    assert found.unknowns > 2.9 * np.count_nonzero(~model.fixed)
