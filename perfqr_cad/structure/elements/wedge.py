"""The 18-node wedge: a quadratic triangle times a quadratic layer, three-dimensional elasticity.

The section may warp, which a shell's straight normals may not.
"""

from __future__ import annotations

import numpy as np

from perfqr_cad.errors import AnalysisError
from perfqr_cad.structure.material_table import Material
from perfqr_cad.structure.mesh.triangle import (
    FROM_GAUSS_TO_CORNERS,
    SIX_POINTS,
    SIX_WEIGHTS,
    THREE_POINTS,
    Floats,
    Ints,
    gradients,
    shapes,
)

DOFS = 3
LAYERS = 3  # of nodes in a slab: back, middle, front
_THROUGH_POINTS, _THROUGH_WEIGHTS = np.polynomial.legendre.leggauss(2)
_CHUNK = 4_000  # elements at a time


def layered(elements: Ints, nodes: int) -> Ints:
    """Wedge connectivity (m, 18): the triangle's six nodes on the back, the middle and the front layer."""
    return np.concatenate([elements + layer * nodes for layer in range(LAYERS)], axis=1)


def elasticity(material: Material) -> Floats:
    """The elasticity matrix (6, 6) in MPa for (xx, yy, zz, xy, yz, zx)."""
    lame = material.e_mpa * material.nu / ((1 + material.nu) * (1 - 2 * material.nu))
    c = np.zeros((6, 6))
    c[:3, :3] = lame
    c[range(3), range(3)] += 2 * material.shear_mpa
    c[range(3, 6), range(3, 6)] = material.shear_mpa
    return c


def stiffness(
    positions: Floats, normals: Floats, triangles: Ints, thickness_mm: float, material: Material
) -> Floats:
    """Element stiffness matrices (m, 54, 54), unknowns node by node, layer by layer."""
    root = np.linalg.cholesky(elasticity(material)).T
    out = np.empty((len(triangles), 54, 54))
    for start in range(0, len(triangles), _CHUNK):
        part = slice(start, start + _CHUNK)
        x, n = positions[triangles[part]], normals[triangles[part]]
        rows = []
        for point, weight in zip(SIX_POINTS, SIX_WEIGHTS, strict=True):
            for zeta, through in zip(_THROUGH_POINTS, _THROUGH_WEIGHTS, strict=True):
                strain, volume = _strains(x, n, point, float(zeta), thickness_mm)
                if not (volume > 0.0).all():
                    at = ", ".join(f"{c:.1f}" for c in x[np.argmin(volume)].mean(axis=0))
                    raise AnalysisError(f"a wedge turns over near ({at}) mm: take less draft")
                rows.append(root @ strain * np.sqrt(weight * through * volume)[:, None, None])
        stacked = np.concatenate(rows, axis=1)
        np.matmul(stacked.transpose(0, 2, 1), stacked, out=out[part])
    return out


def _strains(x: Floats, n: Floats, point: Floats, zeta: float, thickness_mm: float) -> tuple[Floats, Floats]:
    """Strains (m, 6, 54) in space axes and the volume Jacobian (m,) at a point of each wedge."""
    value, slope = shapes(point[None])[0], gradients(point[None])[0]
    through = np.array([zeta * (zeta - 1) / 2, 1 - zeta**2, zeta * (zeta + 1) / 2])
    through_slope = np.array([zeta - 0.5, -2 * zeta, zeta + 0.5])
    half = 0.5 * thickness_mm
    layer = x + zeta * half * n
    jacobian = np.stack([slope[0] @ layer, slope[1] @ layer, value @ n * half], axis=1)
    local = np.stack(
        [np.outer(through, slope[0]), np.outer(through, slope[1]), np.outer(through_slope, value)]
    ).reshape(3, -1)
    d = np.linalg.inv(jacobian) @ local
    b = np.zeros((len(x), 6, 18, DOFS))
    for row, (p, q) in enumerate(((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))):
        b[:, row, :, q] = d[:, p]
        b[:, row, :, p] = d[:, q]
    return b.reshape(len(x), 6, 54), np.linalg.det(jacobian)


def stresses(
    places: tuple[Floats, Floats],
    frames: Floats,
    triangles: Ints,
    thickness_mm: float,
    material: Material,
    displacement: Floats,
) -> Floats:
    """(σ11, σ22, τ12, τ13, τ23) in surface axes at the element corners: (m, 3, 3, 5), back, middle, front.

    `places` are the positions and normals (n, 3) that `stiffness` takes, `frames` the axes of the surface.
    """
    positions, normals = places
    c = elasticity(material)
    u = displacement.reshape(-1, DOFS)[layered(triangles, len(positions))].reshape(len(triangles), -1)
    axes = frames[triangles[:, 0]]
    at_gauss = np.empty((len(triangles), 3, LAYERS, 5))
    for start in range(0, len(triangles), _CHUNK):
        part = slice(start, start + _CHUNK)
        x, n = positions[triangles[part]], normals[triangles[part]]
        for g, point in enumerate(THREE_POINTS):
            for layer, zeta in enumerate((-1.0, 0.0, 1.0)):
                strain, _ = _strains(x, n, point, zeta, thickness_mm)
                xx, yy, zz, xy, yz, zx = np.einsum("ab,mbi,mi->am", c, strain, u[part], optimize=True)
                tensor = np.stack([xx, xy, zx, xy, yy, yz, zx, yz, zz], axis=1).reshape(-1, 3, 3)
                local = axes[part] @ tensor @ axes[part].transpose(0, 2, 1)
                at_gauss[part, g, layer] = np.stack(
                    [local[:, 0, 0], local[:, 1, 1], local[:, 0, 1], local[:, 0, 2], local[:, 1, 2]], axis=1
                )
    return np.einsum("ng,mgla->mnla", FROM_GAUSS_TO_CORNERS, at_gauss)
