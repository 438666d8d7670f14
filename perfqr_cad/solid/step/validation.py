"""Geometric validation properties: what a reader must measure on a part if it was read rightly.

As in the recommended practices of the CAx Implementor Forum for geometric and assembly validation properties:
volume, surface area and centroid of each part, which a receiving system compares with its own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from perfqr_cad.geometry.arrays import Array
from perfqr_cad.solid.shape import Solid
from perfqr_cad.solid.step.text import Part21, real, reals

PROPERTY = "geometric validation property"


@dataclass(frozen=True)
class Measures:
    """Of one body: mm³, mm² and mm."""

    volume_mm3: float
    area_mm2: float
    centroid_mm: tuple[float, float, float]


def measured(solid: Solid) -> Measures:
    """The measures of a body: its volume exactly, area and centroid on its triangles."""
    corners: Array = solid.triangles.vertices[solid.triangles.faces]
    a, b, c = (corners[:, k] - corners[0, 0] for k in range(3))  # near by: rounding stays small
    across = np.cross(b - a, c - a)
    sixfold = np.einsum("ki,ki->k", a, np.cross(b, c))
    x, y, z = (corners[0, 0] + sixfold @ (a + b + c) / (4 * sixfold.sum())).tolist()
    return Measures(solid.volume_mm3, float(np.linalg.norm(across, axis=1).sum() / 2), (x, y, z))


class Validation:
    """Writes measures into a file whose lengths are of one unit and whose shapes lie in one context."""

    def __init__(self, part: Part21, length: int, context: int) -> None:
        self._part, self._length, self._context = part, length, context

    def write(self, shape_of: int, measures: Measures) -> None:
        """The properties of the part whose PRODUCT_DEFINITION_SHAPE this is."""
        add = self._part.add
        volume, area = real(measures.volume_mm3), real(measures.area_mm2)
        items = {
            "volume": f"MEASURE_REPRESENTATION_ITEM('volume measure',VOLUME_MEASURE({volume}),"
            f"#{self._power(3)})",
            "surface area": f"MEASURE_REPRESENTATION_ITEM('surface area measure',AREA_MEASURE({area}),"
            f"#{self._power(2)})",
            "centroid": f"CARTESIAN_POINT('centre point',{reals(measures.centroid_mm)})",
        }
        for name, item in items.items():
            found = add(f"PROPERTY_DEFINITION('{PROPERTY}','{name}',#{shape_of})")
            value = add(f"REPRESENTATION('{name}',(#{add(item)}),#{self._context})")
            add(f"PROPERTY_DEFINITION_REPRESENTATION(#{found},#{value})")

    def _power(self, exponent: int) -> int:
        """The unit of areas or volumes."""
        element = self._part.shared(f"DERIVED_UNIT_ELEMENT(#{self._length},{exponent}.)")
        return self._part.shared(f"DERIVED_UNIT((#{element}))")
