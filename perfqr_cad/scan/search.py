"""Design for the reader: the change of walls that reads best at a tilt.

Settings are tried one at a time from where they stand (coordinate search). The surrogate ranks them; the
panel has the last word on the best few.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from perfqr_cad.errors import PerfQRError
from perfqr_cad.progress import tell
from perfqr_cad.scan.decoders import CORE, accepted
from perfqr_cad.scan.look import Look
from perfqr_cad.scan.panel import shared
from perfqr_cad.scan.proof import PATIENCE, Plan, reads
from perfqr_cad.scan.scene import Scene
from perfqr_cad.scan.surrogate import Legibility, legibility
from perfqr_cad.symbol import Matrix

Settings = Mapping[str, float]
Stage = Callable[[Settings], Scene]
CONFIRMED = 3  # candidates that the panel looks at, best surrogate first
# The panel looks from this part of the tilt too: 12 views tell plates apart that 4 do not, and a plate that
# gains at the tilt must not lose before it.
SHALLOWER = 0.75
GAIN = 0.005  # of full contrast: a smaller step of the surrogate is noise


@dataclass(frozen=True)
class Goal:
    """The code and the tilt up to which these decoders must read it, from every azimuth."""

    matrix: Matrix
    module_mm: float
    payload: str | bytes
    tilt_deg: float
    decoders: tuple[str, ...] = CORE
    azimuths_deg: tuple[float, ...] = (25.0, 85.0, 145.0, 205.0, 265.0, 325.0)


@dataclass(frozen=True)
class Trial:
    """One set of settings: what the surrogate says, and the share of views the panel read (None: not asked).

    problem is why the part could not be built; such a trial has no figures.
    """

    settings: dict[str, float]
    legibility: Legibility | None
    rate: float | None = None
    problem: str | None = None

    @property
    def score(self) -> float:
        """The surrogate's figure; minus infinity for a part that cannot be built."""
        return float("-inf") if self.legibility is None else self.legibility.score


def improve(
    stage: Stage,
    start: Settings,
    choices: Mapping[str, Sequence[float]],
    goal: Goal,
    *,
    look: Look | None = None,
) -> tuple[Trial, tuple[Trial, ...]]:
    """The best settings found, and every trial in the order made.

    stage     puts the part with some settings before the camera; a `PerfQRError` from it rules them out
    start     a value for every setting
    choices   values to try for each setting, in any order

    The start is returned when the panel reads it at the goal's tilt already, or when nothing is better.
    """
    look = look or Look()
    tried: dict[tuple[tuple[str, float], ...], Trial] = {}

    def attempt(settings: Settings) -> Trial:
        key = tuple(sorted(settings.items()))
        if key not in tried:
            tried[key] = _estimate(stage, settings, goal, look)
        return tried[key]

    first = _confirm(stage, attempt(start), goal, look)
    if first.rate == 1.0:
        return first, (first,)
    best = attempt(start)
    while True:
        round_start = best
        for name, values in choices.items():
            tell(f"scan tilt {goal.tilt_deg:g}°: {name}")
            for value in values:
                trial = attempt({**best.settings, name: value})
                if trial.score > best.score + GAIN:
                    best = trial
        if best is round_start:
            break
    ranked = sorted(tried.values(), key=lambda trial: -trial.score)[:CONFIRMED]
    confirmed = [_confirm(stage, trial, goal, look) for trial in ranked if trial.legibility is not None]
    winner = max([first, *confirmed], key=lambda trial: trial.rate or 0.0)
    return winner, (*tried.values(), first, *confirmed)


def _estimate(stage: Stage, settings: Settings, goal: Goal, look: Look) -> Trial:
    try:
        scene = stage(settings)
    except PerfQRError as error:
        return Trial(dict(settings), None, problem=str(error))
    return Trial(dict(settings), legibility(scene, goal.matrix, goal.module_mm, goal.tilt_deg, look=look))


def _confirm(stage: Stage, trial: Trial, goal: Goal, look: Look) -> Trial:
    """Ask the panel: share of decoders x views that read the part at the goal's tilt and a little before."""
    if trial.legibility is None:
        return trial
    views = Plan((SHALLOWER * goal.tilt_deg, goal.tilt_deg), goal.azimuths_deg).views()
    panel = shared(goal.decoders)
    read = reads(
        stage(trial.settings), views, look, accepted(goal.payload), panel,
        frames=[PATIENCE] * len(views), step=f"scan tilt {goal.tilt_deg:g}°: the panel",
    )  # fmt: skip
    rate = sum(len(names) for names in read) / (len(views) * len(goal.decoders))
    return Trial(trial.settings, trial.legibility, rate)
