"""Which ground counts: a part that is seen through is graded before dark and before light."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.scan.camera.look import BLACK, Look
from perfqr_cad.scan.camera.scene import Scene
from perfqr_cad.scan.grade.standards import Grade, dpm, print_quality
from perfqr_cad.scan.grade.verifier import sampled
from perfqr_cad.symbol import Symbol

LIGHT_GROUND = (0.8, 0.8, 0.8)  # white paper


@dataclass(frozen=True)
class SymbolGrade:
    """Grades by ground: {ground: (ISO/IEC 15415, ISO/IEC 29158)}; the poorer ground counts (GS1 §5.9.5.2)."""

    grounds: Mapping[str, tuple[Grade, Grade]]

    @property
    def ground(self) -> str:
        """The ground that counts."""
        return min(self.grounds, key=lambda name: self.grounds[name][0].overall)

    @property
    def counted(self) -> Grade:
        """The grade that counts, by ISO/IEC 15415."""
        return self.grounds[self.ground][0]

    @property
    def words(self) -> str:
        """One line for people."""
        by_ground = [
            f"{quality.letter} ({quality.written}) before {name}, limited by {quality.limiting}"
            for name, (quality, _) in self.grounds.items()
        ]
        direct = self.grounds[self.ground][1]
        edition = f"{self.counted.edition}; as a mark on a part {direct.written}, {direct.edition}"
        return f"{'; '.join(by_ground)} ({edition}; simulated, not verified)"

    def as_dict(self) -> dict[str, Any]:
        """For the certificate."""
        return {
            "grade": self.counted.overall,
            "letter": self.counted.letter,
            "written": self.counted.written,
            "ground": self.ground,
            "status": "simulated, not verified",
            "grounds": {
                name: {"iso_15415": quality.as_dict(), "iso_29158": mark.as_dict()}
                for name, (quality, mark) in self.grounds.items()
            },
        }


def graded(
    scene: Scene,
    look: Look,
    symbol: Symbol,
    *,
    module_mm: float,
    quiet: int,
    on_surface: Callable[[NDArray[np.float64]], NDArray[np.float64]] | None = None,
    ground_known: bool = False,
) -> SymbolGrade:
    """Grades of a part; `ground_known`: only before the ground of `look`."""
    looks = {"its ground": look}
    if not ground_known:
        looks = {"dark": replace(look, ground=BLACK), "light": replace(look, ground=LIGHT_GROUND)}
    found: dict[str, tuple[Grade, Grade]] = {}
    for name, there in looks.items():
        seen = sampled(scene, there, symbol, module_mm=module_mm, quiet=quiet, on_surface=on_surface)
        found[name] = print_quality(seen), dpm(seen)
    return SymbolGrade(found)
