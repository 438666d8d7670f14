"""Bodies that lie one upon the other: the heights at which a printer with one nozzle changes its colour."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from perfqr_cad.errors import DesignError
from perfqr_cad.remedy import Remedy

if TYPE_CHECKING:
    from perfqr_cad.profile.colour import Colour
    from perfqr_cad.solid import Solid

SHARED_MM = 1e-6  # bodies that touch share no more than rounding


@dataclass(frozen=True)
class ColourChange:
    """What is printed from a height above the bed on, and in which colour (sRGB, 0 to 1)."""

    height_mm: float
    body: str
    colour: Colour

    @property
    def words(self) -> str:
        """For people: where to stop, and which filament to load."""
        return f"change of colour at {self.height_mm:g} mm to {hexadecimal(self.colour)} ({self.body})"

    def as_dict(self) -> dict[str, Any]:
        """The change as the certificate lists it."""
        return {"height_mm": self.height_mm, "body": self.body, "colour": hexadecimal(self.colour)}


def colour_changes(solid: Solid) -> tuple[ColourChange, ...]:
    """Where one body ends and the next begins, from the bed upwards.

    Raises `DesignError` for a part of one body, and for bodies that share heights, which no change by layer
    parts.
    """
    if not solid.extras:
        raise DesignError("a change of colour by layer needs a second body, such as a backing")
    bodies = sorted([solid, *solid.extras], key=lambda body: body.bbox_mm[0][2])
    bed_mm = bodies[0].bbox_mm[0][2]
    changes: list[ColourChange] = []
    for below, above in pairwise(bodies):
        low_mm, high_mm = above.bbox_mm[0][2], below.bbox_mm[1][2]
        if low_mm < high_mm - SHARED_MM:
            raise DesignError(
                f"{above.name} and {below.name} share {high_mm - low_mm:.3g} mm of height, which a change of"
                " colour by layer cannot part",
                Remedy(colour_change=None),
            )
        changes.append(ColourChange(round(low_mm - bed_mm, 6), above.name, above.colour))
    return tuple(changes)


def hexadecimal(colour: Colour) -> str:
    """#RRGGBB of sRGB components from 0 to 1."""
    return "#" + "".join(f"{round(255 * part):02X}" for part in colour)
