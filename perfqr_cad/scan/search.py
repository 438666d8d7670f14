"""Design for the reader: the change of walls that reads best at a tilt.

Settings are tried one at a time from where they stand (coordinate search). The surrogate finds the best for
each value of the setting that weighs most; among those the panel has the last word.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from perfqr_cad.errors import PerfQRError
from perfqr_cad.progress import tell
from perfqr_cad.scan.camera.look import Look
from perfqr_cad.scan.camera.scene import Scene
from perfqr_cad.scan.decoding.decoders import CORE, accepted
from perfqr_cad.scan.decoding.panel import shared
from perfqr_cad.scan.proof import PATIENCE, Schedule, reads
from perfqr_cad.scan.surrogate import Legibility, legibility
from perfqr_cad.symbol import Matrix

Settings = Mapping[str, float]
Stage = Callable[[Settings], Scene]
# The panel looks from these parts of the tilt: a plate that gains at the tilt must not lose before it. Thin
# plates do, because the bars behind their rings lie in more light.
SHARES = (0.25, 0.5, 0.75, 1.0)
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
    weighs_most: str,
    look: Look | None = None,
) -> tuple[Trial, tuple[Trial, ...]]:
    """The best settings found, and every trial in the order made.

    stage     puts the part with some settings before the camera; a `PerfQRError` from it rules them out
    start     a value for every setting
    choices   values to try for each setting, in any order
    weighs_most   the setting for whose every value the panel looks at the best trial

    The start is returned when the panel reads it from every view up to the goal's tilt already, or when
    nothing is better.
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
    rivals = _best_of_each(weighs_most, tried.values())
    # The first of equals wins: what is nearest to the start.
    rivals.sort(key=lambda trial: abs(trial.settings[weighs_most] - start[weighs_most]))
    confirmed = [_confirm(stage, trial, goal, look) for trial in rivals if trial.settings != first.settings]
    winner = max([first, *confirmed], key=lambda trial: trial.rate or 0.0)
    return winner, (*tried.values(), first, *confirmed)


def _best_of_each(name: str, trials: Iterable[Trial]) -> list[Trial]:
    """The trial with the best surrogate for every value of a setting."""
    best: dict[float, Trial] = {}
    for trial in trials:
        value = trial.settings[name]
        if trial.legibility is not None and (value not in best or trial.score > best[value].score):
            best[value] = trial
    return list(best.values())


def _estimate(stage: Stage, settings: Settings, goal: Goal, look: Look) -> Trial:
    try:
        scene = stage(settings)
    except PerfQRError as error:
        return Trial(dict(settings), None, problem=str(error))
    return Trial(dict(settings), legibility(scene, goal.matrix, goal.module_mm, goal.tilt_deg, look=look))


def _confirm(stage: Stage, trial: Trial, goal: Goal, look: Look) -> Trial:
    """Ask the panel: share of decoders x views that read the part at the goal's tilt and before it."""
    if trial.legibility is None:
        return trial
    views = Schedule(tuple(share * goal.tilt_deg for share in SHARES), goal.azimuths_deg).views()
    panel = shared(goal.decoders)
    read = reads(
        stage(trial.settings), views, look, accepted(goal.payload), panel,
        frames=[PATIENCE] * len(views), step=f"scan tilt {goal.tilt_deg:g}°: the panel",
    )  # fmt: skip
    rate = sum(len(names) for names in read) / (len(views) * len(goal.decoders))
    return Trial(trial.settings, trial.legibility, rate)
