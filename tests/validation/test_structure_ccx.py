"""A second opinion: CalculiX (Debian package calculix-ccx), 15-node wedges on the same triangles."""

from dataclasses import replace

import numpy as np
import pytest
from shapely.geometry import box

from perfqr_cad.structure import Case, Part, Pressure, Weight, calculix
from perfqr_cad.structure.analysis import prepare
from perfqr_cad.structure.elements import mindlin_shell as shell
from perfqr_cad.structure.elements.assembly import System
from perfqr_cad.structure.elements.solvers import factorise
from perfqr_cad.structure.elements.wedge import LAYERS, layered, stiffness, stresses
from perfqr_cad.structure.mesh.seeding import MeshSize
from perfqr_cad.structure.mesh.triangle import Floats
from perfqr_cad.structure.shell_model import Model
from perfqr_cad.structure.solid_check import check
from perfqr_cad.surface import Cylinder, Placement, Plane

pytestmark = pytest.mark.skipif(
    not calculix.installed(), reason="CalculiX is not installed: apt-get install calculix-ccx"
)
PRESSURE_MPA = 1e-4
PART = box(-12, -12, 12, 12)
for hole in ((-9, -9, -1, -1), (1, -9, 9, -1), (-9, 1, -1, 9), (1, 1, 9, 9)):
    PART = PART.difference(box(*hole))


def part(placement: Placement) -> Model:
    as_shell = Case.of(Weight((0.0, 0.0, -1.0)))
    return prepare(Part(PART, placement), as_shell, MeshSize(0.8, 0.6, 0.2, 0.02))


def wedges(model: Model) -> tuple[Floats, Floats]:
    """Our solid: displacements (3, n, 3) and corner stresses of the front (m, 3, 5)."""
    t, count = model.wall_mm, len(model.mesh.nodes)
    matrices = stiffness(model.positions, model.frames[:, 2], model.mesh.elements, t, model.material)
    held = np.tile(np.repeat(model.fixed.reshape(count, -1)[:, 0], 3), LAYERS)
    system = System(layered(model.mesh.elements, count), 3, matrices, held)
    forces = np.zeros((LAYERS, count, 3))
    front = model.positions + 0.5 * t * model.frames[:, 2]
    forces[2] = shell.normal_load(front, model.mesh.elements, -PRESSURE_MPA).reshape(count, -1)[:, :3]
    answer = factorise(system.lower()).solve(np.where(held, 0.0, forces.ravel()))
    stress = stresses(
        (model.positions, model.frames[:, 2]), model.frames, model.mesh.elements, t, model.material, answer
    )
    return answer.reshape(LAYERS, count, 3), stress[:, :, 2]


@pytest.mark.parametrize("placement", [Plane(2.0), Cylinder(40.0, 2.0)])
def test_deflection_agrees(placement: Placement) -> None:
    model = part(placement)
    theirs = np.linalg.norm(calculix.solve(model, PRESSURE_MPA).displacement, axis=1).max()
    assert np.linalg.norm(wedges(model)[0], axis=2).max() == pytest.approx(theirs, rel=0.01)
    assert check(model, Case.of(Pressure(PRESSURE_MPA))).shell_deflection_mm == pytest.approx(
        theirs, rel=0.03
    )


def test_stress_agrees_in_a_web() -> None:
    model = part(Plane(2.0))
    count, corners = len(model.mesh.nodes), model.mesh.corners
    x, y = model.mesh.nodes[:corners].T
    web = np.flatnonzero((np.abs(y) < 0.4) & (np.abs(x - 5.0) < 2.5))
    theirs = calculix.solve(model, PRESSURE_MPA).stress[count + web, 0]
    front = wedges(model)[1]
    ours = np.array([front[model.mesh.elements[:, :3] == node][:, 0].mean() for node in web])
    assert ours == pytest.approx(theirs, abs=0.02 * np.abs(theirs).max())


def test_another_modulus_would_be_noticed() -> None:
    model = part(Plane(2.0))
    softer = replace(model, material=replace(model.material, e_mpa=0.9 * model.material.e_mpa))
    theirs = np.linalg.norm(calculix.solve(softer, PRESSURE_MPA).displacement, axis=1).max()
    assert np.linalg.norm(wedges(model)[0], axis=2).max() != pytest.approx(theirs, rel=0.01)
