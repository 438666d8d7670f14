"""The modeller's own curves and surfaces as batches: faces of imported solids, levels of curved walls."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from OCP.Geom import Geom_Curve, Geom_Surface
from OCP.Geom2d import Geom2d_Curve
from OCP.gp import gp_Pnt, gp_Pnt2d, gp_Vec, gp_Vec2d

from perfqr_cad.geometry.arrays import Array, Indices
from perfqr_cad.solid.kernel.evaluate import Evaluator, evaluator

# Points from which a surface is evaluated at once; before, preparing that costs more.
MANY = 64


class Run(NamedTuple):
    """A curve of the modeller, in space or in parameters, from one of its own parameters to another."""

    curve: Geom_Curve | Geom2d_Curve
    first: float
    last: float


@dataclass(frozen=True, eq=False)
class ModelledCurves:
    """Curves in space or in parameters, one call of the modeller a point."""

    runs: tuple[Run, ...]

    def __len__(self) -> int:
        return len(self.runs)

    def __getitem__(self, rows: Indices) -> ModelledCurves:
        return ModelledCurves(tuple(self.runs[i] for i in rows.tolist()))

    def at(self, fractions: Array) -> tuple[Array, Array]:
        flat = bool(self.runs) and isinstance(self.runs[0].curve, Geom2d_Curve)
        p, slope = (gp_Pnt2d(), gp_Vec2d()) if flat else (gp_Pnt(), gp_Vec())
        points: list[tuple[float, ...]] = []
        slopes: list[tuple[float, ...]] = []
        for curve, first, last in self.runs:
            for t in (first + fractions * (last - first)).tolist():
                curve.D1(t, p, slope)
                points.append(p.Coord())
                slopes.append(slope.Coord())
        shape = len(self.runs), len(fractions), 2 if flat else 3
        speed = np.array([last - first for _, first, last in self.runs]).reshape(-1, 1, 1)
        return np.array(points).reshape(shape), np.array(slopes).reshape(shape) * speed


@dataclass(frozen=True, eq=False)
class ModelledSurfaces:
    """Surfaces of the modeller, evaluated by their own formulas; faces of one level share one."""

    handles: tuple[Geom_Surface, ...]

    def __len__(self) -> int:
        return len(self.handles)

    def __getitem__(self, rows: Indices) -> ModelledSurfaces:
        return ModelledSurfaces(tuple(self.handles[i] for i in rows.tolist()))

    def at(self, which: Indices, uv: Array) -> Array:
        points = np.empty((*uv.shape[:2], 3))
        number = self._number[which]
        order = np.argsort(number, kind="stable")
        for rows in np.split(order, np.flatnonzero(np.diff(number[order])) + 1):
            if len(rows):
                seen = _seen(self.handles[which[rows[0]]], uv[rows].reshape(-1, 2))
                points[rows] = seen.reshape(len(rows), -1, 3)
        return points

    @property
    def periods(self) -> Array:
        found = [
            (h.UPeriod() if h.IsUPeriodic() else 0.0, h.VPeriod() if h.IsVPeriodic() else 0.0)
            for h in self.handles
        ]
        return np.array(found).reshape(-1, 2)

    def distinct(self) -> Iterator[tuple[Evaluator, Indices]]:
        """Each surface once, and where it stands."""
        for number in range(self._number.max(initial=-1) + 1):
            on = np.flatnonzero(self._number == number)
            yield evaluator(self.handles[on[0]]), on

    @cached_property
    def _number(self) -> Indices:
        numbers: dict[int, int] = {}
        return np.array([numbers.setdefault(id(h), len(numbers)) for h in self.handles], np.int64)


def _seen(surface: Geom_Surface, uv: Array) -> Array:
    """Points (k, 3) of a surface."""
    if len(uv) < MANY:
        return np.array([surface.Value(u, v).Coord() for u, v in uv.tolist()])
    return evaluator(surface)(uv, 1)[0]
