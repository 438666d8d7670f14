"""What the panel saw: per decoder and tilt, for the part and for the flat print of the same code."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.scan.camera.look import Look
from perfqr_cad.scan.colours import contrast
from perfqr_cad.scan.decoding.panel import Losses
from perfqr_cad.scan.grade import SymbolGrade
from perfqr_cad.scan.grounds import GroundResult, conditions, in_words
from perfqr_cad.scan.likeness import Likeness


@dataclass(frozen=True)
class DecoderResult:
    """One decoder's success by tilt: rates over the azimuths, 0 to 1, for the part and for the flat print.

    flat_rates is None when there was no symbol to print.
    """

    name: str
    tilts_deg: tuple[float, ...]
    rates: tuple[float, ...]
    flat_rates: tuple[float, ...] | None

    @property
    def frontal(self) -> bool:
        """Whether it reads the part from straight above."""
        return self.rates[0] > 0

    @property
    def flat_frontal(self) -> bool | None:
        """Whether it reads the flat print from straight above."""
        return None if self.flat_rates is None else self.flat_rates[0] > 0

    @property
    def max_tilt_deg(self) -> float | None:
        """The largest tilt up to which it reads the part from every azimuth; None if not even frontally."""
        return _limit(self.tilts_deg, self.rates)

    @property
    def flat_max_tilt_deg(self) -> float | None:
        """The same for the flat print: the ceiling of what a part can reach."""
        return None if self.flat_rates is None else _limit(self.tilts_deg, self.flat_rates)


def _by_tilt(tilts: tuple[float, ...], rates: tuple[float, ...] | None) -> dict[str, float] | None:
    if rates is None:
        return None
    return {f"{tilt:g}": round(rate, 4) for tilt, rate in zip(tilts, rates, strict=True)}


def _limit(tilts: tuple[float, ...], rates: tuple[float, ...]) -> float | None:
    reached = None
    for tilt, rate in zip(tilts, rates, strict=True):
        if rate < 1:
            break
        reached = tilt
    return reached


@dataclass(frozen=True)
class FilmedView:
    """A view worth a look: its picture, where it was taken from, and who read it."""

    picture: NDArray[np.uint8] = field(repr=False)
    tilt_deg: float
    azimuth_deg: float
    read_by: tuple[str, ...]


@dataclass(frozen=True)
class ScanReport:
    """Decoders by tilt and by background, the telling views, and advice in plain sentences.

    payload       the text that had to come back; None if it is no text
    backgrounds   share of frontal scans read on each ground, over the decoders that read the part at all
    worst_read    the steepest view that every frontal reader still reads
    first_missed  the least steep view that one of them misses
    losses        views missed because a decoder met its limit of computing, or crashed
    grade         how a verifier would grade it; None where the symbol is not known
    look          ground and light that all of this was found in, but for `backgrounds` and `grounds`
    grounds       what was read before other grounds and in other light
    likeness      what the picture lost that the part was drawn from; None without one
    """

    payload: str | None
    decoders: dict[str, DecoderResult]
    backgrounds: dict[str, float]
    worst_read: FilmedView | None = None
    first_missed: FilmedView | None = None
    advice: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    losses: Losses = field(default_factory=Losses)
    grade: SymbolGrade | None = None
    look: Look = field(default_factory=Look)
    grounds: tuple[GroundResult, ...] = ()
    likeness: Likeness | None = None

    @property
    def ground_words(self) -> str:
        """Before what the part is read, and before what it is not: one sentence."""
        inverted = contrast(self.look.material, self.look.ground) < 0
        return in_words(self.grounds, len(self.readers), inverted=inverted)

    @property
    def readers(self) -> tuple[str, ...]:
        """Decoders that read the exact payload from straight above."""
        return tuple(name for name, result in self.decoders.items() if result.frontal)

    def as_dict(self) -> dict[str, Any]:
        """The certificate's section."""
        return {
            "payload": self.payload,
            "ground": conditions(self.look),
            "decoders": {
                name: {
                    "frontal": result.frontal,
                    "max_tilt_deg": result.max_tilt_deg,
                    "flat_frontal": result.flat_frontal,
                    "flat_max_tilt_deg": result.flat_max_tilt_deg,
                    "rates": _by_tilt(result.tilts_deg, result.rates),
                    "flat_rates": _by_tilt(result.tilts_deg, result.flat_rates),
                }
                for name, result in self.decoders.items()
            },
            "grounds": [result.as_dict() for result in self.grounds],
            "reads_on": self.ground_words,
            "backgrounds": {name: round(rate, 4) for name, rate in self.backgrounds.items()},
            "art": None if self.likeness is None else self.likeness.as_dict(self.readers),
            "grade": None if self.grade is None else self.grade.as_dict(),
            "timeouts": self.losses.timeouts,
            "crashes": self.losses.crashes,
            "advice": list(self.advice),
            "warnings": list(self.warnings),
        }

    def render(self) -> str:
        """The report as plain text."""
        from perfqr_cad.table import Table

        tilts = next(iter(self.decoders.values())).tilts_deg if self.decoders else ()
        rows = [
            (name, *(f"{rate:.0%}" for rate in result.rates), result.max_tilt_deg, result.flat_max_tilt_deg)
            for name, result in self.decoders.items()
        ]
        columns = ("decoder", *(f"{tilt:g}°" for tilt in tilts), "part to", "flat print to")
        seen = [f"on {name}: {rate:.0%}" for name, rate in self.backgrounds.items()]
        seen += [self.ground_words] if self.grounds else []
        seen += [] if self.likeness is None else [self.likeness.words(self.readers)]
        graded = () if self.grade is None else (f"grade {self.grade.words}",)
        title = f"Views read, by tilt: {self.payload!r}"
        return Table(title, columns, tuple(rows), (*seen, *graded, *self.warnings, *self.advice)).render()
