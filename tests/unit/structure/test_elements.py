"""Patch tests, rigid motions and quadrature of the plate and shell elements."""

import numpy as np
import pytest
import scipy.sparse as sp

from perfqr_cad.structure.elements import mindlin_plate as plate
from perfqr_cad.structure.elements import mindlin_shell as shell
from perfqr_cad.structure.elements.assembly import System, lower_triangle
from perfqr_cad.structure.elements.mindlin_plate import Section
from perfqr_cad.structure.elements.solvers import factorise
from perfqr_cad.structure.mesh.triangle import (
    NODES_REF,
    SIX_POINTS,
    SIX_WEIGHTS,
    THREE_POINTS,
    THREE_WEIGHTS,
    Floats,
    Mesh,
    gradients,
    quadratic,
    shapes,
)

SECTION = Section(2.0, 3500.0, 0.36, 1.0)


def patch() -> Mesh:
    """An irregular patch of a square with four inner corners (MacNeal & Harder 1985)."""
    corners = np.array([[0, 0], [10, 0], [10, 10], [0, 10], [2, 2], [8, 3], [7, 8], [3, 7]], float)
    quads = [(0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7), (4, 5, 6, 7)]
    return quadratic(corners, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]))


def imposed(mesh: Mesh, matrices: Floats, exact: Floats, inner: bool = True) -> Floats:
    """Solve with the exact motion (n, d) imposed on the outline and nothing on the inside."""
    dofs = exact.shape[1]
    held = np.zeros((len(mesh.nodes), dofs), bool)
    held[np.unique(mesh.boundary)] = True
    system = System(mesh.elements, dofs, matrices, held.ravel())
    known = np.where(held, exact, 0.0).ravel()
    right = np.where(held.ravel(), known, -system.internal_forces(known))
    return factorise(system.lower()).solve(right).reshape(-1, dofs)


def flat_shell(mesh: Mesh) -> tuple[Floats, Floats]:
    return np.c_[mesh.nodes, np.zeros(len(mesh.nodes))], np.tile(np.eye(3), (len(mesh.nodes), 1, 1))


def bent(mesh: Mesh) -> Floats:
    """Constant curvature: w = x²/2 + xy - y², β = ∇w."""
    x, y = mesh.nodes.T
    return np.stack([x**2 / 2 + x * y - y**2, x + y, x - 2 * y], axis=1)


def sheared(mesh: Mesh) -> Floats:
    """Constant transverse shear: w = 0.3 x - 0.2 y, β = 0."""
    x, y = mesh.nodes.T
    return np.stack([0.3 * x - 0.2 * y, 0 * x, 0 * x], axis=1)


@pytest.mark.parametrize("state", [bent, sheared])
def test_plate_passes_the_patch_test(state: object) -> None:
    mesh = patch()
    exact = state(mesh)  # type: ignore[operator]
    if state is sheared:  # equilibrium of moments needs the rotations held
        strain = plate.gauss_strains(mesh, exact.ravel())
        assert strain[..., 3:] == pytest.approx(np.broadcast_to([0.3, -0.2], (*strain.shape[:2], 2)))
        return
    answer = imposed(mesh, plate.stiffness(mesh, SECTION), exact)
    assert answer == pytest.approx(exact, abs=1e-9)
    strain = plate.gauss_strains(mesh, answer.ravel())
    assert strain[..., :3] == pytest.approx(np.broadcast_to([1.0, -2.0, 2.0], (*strain.shape[:2], 3)))


def test_patch_test_notices_a_wrong_element() -> None:
    mesh = patch()
    matrices = plate.stiffness(mesh, SECTION)
    matrices[0] *= 1.01
    assert imposed(mesh, matrices, bent(mesh)) != pytest.approx(bent(mesh), abs=1e-9)


def test_shell_passes_the_membrane_patch_test() -> None:
    mesh = patch()
    positions, axes = flat_shell(mesh)
    x, y = mesh.nodes.T
    exact = np.zeros((len(x), 6))
    exact[:, 0], exact[:, 1] = 1e-3 * (x + 0.5 * y), 1e-3 * (y + 0.5 * x)
    answer = imposed(mesh, shell.stiffness(positions, axes, mesh.elements, SECTION), exact)
    assert answer == pytest.approx(exact, abs=1e-12)
    stress = shell.stresses(positions, axes, mesh.elements, answer.ravel(), SECTION)
    c = 1e-3 * SECTION.e_mpa / (1 - SECTION.nu)
    expected = [c, c, 1e-3 * SECTION.e_mpa / (2 * (1 + SECTION.nu)), 0, 0]
    assert stress == pytest.approx(np.broadcast_to(expected, stress.shape), abs=1e-9)


