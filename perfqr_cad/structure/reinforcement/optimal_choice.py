"""The better choice of bridges: most stress removed per unit of decoding margin spent.

One adjoint solve ranks every bar. The best few that do not stand in each other's way are then compared
exactly, singly and together, and many are added at once (see `relief`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from perfqr_cad.errors import DesignError
from perfqr_cad.structure.measure import von_mises
from perfqr_cad.structure.mesh.triangle import Floats, Ints
from perfqr_cad.structure.reinforcement.bar_candidates import Allowance, Budget, Candidates
from perfqr_cad.structure.reinforcement.bar_stiffness import bar_tensors, couplings, places_under
from perfqr_cad.structure.reinforcement.lattice_bars import lattice_candidates
from perfqr_cad.structure.reinforcement.reanalysis import Reanalysis, Response, Watch
from perfqr_cad.structure.reinforcement.relief import TENSOR, Shortlist, greedy, power_mean, power_mean_slope

if TYPE_CHECKING:
    from perfqr_cad.pattern import Bridge, Pattern

WIDTHS_IN_WEBS = (1.0, 1.5)
SHORT_LIST = 32  # bars compared exactly in a round
RIVALS = 1  # of bars in each other's way, how many are compared
PROBES = 8  # bars whose exact flexibility stands for all in the ranking
PER_ROUND = 32  # bars added in a round at most
MOST_ROUNDS = 12  # between two conforming meshes
ROUND_GAIN = 0.01  # of the stress: a round that takes less off is the last one
WEAK_SLACK = 0.03  # above the least stress: where a part stays too weak, bars that gain less are not worth it
AIM = 0.94  # of the limit: what a conforming mesh says of bars may be some per cent more
LEAST_GAIN = 1e-3  # of the stress: what a bar must take off to be added, and to stay
BASE_PRICE = 0.2  # margin that any bar costs: two small ones are no better than one that helps
LENGTH_PRICE = 0.05  # margin that a module's length of bar costs even along module edges
CENTRE_PRICE = 0.2  # margin that a fully lightened module centre costs besides its codeword

Flags = NDArray[np.bool_]
Key = tuple[int, ...]


@dataclass(frozen=True)
class _Offer:
    """The bars of a pattern, their coupling C to the part, d columns each, and their prices."""

    bars: Candidates
    coupling: sp.csc_matrix
    price: Floats

    @property
    def modes(self) -> int:
        """Columns d of C for each bar."""
        return (len(self.coupling.indptr) - 1) // len(self.bars)

    def columns(self, rows: Ints) -> sp.csc_matrix:
        """The columns of C that belong to some bars."""
        return sp.csc_matrix(self.coupling[:, block(rows, self.modes)])

    def bridge(self, row: int) -> Bridge:
        """A bar as a bridge."""
        return self.bars.bridge(row, float(self.price[row]))


class OptimalChoice:
    """Chooses bridges by exact stress relief per decoding margin."""

    def __init__(self, allowance: Allowance, spends: bool = True) -> None:
        self._allowance = allowance
        self._spends = spends  # codewords, once ties that cost none no longer help
        self._refused: set[Key] = set()
        self.removed = 0

    def add_bridges(
        self, pattern: Pattern, analysis: Reanalysis, limit_mpa: float
    ) -> tuple[Pattern, list[Bridge], list[float]]:
        """Bridges until the re-analysed stress is within the limit: pattern, bridges, stress by round."""
        web, gap, aim = pattern.spec.web_mm, pattern.spec.gap_mm, AIM * limit_mpa
        bars = lattice_candidates(pattern, self._allowance, tuple(share * web for share in WIDTHS_IN_WEBS))
        if not len(bars):
            return pattern, [], []
        budget = Budget(pattern, self._allowance)
        offer = _Offer(bars, couplings(analysis.model, bars), _price(bars, pattern.module_mm))
        is_open = np.array([key not in self._refused for key in _keys(bars)])
        is_free = bars.loss <= 0.0
        costly = is_open & ~is_free if self._spends else np.zeros_like(is_free)
        is_open &= is_free
        host = _host_flexibility(analysis, offer)
        added: list[Ints] = []
        stresses = [analysis.largest]
        while stresses[-1] > aim and len(added) < MOST_ROUNDS:
            chosen, response = _round(analysis, offer, is_open, host, aim, gap)
            kept = np.array([budget.spend(bars.turned[row]) for row in chosen], np.bool_)
            is_open[chosen[~kept]] = False
            if not len(chosen):
                if not costly.any():
                    break
                is_open, costly = costly, np.zeros_like(costly)
                continue
            if not kept.any():
                continue
            for row in chosen[kept]:
                clear = ~bars.in_the_way_of(row, gap)
                is_open, costly = is_open & clear, costly & clear
            response = response.take(block(np.flatnonzero(kept), offer.modes))
            new = bars.take(chosen[kept])
            own = bar_tensors(analysis.model.section, analysis.model.wall_mm, new, offer.modes)
            analysis.add(response, own, places_under(analysis.model.mesh, new))
            added.append(chosen[kept])
            stresses.append(analysis.largest)
            if stresses[-1] > (1.0 - ROUND_GAIN) * stresses[-2]:
                if not costly.any():
                    break
                is_open, costly = is_open | costly, np.zeros_like(costly)
        rounds = worth(stresses, aim)
        analysis.drop(offer.modes * sum(len(rows) for rows in added[rounds:]))
        rows = np.concatenate([np.zeros(0, np.int64), *added[:rounds]])
        useful = _useful(analysis, len(rows))
        self.removed += int((~useful).sum())
        bridged, fitting = self._fitted(pattern, [offer.bridge(row) for row in rows[useful].tolist()])
        return bridged, fitting, stresses[1 : rounds + 1]

    def avoid(self, bridges: Sequence[Bridge], place: tuple[float, float], reach_mm: float) -> None:
        """Do not add bridges again that end near a place they made worse; all of them if none is near."""
        ends = np.array([[b.start, b.end] for b in bridges])
        near = np.linalg.norm(ends - np.array(place), axis=2).min(axis=1) < reach_mm
        for bridge, worse in zip(bridges, near if near.any() else ~near, strict=True):
            if worse:
                self._refused.add(_key(bridge))

    def _fitted(self, pattern: Pattern, bridges: list[Bridge]) -> tuple[Pattern, list[Bridge]]:
        """The pattern with these bridges less those that break one of its rules, sought by halving."""
        if not bridges:
            return pattern, []
        try:
            bridged = pattern.with_bridges(bridges)
        except DesignError:
            bridged = None
        if bridged is not None and self._allowance.covers(bridged.readability):
            return bridged, bridges
        if len(bridges) == 1:
            self._refused.add(_key(bridges[0]))
            return pattern, []
        half = len(bridges) // 2
        pattern, first = self._fitted(pattern, bridges[:half])
        pattern, rest = self._fitted(pattern, bridges[half:])
        return pattern, first + rest


def worth(stresses: Sequence[float], aim_mpa: float) -> int:
    """How many rounds to keep, given the stress before the first and after each: if the aim is not reached,
    the fewest that come close to the best of them."""
    best = max(aim_mpa, min(stresses) * (1.0 + WEAK_SLACK))
    return next(k for k, stress in enumerate(stresses) if stress <= best)


def _round(
    analysis: Reanalysis, offer: _Offer, is_open: Flags, host: Floats, aim_mpa: float, gap_mm: float
) -> tuple[Ints, Response]:
    """Rows of the bars worth adding together now, best first, and their response."""
    watch = analysis.watch()
    now, load = [watch.tensors(analysis.displacements)], [watch.load]
    if analysis.modes:
        in_bars = analysis.in_bars().reshape(analysis.loads, -1, TENSOR)
        now.append(in_bars.reshape(-1, TENSOR))
        load.append(np.repeat(np.arange(analysis.loads), in_bars.shape[1]))
    short = _short_list(analysis, offer, _adjoint(analysis, watch, now), host, is_open, gap_mm)
    response = analysis.respond(offer.columns(short))
    if not len(short):
        return short, response
    bars, modes, count = offer.bars.take(short), offer.modes, len(short)
    relief = [analysis.between(sp.csc_matrix(watch.operator.T), response)]
    if analysis.modes:
        relief.append(np.tile(analysis.relief_in_bars(response), (analysis.loads, 1)))
    under = bars.cover(watch.places_mm)
    tensors = np.concatenate(now)
    exact = Shortlist(
        now=tensors,
        load=np.concatenate(load),
        relief=np.concatenate(relief).reshape(-1, count, modes),
        flexibility=analysis.between(response.coupling, response).reshape(count, modes, count, modes),
        strain=(response.coupling.T @ analysis.displacements).reshape(count, modes, -1),
        own=bar_tensors(analysis.model.section, analysis.model.wall_mm, bars, modes),
        under=np.pad(under, ((0, len(tensors) - len(under)), (0, 0))),
        clash=np.stack([bars.in_the_way_of(k, gap_mm) for k in range(count)]),
    )
    chosen = np.array(greedy(exact, offer.price[short], aim_mpa, LEAST_GAIN, PER_ROUND), np.int64)
    return short[chosen], response.take(block(chosen, modes))


def _adjoint(analysis: Reanalysis, watch: Watch, now: Sequence[Floats]) -> Floats:
    """The displacements (n·d, loads) whose work with any forces is what these take off the power mean,
    scaled."""
    slope = power_mean_slope(np.concatenate(now))
    at_places = watch.pull(slope[: len(watch.load)])
    at_places = np.pad(at_places, ((0, 0), (0, analysis.loads - at_places.shape[1])))
    pull = analysis.solve(np.where(analysis.model.fixed[:, None], 0.0, at_places))
    if analysis.modes:
        pull += analysis.pull_of_bars(slope[len(watch.load) :].reshape(analysis.in_bars().shape))
    return pull


def _short_list(
    analysis: Reanalysis, offer: _Offer, adjoint: Floats, host: Floats, is_open: Flags, gap_mm: float
) -> Ints:
    """Rows of the bars that promise most by first-order sensitivity per price, few in each other's way."""
    strain = (offer.coupling.T @ analysis.displacements).reshape(-1, offer.modes, analysis.loads)
    wish = (offer.coupling.T @ adjoint).reshape(strain.shape)
    # A bar far stiffer than the part takes what the part yields, not what its own stiffness asks for.
    gain = ((strain * wish).sum(axis=2) / (1.0 + host)).sum(axis=1) / offer.price
    gain[~is_open] = 0.0
    rivals = np.zeros(len(gain), np.int64)
    short: list[int] = []
    for row in np.argsort(-gain, kind="stable"):
        if len(short) == SHORT_LIST or gain[row] <= 0.0:
            break
        if rivals[row] < RIVALS:
            short.append(int(row))
            rivals += offer.bars.in_the_way_of(row, gap_mm)
    return np.array(short, np.int64)


