"""What may lie behind a part that is seen through, and in what light: a claim to be read names both."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.scan.camera.look import BLACK, RGB, Light, Look

ROOM = Light()
# A desk lamp beside the part, in a room that is rather dark.
LOW_LAMP = Light(ambient=0.2, lamp=1.0, lamp_elevation_deg=35.0, lamp_distance=1.5)
DARKEN = "add a backing, or paint what is behind it dark"
LIGHTEN = "a dark part wants a light ground some millimetres behind it, or a thinner plate"
GRAIN_MM = 60.0  # edge of a tile of wood


@dataclass(frozen=True)
class Ground:
    """A ground behind a part.

    name          for people
    reflectance   of red, green and blue, linear
    gap_mm        from the part's back to it
    light         that falls on both
    grained       whether it is striped like wood
    """

    name: str
    reflectance: RGB
    gap_mm: float = 0.0
    light: Light = field(default=ROOM)
    grained: bool = False

    def look(self, own: Look) -> Look:
        """The part's look before this ground."""
        texture = _grain() if self.grained else None
        return replace(
            own,
            ground=self.reflectance,
            gap_mm=self.gap_mm,
            light=self.light,
            texture=texture,
            texture_mm=GRAIN_MM,
        )

    def as_dict(self) -> dict[str, Any]:
        """For the certificate."""
        return {"ground": self.name, **conditions(self.look(Look()))}


# Dark things that a part is put on, and bright ones that it is held or hung before.
GROUNDS = (
    Ground("black card, a low near lamp", BLACK, light=LOW_LAMP),
    Ground("dark wood", (0.14, 0.09, 0.06), grained=True),
    Ground("grey card, a low near lamp", (0.2, 0.2, 0.2), light=LOW_LAMP),
    Ground("a white wall 5 mm behind", (0.8, 0.8, 0.8), 5.0),
    Ground("a bright room far behind", (0.8, 0.8, 0.8), 300.0),
)


@dataclass(frozen=True)
class GroundResult:
    """Shares of views read before one ground, 0 to 1: {decoder: by tilt}."""

    ground: Ground
    tilts_deg: tuple[float, ...]
    rates: dict[str, tuple[float, ...]]

    def read_by(self, tilt_deg: float | None = None) -> tuple[str, ...]:
        """Decoders that read every view up to a tilt; all tilts filmed by default."""
        count = sum(tilt_deg is None or tilt <= tilt_deg for tilt in self.tilts_deg)
        return tuple(name for name, rates in self.rates.items() if min(rates[:count]) == 1)

    def as_dict(self) -> dict[str, Any]:
        """For the certificate."""
        rates = {
            name: {f"{tilt:g}": round(rate, 4) for tilt, rate in zip(self.tilts_deg, rates, strict=True)}
            for name, rates in self.rates.items()
        }
        return {**self.ground.as_dict(), "rates": rates}


def conditions(look: Look) -> dict[str, Any]:
    """Ground and light of a look as plain values."""
    light = look.light
    return {
        "reflectance": [round(value, 3) for value in look.ground],
        "gap_mm": look.gap_mm,
        "light": {
            "sky": light.ambient,
            "lamp": light.lamp,
            "lamp_elevation_deg": light.lamp_elevation_deg,
            "lamp_distance_edges": None if np.isinf(light.lamp_distance) else light.lamp_distance,
        },
    }


def in_words(results: tuple[GroundResult, ...], readers: int, *, inverted: bool = False) -> str:
    """One sentence: before what the part is read, by how many, and before what it is not.

    readers    how many decoders read it on its own ground
    inverted   whether the part is darker than its own ground
    """
    names = {result.ground.name: len(result.read_by()) for result in results}
    well = [name for name, count in names.items() if count >= readers]
    partly = [f"{name} ({count} of {readers})" for name, count in names.items() if 0 < count < readers]
    never = [name for name, count in names.items() if count == 0]
    said = [f"reads on {', '.join(well)}"] if well else []
    said += [f"in part on {', '.join(partly)}"] if partly else []
    if never:
        remedy = LIGHTEN if inverted else DARKEN
        said.append(f"not before {', '.join(never)}: {remedy}")
    return "; ".join(said)


@cache
def _grain() -> NDArray[np.float32]:
    """Stripes of early and late wood, darker and lighter by a third, as factors (256, 256)."""
    rng = np.random.default_rng(0)
    x, y = np.meshgrid(np.arange(256) / 256, np.arange(256) / 256)
    bent = x + 0.03 * np.sin(2 * np.pi * (y + rng.random()))
    waves = sum(np.sin(2 * np.pi * (k * bent + rng.random())) / np.sqrt(k) for k in (3, 7, 12, 23))
    stripes = 1 + 0.15 * np.asarray(waves) + 0.05 * rng.normal(size=x.shape)
    grain = np.clip(stripes, 0.4, 1.6).astype(np.float32)
    grain.setflags(write=False)
    return grain
