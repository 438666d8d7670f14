"""Design for the reader: the change of walls that reads best at a tilt.

Settings are tried one at a time from where they stand (coordinate search). The surrogate finds the best for
each value of the setting that weighs most; among those the panel has the last word.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from perfqr_cad.errors import PerfQRError
from perfqr_cad.progress import tell
from perfqr_cad.scan.camera.look import Look
from perfqr_cad.scan.camera.scene import Scene
from perfqr_cad.scan.decoding.decoders import CORE, accepted
from perfqr_cad.scan.decoding.panel import shared
from perfqr_cad.scan.filming import reads
from perfqr_cad.scan.schedule import PATIENCE, Schedule
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
    trials = _Trials(stage, goal, look or Look(), weighs_most)
    first = trials.confirmed(trials.attempt(start))
    if first.rate == 1.0:
        return first, (first,)
    best = trials.attempt(start)
    while True:
        round_start = best
        for name, values in choices.items():
            tell(f"scan tilt {goal.tilt_deg:g}°: {name}")
            for value in values:
                trial = trials.attempt({**best.settings, name: value})
                if trial.score > best.score + GAIN:
                    best = trial
        if best is round_start:
            break
    # The first of equals wins: what is nearest to the start.
    rivals = sorted(trials.best, key=lambda trial: abs(trial.settings[weighs_most] - start[weighs_most]))
    confirmed = [trials.confirmed(trial) for trial in rivals if trial.settings != first.settings]
    winner = max([first, *confirmed], key=lambda trial: trial.rate or 0.0)
    return winner, (*trials.tried, first, *confirmed)


class _Trials:
    """Every set of settings that was tried, and the scene of the best for each value of one setting."""

    def __init__(self, stage: Stage, goal: Goal, look: Look, weighs_most: str) -> None:
        self._stage, self._goal, self._look, self._weighs_most = stage, goal, look, weighs_most
        self._tried: dict[tuple[tuple[str, float], ...], Trial] = {}
        self._best: dict[float, tuple[Trial, Scene]] = {}

    @property
    def tried(self) -> tuple[Trial, ...]:
        """All trials in the order made."""
        return tuple(self._tried.values())

    @property
    def best(self) -> list[Trial]:
        """The trial with the best surrogate for every value of the setting that weighs most."""
        return [trial for trial, _ in self._best.values()]

    def attempt(self, settings: Settings) -> Trial:
        """What the surrogate says of these settings; each set is asked for once."""
        key = tuple(sorted(settings.items()))
        if key not in self._tried:
            self._tried[key] = self._estimate(settings)
        return self._tried[key]

    def _estimate(self, settings: Settings) -> Trial:
        goal = self._goal
        try:
            scene = self._stage(settings)
        except PerfQRError as error:
            return Trial(dict(settings), None, problem=str(error))
        found = legibility(scene, goal.matrix, goal.module_mm, goal.tilt_deg, look=self._look)
        trial = Trial(dict(settings), found)
        value = settings[self._weighs_most]
        if value not in self._best or trial.score > self._best[value][0].score:
            self._best[value] = trial, scene
        return trial

    def confirmed(self, trial: Trial) -> Trial:
        """One of `best` with the share of decoders x views that read it at the goal's tilt and before it."""
        if trial.legibility is None:
            return trial
        goal = self._goal
        _, scene = self._best[trial.settings[self._weighs_most]]
        views = Schedule(tuple(share * goal.tilt_deg for share in SHARES), goal.azimuths_deg).views()
        read = reads(
            scene, views, self._look, accepted(goal.payload), shared(goal.decoders),
            frames=[PATIENCE] * len(views), step=f"scan tilt {goal.tilt_deg:g}°: the panel",
        )  # fmt: skip
        rate = sum(len(names) for names in read) / (len(views) * len(goal.decoders))
        return Trial(trial.settings, trial.legibility, rate)
