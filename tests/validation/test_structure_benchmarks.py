"""The shell and plate elements against published benchmarks.

Sources: Timoshenko & Woinowsky-Krieger, *Theory of Plates and Shells* (clamped square, table 35; clamped
disc, §16); Kirsch 1898 (stress at a hole); MacNeal & Harder, *Finite Elements in Analysis and Design* 1, 1985
(Scordelis-Lo roof, pinched hemisphere with an 18° hole); Belytschko et al. 1985 (pinched cylinder); NAFEMS,
*The Standard NAFEMS Benchmarks*, 1990 (LE1, LE3).
"""

from collections.abc import Callable

import numpy as np
import pytest
from shapely.geometry import Point, Polygon, box

from perfqr_cad.structure import Case, Material, Part, Pressure, analyse_part
from perfqr_cad.structure.elements import mindlin_shell as shell
from perfqr_cad.structure.elements.assembly import System
from perfqr_cad.structure.elements.mindlin_plate import Section
from perfqr_cad.structure.elements.solvers import factorise
from perfqr_cad.structure.mesh.gmsh_mesher import triangulate
from perfqr_cad.structure.mesh.seeding import MeshSize
from perfqr_cad.structure.mesh.triangle import Floats, Ints, Mesh, quadratic
from perfqr_cad.surface import Plane

STUFF = Material("benchmark", 1e4, 0.3, 100.0, 1000.0, "arbitrary")
KAPPA = 5 / 6  # the solid section all these references assume


def bending(thickness: float) -> float:
    return STUFF.e_mpa * thickness**3 / 12 / (1 - STUFF.nu**2)


def deflection(polygon: Polygon, thickness: float, size: float, support: str = "clamped") -> float:
    case = Case.of(Pressure(1e-6), material=STUFF, support=support, nozzle_mm=0.1)
    size_mm = MeshSize.graded(size, case.nozzle_mm)
    return analyse_part(Part(polygon, Plane(thickness)), case, size_mm).max_deflection_mm


def clamped_square(thickness: float = 0.5, size: float = 2.5) -> float:
    return deflection(box(-50, -50, 50, 50), thickness, size) / (
        0.00126532 * 1e-6 * 100**4 / bending(thickness)
    )


def clamped_disc(support: str = "clamped", thickness: float = 0.5) -> float:
    disc = Point(0, 0).buffer(50, quad_segs=32)
    return deflection(disc, thickness, 4.0, support) / (1e-6 * 50**4 / 64 / bending(thickness))


def test_clamped_square() -> None:
    assert clamped_square() == pytest.approx(1, abs=0.005)
    # A plate as thick as a module bends by shear too, which the reference leaves out.
    assert clamped_square(thickness=10.0) != pytest.approx(1, abs=0.005)


def test_clamped_disc() -> None:
    assert clamped_disc() == pytest.approx(1, abs=0.005)
    assert clamped_disc("simple") != pytest.approx(1, abs=0.005)


# --- shells ----------------------------------------------------------------------------------------------

Map = Callable[[Floats], tuple[Floats, Floats]]  # parameters (n, 2) to positions and unit normals (n, 3)


def unit_square(n: int) -> Mesh:
    x, y = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1), indexing="ij")
    i = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    a, b, c, d = i[:-1, :-1].ravel(), i[1:, :-1].ravel(), i[1:, 1:].ravel(), i[:-1, 1:].ravel()
    return quadratic(np.c_[x.ravel(), y.ravel()], np.r_[np.c_[a, b, c], np.c_[a, c, d]])


