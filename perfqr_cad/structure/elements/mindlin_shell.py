"""The curved Reissner-Mindlin shell on six-node triangles: membrane, bending and drilling, 6 unknowns a node.

A degenerated solid (Ahmad, Irons & Zienkiewicz 1970): straight normals, zero normal stress, three points in
the plane and two through the thickness. The rotation about the normal is tied to the rotation of the surface
itself, θ·n = ½(∂u2/∂x1 - ∂u1/∂x2) (Hughes & Brezzi 1989), so that a rigid turn costs no energy.
"""

from __future__ import annotations

import numpy as np

from perfqr_cad.errors import AnalysisError
from perfqr_cad.structure.elements.mindlin_plate import Section
from perfqr_cad.structure.mesh.triangle import (
    CENTRE,
    FROM_GAUSS_TO_CORNERS,
    SIX_POINTS,
    SIX_WEIGHTS,
    THREE_POINTS,
    THREE_WEIGHTS,
    Floats,
    Ints,
    gradients,
    shapes,
)

DOFS = 6
ROTATIONS = slice(3, 6)
DRILLING_FRACTION = 1e-3  # of the membrane shear stiffness G t
_THROUGH = 1.0 / np.sqrt(3.0)  # two Gauss points, each of weight 1
_CHUNK = 10_000  # elements at a time: bounds the memory of the strain matrices


def stiffness(positions: Floats, frames: Floats, elements: Ints, section: Section) -> Floats:
    """Element stiffness matrices (m, 36, 36), unknowns node by node (u, θ) in space axes."""
    out = np.empty((len(elements), 6 * DOFS, 6 * DOFS))
    root = np.linalg.cholesky(_elasticity(section)).T
    thickness = np.broadcast_to(section.thickness_mm, len(elements))
    drilling = np.sqrt(DRILLING_FRACTION * section.shear_mpa * thickness)
    for start in range(0, len(elements), _CHUNK):
        part = slice(start, start + _CHUNK)
        x, n, t = positions[elements[part]], frames[elements[part], 2], thickness[part]
        drill = drilling[part, None, None]
        rows = []
        for point, weight in zip(THREE_POINTS, THREE_WEIGHTS, strict=True):
            for zeta in (-_THROUGH, _THROUGH):
                strain, volume, _ = strain_matrix(x, n, point, zeta, t)
                _require_unfolded(x, volume, t)
                rows.append(root @ strain * np.sqrt(weight * volume)[:, None, None])
        for point, weight in zip(SIX_POINTS, SIX_WEIGHTS, strict=True):
            twist, area = _drilling_row(x, n, point)
            rows.append(drill * twist * np.sqrt(weight * area)[:, None, None])
        stacked = np.concatenate(rows, axis=1)
        np.matmul(stacked.transpose(0, 2, 1), stacked, out=out[part])
    out *= np.broadcast_to(section.bending_share, len(elements))[:, None, None]
    return out


def _require_unfolded(x: Floats, volume: Floats, thickness_mm: Floats) -> None:
    folded = np.flatnonzero(~(volume > 0.0))
    if len(folded):
        at = ", ".join(f"{c:.1f}" for c in x[folded[0]].mean(axis=0))
        raise AnalysisError(
            f"the wall of {thickness_mm[folded[0]]:g} mm folds over itself near ({at}) mm, where it is"
            " curved more tightly: make it thinner or the surface flatter"
        )


def _elasticity(section: Section) -> Floats:
    """Elasticity (5, 5) in MPa for (εxx, εyy, γxy, γxz, γyz) with σzz = 0."""
    c = np.zeros((5, 5))
    c[:3, :3] = section.plane_stress
    c[3, 3] = c[4, 4] = section.kappa * section.shear_mpa
    return c


def strain_matrix(
    x: Floats, n: Floats, point: Floats, zeta: float, thickness_mm: float | Floats, axis: Floats | None = None
) -> tuple[Floats, Floats, Floats]:
    """Strains (m, 5, 36) in local axes at one point of each element, the volume Jacobian, the axes (m, 3, 3).

    `x`, `n` (m, 6, 3): nodes on the middle surface and unit normals; `zeta` in [-1, 1] through the thickness.
    `axis` (m, 3) turns the first local axis towards it; by default it follows ∂x/∂ξ.
    """
    half = 0.5 * np.broadcast_to(thickness_mm, len(x))[:, None, None]
    value, slope = shapes(point[None])[0], gradients(point[None])[0]
    layer = x + zeta * half * n
    g1, g2, g3 = slope[0] @ layer, slope[1] @ layer, value @ n * half[:, 0]
    axes = _local_axes(g1, g2, g1 if axis is None else axis)
    jacobian = np.stack([g1, g2, g3], axis=1)
    inverse = np.linalg.inv(jacobian)
    # Space gradients of N_i, and of ζ N_i which carries the rotations.
    by_space = inverse[:, :, :2] @ slope
    by_layer = zeta * by_space + inverse[:, :, 2:] * value
    grad_u, grad_r = axes @ by_space, axes @ by_layer * half
    lever = [np.cross(n, axes[:, None, a]) for a in range(3)]  # θ × n · e_a = θ · (n × e_a)
    b = np.zeros((len(x), 5, 6, DOFS))
    for row, (p, q) in enumerate(((0, 0), (1, 1), (0, 1), (0, 2), (1, 2))):
        for s, t in {(p, q), (q, p)}:
            b[:, row, :, :3] += grad_u[:, s, :, None] * axes[:, None, t]
            b[:, row, :, ROTATIONS] += grad_r[:, s, :, None] * lever[t]
    return b.reshape(len(x), 5, 6 * DOFS), np.linalg.det(jacobian), axes


