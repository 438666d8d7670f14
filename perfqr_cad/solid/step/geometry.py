"""Curves and surfaces of tables as STEP geometry (ISO 10303-42)."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, cast

import numpy as np

from perfqr_cad.geometry.arrays import Array, Mask
from perfqr_cad.solid.step.text import UNIT_DIGITS, Part21, real, reals, refs
from perfqr_cad.solid.tables.batches import (
    Arcs,
    Cones,
    Curves,
    Lines,
    Planes,
    Splines,
    SplineSurfaces,
    Surfaces,
)

if TYPE_CHECKING:
    from perfqr_cad.solid.kernel.modelled import ModelledCurves, ModelledSurfaces
    from perfqr_cad.solid.step.kernel_geometry import ModelledGeometry


class Geometry:
    """Writes geometry into a file; equal points, directions and axes are written once."""

    def __init__(self, part: Part21) -> None:
        self._part = part

    def curves(self, curves: Curves) -> Iterable[int]:
        """The numbers of curves."""
        match curves:
            case Lines():
                vectors = self._vectors((curves.end - curves.start) / curves.length[:, None])
                starts = self.points(curves.start)
                return self._part.add_all(f"LINE('',#{p},#{d})" for p, d in zip(starts, vectors, strict=True))
            case Arcs():
                axes = self._axes(curves.centre, curves.axis, curves.x)
                return self._part.add_all(
                    f"CIRCLE('',#{at},{real(r)})" for at, r in zip(axes, curves.radius.tolist(), strict=True)
                )
            case Splines():
                poles = self._nets(curves.poles)
                shape = f".UNSPECIFIED.,.F.,.F.,{_knots(curves.knots)},.UNSPECIFIED.)"
                return self._part.add_all(
                    f"B_SPLINE_CURVE_WITH_KNOTS('',{curves.degree},{refs(row)},{shape}" for row in poles
                )
            case _:
                return self._modelled.curves(cast("ModelledCurves", curves))

    def surfaces(self, surfaces: Surfaces) -> tuple[Iterable[int], Mask]:
        """The numbers of surfaces, and whether their normals in the file are opposite to their own."""
        none = np.zeros(len(surfaces), np.bool_)
        match surfaces:
            case Planes():
                axes = self._axes(surfaces.origin, surfaces.normal, surfaces.x)
                return self._part.add_all(f"PLANE('',#{at})" for at in axes), none
            case Cones():
                return self._part.add_all(self._cones(surfaces)), none
            case SplineSurfaces():
                return self._part.add_all(self._patches(surfaces)), none
            case _:
                return self._modelled.surfaces(cast("ModelledSurfaces", surfaces))

    def points(self, points: Array) -> list[int]:
        """The numbers of points (k, 3)."""
        return self._part.shared_all(f"CARTESIAN_POINT('',{reals(p)})" for p in points.tolist())

    def _nets(self, poles: Array) -> list[list[int]]:
        """Points (k, n, 3) by row."""
        numbers = self.points(poles.reshape(-1, 3))
        return [numbers[i : i + poles.shape[1]] for i in range(0, len(numbers), poles.shape[1])]

    def _directions(self, directions: Array) -> list[int]:
        return self._part.shared_all(f"DIRECTION('',{reals(d, UNIT_DIGITS)})" for d in directions.tolist())

    def _vectors(self, directions: Array) -> list[int]:
        return self._part.shared_all(f"VECTOR('',#{d},1.)" for d in self._directions(directions))

    def _axes(self, origin: Array, z: Array, x: Array) -> list[int]:
        parts = zip(self.points(origin), self._directions(z), self._directions(x), strict=True)
        return self._part.shared_all(f"AXIS2_PLACEMENT_3D('',#{o},#{z},#{x})" for o, z, x in parts)

    def _cones(self, cones: Cones) -> Iterable[str]:
        """STEP wants a semi-angle above 0: one that narrows along its axis is turned about, normal kept."""
        axis = np.where(cones.angle[:, None] < 0, -cones.axis, cones.axis)
        sizes = zip(cones.radius.tolist(), np.abs(cones.angle).tolist(), strict=True)
        for at, (radius, angle) in zip(self._axes(cones.origin, axis, cones.x), sizes, strict=True):
            if angle:
                yield f"CONICAL_SURFACE('',#{at},{real(radius)},{real(angle, UNIT_DIGITS)})"
            else:
                yield f"CYLINDRICAL_SURFACE('',#{at},{real(radius)})"

    def _patches(self, patches: SplineSurfaces) -> Iterable[str]:
        count, rows, columns, _ = patches.poles.shape
        nets = self._nets(patches.poles.reshape(count * rows, columns, 3))
        (u, u_mults), (v, v_mults) = (_knots(k).split(",(") for k in (patches.u_knots, patches.v_knots))
        knots = f"{u},{v},({u_mults},({v_mults},.UNSPECIFIED."
        for i in range(count):
            poles = ",".join(map(refs, nets[i * rows : (i + 1) * rows]))
            degrees = f"{patches.degrees[0]},{patches.degrees[1]}"
            shape = f"{degrees},({poles}),.UNSPECIFIED.,.F.,.F.,.F."
            if patches.weights is None:
                yield f"B_SPLINE_SURFACE_WITH_KNOTS('',{shape},{knots})"
                continue
            weights = ",".join(reals(row, UNIT_DIGITS) for row in patches.weights[i].tolist())
            yield (
                f"(BOUNDED_SURFACE()B_SPLINE_SURFACE({shape})B_SPLINE_SURFACE_WITH_KNOTS({knots})"
                f"GEOMETRIC_REPRESENTATION_ITEM()RATIONAL_B_SPLINE_SURFACE(({weights}))"
                "REPRESENTATION_ITEM('')SURFACE())"
            )

    @property
    def _modelled(self) -> ModelledGeometry:
        from perfqr_cad.solid.step.kernel_geometry import ModelledGeometry

        return ModelledGeometry(self._part)


def _knots(flat: tuple[float, ...]) -> str:
    """Multiplicities and distinct knots."""
    values, counts = np.unique(flat, return_counts=True)
    return f"({','.join(map(str, counts.tolist()))}),{reals(values.tolist(), UNIT_DIGITS)}"