def test_shell_passes_the_bending_patch_test() -> None:
    mesh = patch()
    positions, axes = flat_shell(mesh)
    w, bx, by = bent(mesh).T
    zero = 0 * w
    # A normal turned by θ follows the slope: θx = ∂w/∂y, θy = -∂w/∂x.
    exact = np.stack([zero, zero, w, by, -bx, zero], axis=1)
    answer = imposed(mesh, shell.stiffness(positions, axes, mesh.elements, SECTION), exact)
    assert answer == pytest.approx(exact, abs=1e-8)
    flat = plate.stresses(mesh, bent(mesh).ravel(), SECTION)
    curved = shell.stresses(positions, axes, mesh.elements, answer.ravel(), SECTION)
    assert curved[:, :, 2] == pytest.approx(flat[:, :, 0], abs=1e-6)


def rigid_motions(positions: Floats) -> list[Floats]:
    """Three translations and three small rotations (n, 6)."""
    moves = []
    for axis in np.eye(3):
        moves.append(np.c_[np.tile(axis, (len(positions), 1)), np.zeros_like(positions)])
        moves.append(np.c_[np.cross(axis, positions), np.tile(axis, (len(positions), 1))])
    return moves


def test_rigid_motions_of_a_curved_shell_have_no_energy() -> None:
    mesh = patch()
    angle = mesh.nodes[:, 0] / 15.0
    normals = np.c_[np.sin(angle), 0 * angle, np.cos(angle)]
    positions = 15.0 * normals + np.c_[0 * angle, mesh.nodes[:, 1], 0 * angle]
    frames = np.stack(
        [np.c_[np.cos(angle), 0 * angle, -np.sin(angle)], np.tile([0.0, 1, 0], (len(angle), 1)), normals], 1
    )
    matrices = shell.stiffness(positions, frames, mesh.elements, SECTION)
    system = System(mesh.elements, 6, matrices, np.zeros(6 * len(positions), bool))
    stretched = np.c_[positions * [1, 0, 0], np.zeros_like(positions)]
    scale = stretched.ravel() @ system.internal_forces(stretched.ravel())
    for move in rigid_motions(positions):
        assert abs(move.ravel() @ system.internal_forces(move.ravel())) < 1e-9 * scale


def test_plate_element_has_three_rigid_motions_and_no_more() -> None:
    mesh = quadratic(np.array([[0.0, 0], [3, 1], [1, 4]]), np.array([[0, 1, 2]]))
    values = np.linalg.eigvalsh(plate.stiffness(mesh, SECTION)[0])
    assert (values > 1e-9 * values.max()).sum() == 15


def test_quadrature_is_exact_to_its_degree() -> None:
    for points, weights, degree in ((THREE_POINTS, THREE_WEIGHTS, 2), (SIX_POINTS, SIX_WEIGHTS, 4)):
        for power in range(degree + 1):
            # ∫ ξ^p over the triangle = 1 / (p + 1)(p + 2)
            assert weights @ points[:, 0] ** power == pytest.approx(1 / ((power + 1) * (power + 2)))
    assert THREE_WEIGHTS @ THREE_POINTS[:, 0] ** 4 != pytest.approx(1 / 30)


def test_shapes_are_one_at_their_node_and_slopes_match_differences() -> None:
    assert shapes(NODES_REF) == pytest.approx(np.eye(6))
    step = 1e-6
    for axis in range(2):
        shift = np.eye(2)[axis] * step
        difference = (shapes(SIX_POINTS + shift) - shapes(SIX_POINTS - shift)) / (2 * step)
        assert gradients(SIX_POINTS)[:, axis] == pytest.approx(difference, abs=1e-8)


def test_assembly_agrees_with_adding_element_by_element() -> None:
    mesh = patch()
    matrices = plate.stiffness(mesh, SECTION)
    whole = sp.lil_matrix((3 * len(mesh.nodes),) * 2)
    for nodes, matrix in zip(mesh.elements, matrices, strict=True):
        index = (nodes[:, None] * 3 + np.arange(3)).ravel()
        whole[np.ix_(index, index)] += matrix
    lower = lower_triangle([(mesh.elements, matrices)], 3, np.zeros(whole.shape[0], bool))
    assert sp.tril(lower).toarray() == pytest.approx(np.tril(whole.toarray()))