def _local_axes(g1: Floats, g2: Floats, axis: Floats) -> Floats:
    e3 = _unit(np.cross(g1, g2))
    e2 = _unit(np.cross(e3, axis))
    return np.stack([np.cross(e2, e3), e2, e3], axis=1)


def _unit(vectors: Floats) -> Floats:
    return vectors / np.linalg.norm(vectors, axis=1)[:, None]


def _drilling_row(x: Floats, n: Floats, point: Floats) -> tuple[Floats, Floats]:
    """θ·n - ½(∂u2/∂x1 - ∂u1/∂x2) as a row (m, 1, 36), and the area Jacobian."""
    value, slope = shapes(point[None])[0], gradients(point[None])[0]
    g1, g2 = slope[0] @ x, slope[1] @ x
    normal = np.cross(g1, g2)
    area = np.linalg.norm(normal, axis=1)
    axes = _local_axes(g1, g2, g1)
    inverse = np.linalg.inv(np.stack([g1, g2, axes[:, 2]], axis=1))
    along = axes[:, :2] @ inverse[:, :, :2] @ slope
    row = np.zeros((len(x), 6, DOFS))
    row[:, :, :3] = 0.5 * (along[:, 1, :, None] * axes[:, None, 0] - along[:, 0, :, None] * axes[:, None, 1])
    row[:, :, ROTATIONS] = value[:, None] * axes[:, None, 2]
    return row.reshape(len(x), 1, -1), area


def areas(positions: Floats, elements: Ints) -> Floats:
    """Area of each curved element in mm²."""
    return np.linalg.norm(_area_vectors(positions[elements]), axis=2) @ SIX_WEIGHTS


def normal_load(positions: Floats, elements: Ints, pressure_mpa: Floats | float) -> Floats:
    """Nodal forces (n·6,) of a pressure along the element normals, one value or one for each element."""
    vectors = (
        _area_vectors(positions[elements]) * np.broadcast_to(pressure_mpa, (len(elements),))[:, None, None]
    )
    return _scatter(vectors, elements, len(positions))


def body_load(positions: Floats, elements: Ints, per_area: Floats) -> Floats:
    """Nodal forces (n·6,) of a load vector per middle area, one (3,) or one for each element (m, 3)."""
    size = np.linalg.norm(_area_vectors(positions[elements]), axis=2)
    vectors = np.broadcast_to(per_area, (len(elements), 3))
    return _scatter(size[..., None] * vectors[:, None], elements, len(positions))


def _area_vectors(x: Floats) -> Floats:
    """∂x/∂ξ × ∂x/∂η at the six quadrature points: (m, 6, 3)."""
    slope = np.einsum("gpi,mic->mgpc", gradients(SIX_POINTS), x)
    return np.cross(slope[:, :, 0], slope[:, :, 1])


def _scatter(at_points: Floats, elements: Ints, nodes: int) -> Floats:
    local = np.einsum("g,gi,mgc->mic", SIX_WEIGHTS, shapes(SIX_POINTS), at_points).reshape(-1, 3)
    forces = np.zeros((nodes, DOFS))
    for c in range(3):
        forces[:, c] = np.bincount(elements.ravel(), local[:, c], minlength=nodes)
    return forces.ravel()


def centre_operator(positions: Floats, frames: Floats, elements: Ints, section: Section) -> list[Floats]:
    """Stress at the element centres per unknown of the element, (m, 5, 36) for the back and for the front."""
    c = _elasticity(section)
    thickness = np.broadcast_to(section.thickness_mm, len(elements))
    x, n = positions[elements], frames[elements, 2]
    axis = frames[elements, 0].mean(axis=1)
    faces = []
    for zeta in (-1.0, 1.0):
        strain, _, _ = strain_matrix(x, n, CENTRE[0], zeta, thickness, axis)
        strain[:, 3:] = 0.0  # faces carry no transverse shear
        faces.append(np.broadcast_to(section.stress_share, len(elements))[:, None, None] * (c @ strain))
    return faces


def stresses(
    positions: Floats, frames: Floats, elements: Ints, displacement: Floats, section: Section
) -> Floats:
    """(σ11, σ22, τ12, τ13, τ23) in MPa at the element corners: (m, 3, 3, 5), layers back, middle, front.

    The axes follow the surface's own frame, so that tensors of neighbours can be averaged. Faces carry no
    transverse shear; the middle carries 3/2 of its mean.
    """
    u = displacement.reshape(-1, DOFS)[elements].reshape(len(elements), -1)
    c = _elasticity(section)
    thickness = np.broadcast_to(section.thickness_mm, len(elements))
    out = np.empty((len(elements), 3, 3, 5))
    for start in range(0, len(elements), _CHUNK):
        part = slice(start, start + _CHUNK)
        x, n = positions[elements[part]], frames[elements[part], 2]
        axis = frames[elements[part], 0].mean(axis=1)
        at_gauss = np.empty((len(x), 3, 3, 5))
        for g, point in enumerate(THREE_POINTS):
            for layer, zeta in enumerate((-1.0, 0.0, 1.0)):
                strain, _, _ = strain_matrix(x, n, point, zeta, thickness[part], axis)
                at_gauss[:, g, layer] = np.einsum("ab,mbi,mi->ma", c, strain, u[part], optimize=True)
        at_gauss[:, :, 1, 3:] *= 1.5
        at_gauss[:, :, (0, 2), 3:] = 0.0
        out[part] = np.einsum("ng,mgla->mnla", FROM_GAUSS_TO_CORNERS, at_gauss)
    out *= np.broadcast_to(section.stress_share, len(elements))[:, None, None, None]
    return out
