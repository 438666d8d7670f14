"""What a pattern is asked to be: sizes, tool, looks and objective."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, get_args

from perfqr_cad.errors import DesignError
from perfqr_cad.pattern.surround import NOTHING, Surround

Style = Literal["square", "rounded", "dots", "diamond", "bars"]
FinderStrategy = Literal["panel", "diagonal", "recessed"]
Objective = Literal["optimal", "paper", "mst"]
Tone = Literal["normal", "inverted"]
Contour = Literal["smooth", "exact"]
CHOICES = {"style": Style, "finder": FinderStrategy, "objective": Objective, "tone": Tone, "contour": Contour}

PAIR = 2  # bars by both ends of one side of a finder ring
ON_TWO_SIDES = 3  # such a pair and one on another side
BARS = (1, PAIR, ON_TWO_SIDES)  # more cut the dark ring in pieces: OpenCV then finds no corners
LINES_PER_WEB = 2  # a web of two extrusion lines holds; one line alone tears along its seam
GREATEST_SIZE_MM = 2000.0  # beyond any printer or cutter this package speaks to


@dataclass(frozen=True)
class PatternSpec:
    """The request for a pattern; `None` takes the value that follows from the nozzle.

    size_mm        edge of the whole code with its quiet zone; None: the smallest the nozzle can make
    quiet_modules  width of the light frame, in modules (ISO/IEC 18004 asks for 4)
    min_web_mm     least width of material; None: two nozzle lines
    min_gap_mm     least width of a hole; None: one nozzle
    fillet_mm      radius in re-entrant corners of the material; None: half the nozzle, 0: sharp
    finder         bars across the dark rings: `panel` one by the corner, flush with the face; `diagonal` the
                   paper's four at 45°; `recessed` some by the corners, behind the face, and on the rings
                   that readers trace at the end of a slot that is pinched
    bars           recessed bars of a finder ring. 1; 2 by both ends of one side, or one of twice the width in
                   a slot that is pinched; 3 on two sides, or two in slots that are pinched
    bar_height_mm  height of a recessed bar above the back of the part
    bar_width_mm   width of recessed bars; None: wide ones on finders, the least web on alignment patterns.
                   Less than that web, down to a nozzle line, in pinched slots alone: it is then the only
                   material under it
    objective      `optimal`, or the baselines `paper` (Eq. (4)) and `mst` (Eq. (4) with λ = 0)
    loss_weight    λ of Eq. (4)
    tone           `normal`: light modules are material; `inverted`: dark modules are
    contour        free-form art: `smooth` Bézier edges, or the pixels' own `exact` edges
    surround       frame, rounded corners and mounting holes around the code
    """

    size_mm: float | None = None
    quiet_modules: int = 4
    nozzle_mm: float = 0.4
    min_web_mm: float | None = None
    min_gap_mm: float | None = None
    style: Style = "square"
    fillet_mm: float | None = None
    finder: FinderStrategy = "recessed"
    bars: int = ON_TWO_SIDES
    bar_height_mm: float = 0.4
    bar_width_mm: float | None = None
    objective: Objective = "optimal"
    loss_weight: float = 1.0
    tone: Tone = "normal"
    contour: Contour = "smooth"
    surround: Surround = NOTHING
    seed: int = 0
    most_nodes: int = 2000

    def __post_init__(self) -> None:
        _positive("nozzle_mm", self.nozzle_mm)
        _positive("most_nodes", self.most_nodes)
        _positive("bar_height_mm", self.bar_height_mm)
        for name in ("bar_width_mm", "min_web_mm", "min_gap_mm", "size_mm"):
            if (value := getattr(self, name)) is not None:
                _positive(name, value)
        if self.bars not in BARS:
            raise DesignError(f"bars = {self.bars} a finder ring is outside 1 to 3: use 1, 2 or 3")
        size = self.size_mm or 0.0
        if size > GREATEST_SIZE_MM:
            raise DesignError(f"size {size:g} mm is over {GREATEST_SIZE_MM:g} mm: use a smaller one")
        if not 0 <= self.quiet_modules <= 100:
            raise DesignError(f"quiet zone of {self.quiet_modules} modules is outside 0 to 100: use 4")
        for name in ("fillet_mm", "loss_weight"):
            value = getattr(self, name)
            if value is not None and not (math.isfinite(value) and value >= 0):
                raise DesignError(f"{name} = {value} must be a number of 0 or more")
        for name, kind in CHOICES.items():
            if getattr(self, name) not in get_args(kind):
                choices = ", ".join(get_args(kind))
                raise DesignError(f"{name} {getattr(self, name)!r} is unknown: use one of {choices}")

    @property
    def web_mm(self) -> float:
        """Least width of material, mm."""
        return LINES_PER_WEB * self.nozzle_mm if self.min_web_mm is None else self.min_web_mm

    @property
    def gap_mm(self) -> float:
        """Least width of a hole, mm."""
        return self.nozzle_mm if self.min_gap_mm is None else self.min_gap_mm

    @property
    def fillet_radius_mm(self) -> float:
        """Radius in re-entrant corners of the material, mm."""
        return self.nozzle_mm / 2 if self.fillet_mm is None else self.fillet_mm


def _positive(name: str, value: float) -> None:
    if not (math.isfinite(value) and value > 0):
        raise DesignError(f"{name} = {value} must be a number above 0")