def _host_flexibility(analysis: Reanalysis, offer: _Offer) -> Floats:
    """Typical flexibility of the part under each mode of a bar, from an even sample."""
    count = len(offer.bars)
    sample = np.linspace(0, count - 1, min(PROBES, count)).astype(np.int64)
    response = analysis.respond(offer.columns(sample))
    own = np.diag(analysis.between(response.coupling, response))
    return np.median(own.reshape(-1, offer.modes), axis=0)


def _useful(analysis: Reanalysis, count: int) -> Flags:
    """Which of the added bars still take stress off, one by one in the order in which they were added."""
    useful = np.ones(count, np.bool_)
    if count < 2:
        return useful
    seen = analysis.subset(analysis.watch())
    modes = analysis.modes // count

    def stress(bars: Flags) -> float:
        return float(power_mean(von_mises(seen(np.repeat(bars, modes)))))

    today = stress(useful)
    for k in range(count):
        without = useful.copy()
        without[k] = False
        if stress(without) < (1.0 + LEAST_GAIN) * today:
            useful = without
    return useful


def block(rows: Ints, modes: int) -> Ints:
    """Numbers of the columns that belong to some rows of `modes` columns each."""
    return (rows[:, None] * modes + np.arange(modes)).ravel()


def _key(bridge: Bridge) -> Key:
    """A bar as whole micrometres: candidates are found anew for each pattern."""
    return _keys_of(np.array([[*bridge.start, *bridge.end, bridge.width_mm]]))[0]


def _keys(bars: Candidates) -> list[Key]:
    return _keys_of(np.concatenate([bars.start, bars.end, bars.width_mm[:, None]], axis=1))


def _keys_of(numbers_mm: Floats) -> list[Key]:
    return list(map(tuple, np.rint(1e3 * numbers_mm).astype(np.int64).tolist()))


def _price(bars: Candidates, module_mm: float) -> Floats:
    """Decoding margin that each bar costs."""
    return (
        BASE_PRICE
        + bars.loss.clip(0.0)
        + CENTRE_PRICE * bars.covered
        + LENGTH_PRICE * bars.length_mm / module_mm
    )
