"""The flat Reissner-Mindlin plate on six-node triangles.

Unknowns: the deflection w, positive along the normal, and the rotations (βx, βy) of the normal; shear strain
is ∇w - β. Three-point integration of all terms leaves the element free of shear locking and just of full rank
(15 strains for 18 unknowns less 3 rigid motions).

Straight edges make every stiffness term a product of entries of the inverse Jacobian and constants of the
reference triangle, so all element matrices come from one matrix product.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from itertools import product

import numpy as np

from perfqr_cad.structure.mesh.triangle import (
    CENTRE,
    FROM_GAUSS_TO_CORNERS,
    THREE_POINTS,
    THREE_WEIGHTS,
    Floats,
    Ints,
    Mesh,
    gradients,
    shapes,
)

DOFS = 3
W, BX, BY = range(DOFS)


@dataclass(frozen=True)
class Section:
    """Thickness in mm, one or one for each element, modulus in MPa, Poisson's ratio, shear correction κ.

    Webs whose walls flare have less material than their front shows, one figure or one for each element:
    `bending_share` of its stiffness and `area_share` of its area are left, and its largest stress is
    `stress_share` of what the remaining stiffness gives at half the thickness.
    """

    thickness_mm: float | Floats
    e_mpa: float
    nu: float
    kappa: float
    bending_share: float | Floats = 1.0
    area_share: float | Floats = 1.0
    stress_share: float | Floats = 1.0

    def of(self, elements: Ints | slice) -> Section:
        """That of some elements, for which every figure has one of its own."""
        return replace(
            self,
            thickness_mm=np.asarray(self.thickness_mm)[elements],
            bending_share=np.asarray(self.bending_share)[elements],
            area_share=np.asarray(self.area_share)[elements],
            stress_share=np.asarray(self.stress_share)[elements],
        )

    @property
    def bending(self) -> float | Floats:
        """Plate stiffness D = E t³ / 12(1 - ν²) in N·mm."""
        return self.bending_share * self.e_mpa * self.thickness_mm**3 / (12.0 * (1.0 - self.nu**2))

    @property
    def shear(self) -> float | Floats:
        """Transverse shear stiffness κ G t in N/mm."""
        return self.area_share * self.kappa * self.shear_mpa * self.thickness_mm

    @property
    def shear_mpa(self) -> float:
        """Shear modulus G in MPa."""
        return self.e_mpa / (2.0 * (1.0 + self.nu))

    @property
    def plane_stress(self) -> Floats:
        """The plane-stress elasticity matrix in MPa (3, 3) for (εxx, εyy, γxy)."""
        nu = self.nu
        return self.e_mpa / (1 - nu**2) * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])


def stiffness(mesh: Mesh, section: Section) -> Floats:
    """Element stiffness matrices (m, 18, 18), unknowns node by node (w, βx, βy)."""
    g = mesh.inverse_jacobian.reshape(-1, 4)  # (x,ξ) (x,η) (y,ξ) (y,η)
    twice_area = 2.0 * mesh.area_mm2[:, None]
    squares = (g[:, :, None] * g[:, None, :]).reshape(-1, 16)
    coefficients = np.hstack([squares, g, np.ones_like(twice_area)]) * twice_area
    bending, shear = _reference(section.nu)
    stiff = np.broadcast_to(section.bending, len(g))[:, None] * (coefficients @ bending)
    stiff += np.broadcast_to(section.shear, len(g))[:, None] * (coefficients @ shear)
    return stiff.reshape(-1, 6 * DOFS, 6 * DOFS)


@cache
def _reference(nu: float) -> Floats:
    """(2, 21, 324): what each product of Jacobian entries adds to the element matrix, for unit stiffness in
    bending and in shear.

    Rows 0-15 stand for g[a,p] g[b,q], rows 16-19 for g[a,p], row 20 for 1; a, b run over x, y and p, q over
    ξ, η.
    """
    n, dn, weights = shapes(THREE_POINTS), gradients(THREE_POINTS), THREE_WEIGHTS
    both = np.einsum("g,gpi,gqj->pqij", weights, dn, dn)
    one = np.einsum("g,gpi,gj->pij", weights, dn, n)
    none = np.einsum("g,gi,gj->ij", weights, n, n)
    bending, shear = tables = np.zeros((2, 21, 6, DOFS, 6, DOFS))
    for (a, p), (b, q) in product(product(range(2), repeat=2), repeat=2):
        row = (2 * a + p) * 4 + 2 * b + q
        if a == b:
            other = 1 - a
            shear[row, :, W, :, W] += both[p, q]
            bending[row, :, 1 + a, :, 1 + a] += both[p, q]
            bending[row, :, 1 + other, :, 1 + other] += (1 - nu) / 2 * both[p, q]
        else:
            bending[row, :, 1 + a, :, 1 + b] += nu * both[p, q]
            bending[row, :, 1 + b, :, 1 + a] += (1 - nu) / 2 * both[p, q]
    for a, p in product(range(2), repeat=2):
        shear[16 + 2 * a + p, :, W, :, 1 + a] -= one[p]
        shear[16 + 2 * a + p, :, 1 + a, :, W] -= one[p].T
    for a in range(2):
        shear[20, :, 1 + a, :, 1 + a] += none
    return tables.reshape(2, 21, -1)


def normal_load(mesh: Mesh, pressure_mpa: Floats | float) -> Floats:
    """Nodal forces (n·3,) of a pressure along +w, one value for all elements or one per element.

    On a straight triangle the consistent forces of a uniform pressure sit on the three middle nodes.
    """
    share = np.broadcast_to(pressure_mpa * mesh.area_mm2 / 3.0, (len(mesh.elements),))
    forces = np.zeros(len(mesh.nodes) * DOFS)
    forces[W::DOFS] = np.bincount(
        mesh.elements[:, 3:].ravel(), np.repeat(share, 3), minlength=len(mesh.nodes)
    )
    return forces


def gauss_strains(mesh: Mesh, solution: Floats) -> Floats:
    """Curvatures (κxx, κyy, 2κxy) and shear strains (γxz, γyz) at the Gauss points: (m, 3, 5)."""
    u = solution.reshape(-1, DOFS)[mesh.elements]
    slopes = np.einsum("map,gpi,mic->mgac", mesh.inverse_jacobian, gradients(THREE_POINTS), u, optimize=True)
    beta = np.einsum("gi,mic->mgc", shapes(THREE_POINTS), u[:, :, 1:])
    return np.stack(
        [
            slopes[..., 0, BX],
            slopes[..., 1, BY],
            slopes[..., 0, BY] + slopes[..., 1, BX],
            slopes[..., 0, W] - beta[..., 0],
            slopes[..., 1, W] - beta[..., 1],
        ],
        axis=-1,
    )


def centre_operator(mesh: Mesh, section: Section) -> Floats:
    """Stress at the element centres per unknown of the element: (m, 5, 18), as the layers of `stresses` are.

    Rows σxx, σyy, τxy of the face, then τxz, τyz of the middle.
    """
    slope = mesh.inverse_jacobian @ gradients(CENTRE)[0]
    value = shapes(CENTRE)[0]
    strain = np.zeros((len(slope), 5, 6, DOFS))
    strain[:, 0, :, BX] = strain[:, 2, :, BY] = slope[:, 0]
    strain[:, 1, :, BY] = strain[:, 2, :, BX] = slope[:, 1]
    strain[:, 3, :, W], strain[:, 4, :, W] = slope[:, 0], slope[:, 1]
    strain[:, 3, :, BX] = strain[:, 4, :, BY] = -value
    thickness = np.broadcast_to(section.thickness_mm, len(slope))[:, None, None]
    out = strain.reshape(len(slope), 5, -1)
    share = np.broadcast_to(section.stress_share, len(slope))[:, None, None]
    out[:, :3] = -0.5 * share * thickness * (section.plane_stress @ out[:, :3])
    out[:, 3:] *= 1.5 * section.kappa * section.shear_mpa
    return out


def stresses(mesh: Mesh, solution: Floats, section: Section) -> Floats:
    """(σxx, σyy, τxy, τxz, τyz) in MPa at the corners of each element: (m, 3, 2, 5).

    The third axis is the face stress (bending only; shear vanishes there) and the middle-plane stress (shear
    only: 3/2 of its mean, the parabola of an elastic section). The two faces mirror each other.
    """
    strain = gauss_strains(mesh, solution)
    out = np.zeros((len(strain), 3, 2, 5))
    # With γ = ∇w - β the displacement across the thickness is -zβ, hence the sign at the +z face.
    thickness = np.broadcast_to(section.stress_share * section.thickness_mm, len(strain))[:, None, None]
    face = -0.5 * thickness * strain[..., :3] @ section.plane_stress
    shear = 1.5 * section.kappa * section.shear_mpa * strain[..., 3:]
    out[:, :, 0, :3] = np.einsum("ng,mgc->mnc", FROM_GAUSS_TO_CORNERS, face)
    out[:, :, 1, 3:] = np.einsum("ng,mgc->mnc", FROM_GAUSS_TO_CORNERS, shear)
    return out