def frames(normals: Floats) -> Floats:
    """Frames with these normals; the first axis is arbitrary."""
    other = np.where(np.abs(normals[:, :1]) < 0.9, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    e2 = np.cross(normals, other)
    e2 /= np.linalg.norm(e2, axis=1)[:, None]
    return np.stack([np.cross(e2, normals), e2, normals], axis=1)


def solve(mesh: Mesh, surface: Map, section: Section, forces: Floats, fixed: dict[int, Floats]) -> Floats:
    """Displacements (n, 6); `fixed` maps each unknown 0-5 to flags (n,)."""
    positions, normals = surface(mesh.nodes)
    held = np.zeros((len(positions), shell.DOFS), bool)
    for dof, where in fixed.items():
        held[:, dof] |= where
    matrices = shell.stiffness(positions, frames(normals), mesh.elements, section)
    system = System(mesh.elements, shell.DOFS, matrices, held.ravel())
    return factorise(system.lower()).solve(np.where(held.ravel(), 0.0, forces)).reshape(-1, shell.DOFS)


def nearest(mesh: Mesh, x: float, y: float) -> int:
    return int(np.argmin(np.hypot(mesh.nodes[:, 0] - x, mesh.nodes[:, 1] - y)))


def cylinder(radius: float, angle: float, length: float) -> Map:
    def surface(uv: Floats) -> tuple[Floats, Floats]:
        a, y = angle * uv[:, 0], length * uv[:, 1]
        normals = np.c_[np.sin(a), 0 * a, np.cos(a)]
        return radius * normals + np.c_[0 * y, y, 0 * y], normals

    return surface


def sides(mesh: Mesh) -> tuple[Floats, Floats, Floats, Floats]:
    u, v = mesh.nodes.T
    return u < 1e-9, u > 1 - 1e-9, v < 1e-9, v > 1 - 1e-9


def scordelis_lo(n: int) -> float:
    """Deflection at the middle of the free edge over 0.3024."""
    mesh, surface = unit_square(n), cylinder(25.0, np.radians(40), 25.0)
    crown, _, end, middle = sides(mesh)
    positions, _ = surface(mesh.nodes)
    forces = shell.body_load(positions, mesh.elements, np.array([0.0, 0.0, -90.0]))
    fixed = {0: end | crown, 1: middle, 2: end, 3: middle, 4: crown, 5: middle | crown}
    u = solve(mesh, surface, Section(0.25, 4.32e8, 0.0, KAPPA), forces, fixed)
    return -u[nearest(mesh, 1, 1), 2] / 0.3024


def pinched_cylinder(n: int) -> float:
    """Deflection under the load over 1.8248e-5."""
    mesh, surface = unit_square(n), cylinder(300.0, np.pi / 2, 300.0)
    top, side, end, middle = sides(mesh)
    forces = np.zeros((len(mesh.nodes), 6))
    loaded = nearest(mesh, 0, 1)
    forces[loaded, 2] = -0.25
    fixed = {0: end | top, 1: middle, 2: end | side, 3: middle | side, 4: top | side, 5: middle | top}
    u = solve(mesh, surface, Section(3.0, 3e6, 0.3, KAPPA), forces.ravel(), fixed)
    return -u[loaded, 2] / 1.8248e-5


def hemisphere(n: int) -> float:
    """Radial displacement under the outward load over 0.0935."""
    mesh = unit_square(n)

    def surface(uv: Floats) -> tuple[Floats, Floats]:
        a, b = np.pi / 2 * uv[:, 0], np.radians(72) * uv[:, 1]
        normals = np.c_[np.cos(b) * np.cos(a), np.cos(b) * np.sin(a), np.sin(b)]
        return 10.0 * normals, normals

    along_x, along_y, _, _ = sides(mesh)
    out, inward = nearest(mesh, 0, 0), nearest(mesh, 1, 0)
    forces = np.zeros((len(mesh.nodes), 6))
    forces[out, 0], forces[inward, 1] = 1.0, -1.0
    point = np.arange(len(mesh.nodes)) == out
    fixed = {0: along_y, 1: along_x, 2: point, 3: along_x, 4: along_y, 5: along_x | along_y}
    u = solve(mesh, surface, Section(0.04, 6.825e7, 0.3, KAPPA), forces.ravel(), fixed)
    return u[out, 0] / 0.0935


def octant(n: int) -> tuple[Mesh, Map]:
    """An eighth of the sphere of radius 10 over barycentric coordinates."""
    corners = [(i, j) for i in range(n + 1) for j in range(n + 1 - i)]
    at = {ij: k for k, ij in enumerate(corners)}
    up = [(at[i, j], at[i + 1, j], at[i, j + 1]) for i in range(n) for j in range(n - i)]
    down = [(at[i + 1, j], at[i + 1, j + 1], at[i, j + 1]) for i in range(n) for j in range(n - i - 1)]

    def surface(uv: Floats) -> tuple[Floats, Floats]:
        y = np.c_[uv, 1 - uv.sum(axis=1)]
        normals = y / np.linalg.norm(y, axis=1)[:, None]
        return 10.0 * normals, normals

    return quadratic(np.array(corners, float) / n, np.array(up + down)), surface


def le3(n: int) -> float:
    """NAFEMS LE3: displacement at A of the point-loaded hemisphere, over 0.185 m."""
    mesh, surface = octant(n)
    a, b, top = nearest(mesh, 1, 0), nearest(mesh, 0, 1), nearest(mesh, 0, 0)
    forces = np.zeros((len(mesh.nodes), 6))
    forces[a, 0], forces[b, 1] = 2e3, -2e3
    on_y0, on_x0 = mesh.nodes[:, 1] < 1e-9, mesh.nodes[:, 0] < 1e-9
    pole = np.arange(len(mesh.nodes)) == top
    fixed = {0: on_x0 | pole, 1: on_y0 | pole, 2: pole, 3: on_y0, 4: on_x0, 5: on_y0 | on_x0}
    u = solve(mesh, surface, Section(0.04, 68.25e9, 0.3, KAPPA), forces.ravel(), fixed)
    return u[a, 0] / 0.185


@pytest.mark.parametrize(
    ("case", "fine", "coarse", "tolerance"),
    [
        (scordelis_lo, 16, 1, 0.005),
        (pinched_cylinder, 32, 4, 0.01),
        (hemisphere, 32, 4, 0.01),
        (le3, 48, 6, 0.01),
    ],
)
def test_shell(case: Callable[[int], float], fine: int, coarse: int, tolerance: float) -> None:
    assert case(fine) == pytest.approx(1, abs=tolerance)
    assert case(coarse) != pytest.approx(1, abs=tolerance)


# --- membrane stress: the shell without bending -----------------------------------------------------------


def membrane(mesh: Mesh, section: Section, traction: Callable[[Floats], Floats], loaded: Ints) -> Floats:
    """Corner stresses (m, 3, 5) of a quarter, symmetric about both axes, under edge tractions."""
    flat = np.c_[mesh.nodes, np.zeros(len(mesh.nodes))]
    axes = np.tile(np.eye(3), (len(flat), 1, 1))
    forces = np.zeros((len(flat), 6))
    for i, j, k in loaded:
        length = np.linalg.norm(mesh.nodes[i] - mesh.nodes[j])
        for node, share in ((i, 1 / 6), (j, 1 / 6), (k, 4 / 6)):
            forces[node, :2] += share * length * traction(mesh.nodes[k])
    x, y = mesh.nodes.T
    held = np.zeros((len(flat), 6), bool)
    held[x < 1e-9, 0], held[y < 1e-9, 1], held[:, 2:5] = True, True, True
    matrices = shell.stiffness(flat, axes, mesh.elements, section)
    system = System(mesh.elements, shell.DOFS, matrices, held.ravel())
    u = factorise(system.lower()).solve(np.where(held, 0.0, forces).ravel())
    return shell.stresses(flat, axes, mesh.elements, u, section)[:, :, 1]


def at_node(mesh: Mesh, stress: Floats, component: int, x: float, y: float) -> float:
    node = nearest(mesh, x, y)
    assert np.allclose(mesh.nodes[node], (x, y), atol=1e-6)
    return float(stress[mesh.elements[:, :3] == node][:, component].mean())


def kirsch(size: float) -> float:
    """Stress at the top of a small hole over three times the remote tension (width 40 diameters)."""
    away = np.geomspace(1.0 + size, 40.0, round(8 / size**0.5))  # edges grow away from the hole
    outline = [*np.c_[away, 0 * away], (40, 40), *np.c_[0 * away, away][::-1]]
    angle = np.linspace(np.pi / 2, 0, round(1.5 / size) + 1)
    mesh = triangulate(Polygon([*outline, *np.c_[np.cos(angle), np.sin(angle)].round(12)]), 2.0)
    edge = mesh.boundary[(mesh.nodes[mesh.boundary][..., 0] > 40 - 1e-6).all(axis=1)]
    stress = membrane(mesh, Section(1.0, 1.0, 0.3, KAPPA), lambda _: np.array([1.0, 0.0]), edge)
    return at_node(mesh, stress, 0, 0.0, 1.0) / 3.0


def le1(size: float) -> float:
    """NAFEMS LE1, elliptic membrane under 10 MPa outward on its outer side: σyy at D over 92.7 MPa."""
    section = Section(0.1, 210e3, 0.3, KAPPA)
    t = np.linspace(0, np.pi / 2, round(6 / size))
    outer = np.c_[3.25 * np.cos(t), 2.75 * np.sin(t)]
    inner = np.c_[2 * np.cos(t), np.sin(t)][::-1]
    mesh = triangulate(Polygon(np.r_[outer, inner]), size)
    ends = mesh.nodes[mesh.boundary]
    on_outer = (ends[..., 0] / 3.25) ** 2 + (ends[..., 1] / 2.75) ** 2 > 1 - 0.05 * size
    straight = (ends[..., 0] < 1e-9).all(axis=1) | (ends[..., 1] < 1e-9).all(axis=1)
    edge = mesh.boundary[on_outer.all(axis=1) & ~straight]

    def pressure(at: Floats) -> Floats:
        normal = at / np.array([3.25, 2.75]) ** 2
        return 10.0 * section.thickness_mm * normal / np.linalg.norm(normal)

    stress = membrane(mesh, section, pressure, edge)
    return at_node(mesh, stress, 1, 2.0, 0.0) / 92.7


@pytest.mark.parametrize(("case", "fine", "coarse"), [(kirsch, 0.05, 0.5), (le1, 0.08, 0.6)])
def test_membrane_stress(case: Callable[[float], float], fine: float, coarse: float) -> None:
    assert case(fine) == pytest.approx(1, abs=0.01)
    assert case(coarse) != pytest.approx(1, abs=0.01)
