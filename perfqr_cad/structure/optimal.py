"""The better choice of bridges: most stress removed per unit of decoding margin spent.

One adjoint solve ranks every bar. The best few that do not stand in each other's way are then compared exactly,
singly and together, and many are laid at once (see `relief`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from perfqr_cad.errors import DesignError
from perfqr_cad.structure.bars import bar_tensors, couplings, places_under
from perfqr_cad.structure.candidates import Candidates, lattice_candidates
from perfqr_cad.structure.measure import von_mises
from perfqr_cad.structure.reanalysis import Reanalysis, Response, stress_operator
from perfqr_cad.structure.relief import NORM, TENSOR, Shortlist, greedy, power_mean
from perfqr_cad.structure.t6 import Floats, Ints

if TYPE_CHECKING:
    from perfqr_cad.pattern import Bridge, Pattern

WIDTHS_IN_WEBS = (1.0, 1.5)
SHORT_LIST = 32  # bars compared exactly in a round
RIVALS = 1  # of bars in each other's way, how many are compared
PROBES = 8  # bars whose exact flexibility stands for all in the ranking
PER_ROUND = 32  # bars laid in a round at most
MOST_ROUNDS = 8  # between two conforming meshes
AIM = 0.97  # of the limit: bars stand on the old mesh, the conforming one may say a little more
LEAST_GAIN = 1e-3  # of the stress: what a bar must take off to be laid, and to stay
BASE_PRICE = 0.2  # margin that any bar costs: two small ones are no better than one that helps
LENGTH_PRICE = 0.05  # margin that a module's length of bar costs even along module edges
CENTRE_PRICE = 0.2  # margin that a fully lightened module centre costs besides its codeword

Flags = NDArray[np.bool_]


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

    def __init__(self) -> None:
        self._refused: set[tuple[float, ...]] = set()
        self.removed = 0

    def lay(
        self, pattern: Pattern, analysis: Reanalysis, limit_mpa: float
    ) -> tuple[Pattern, list[Bridge], list[float]]:
        """Bridges until the re-analysed stress is within the limit: pattern, bridges, stress by round."""
        web, gap = pattern.spec.web_mm, pattern.spec.gap_mm
        bars = lattice_candidates(pattern, tuple(share * web for share in WIDTHS_IN_WEBS))
        if not len(bars):
            return pattern, [], []
        offer = _Offer(bars, couplings(analysis.model, bars), _price(bars, pattern.module_mm))
        is_open = np.array([_key(offer.bridge(k)) not in self._refused for k in range(len(bars))])
        host = _host_flexibility(analysis, offer)
        laid: list[int] = []
        stresses: list[float] = []
        for _ in range(MOST_ROUNDS):
            today = analysis.largest
            if today <= AIM * limit_mpa:
                break
            chosen, response = _round(analysis, offer, is_open, host, AIM * limit_mpa, gap)
            if not len(chosen):
                break
            analysis.add(response, places_under(analysis.model.mesh, bars.take(chosen)))
            if analysis.largest > (1.0 - LEAST_GAIN) * today:  # nothing reaches the weakest place
                analysis.drop(len(chosen) * offer.modes)
                break
            laid += chosen.tolist()
            for row in chosen:
                is_open &= ~bars.in_the_way_of(row, gap)
            stresses.append(analysis.largest)
        wanted = [offer.bridge(row) for row in np.array(laid)[_useful(analysis, len(laid))].tolist()]
        self.removed += len(laid) - len(wanted)
        bridged, fitting = _with_those_that_fit(pattern, wanted)
        self._refused |= {_key(bridge) for bridge in wanted if bridge not in fitting}
        return bridged, fitting, stresses

    def avoid(self, bridges: Sequence[Bridge], place: tuple[float, float], reach_mm: float) -> None:
        """Do not lay bridges again that end near a place they made worse; all of them if none is near."""
        ends = np.array([[b.start, b.end] for b in bridges])
        near = np.linalg.norm(ends - np.array(place), axis=2).min(axis=1) < reach_mm
        for bridge, worse in zip(bridges, near if near.any() else ~near, strict=True):
            if worse:
                self._refused.add(_key(bridge))


def _round(
    analysis: Reanalysis, offer: _Offer, is_open: Flags, host: Floats, aim_mpa: float, gap_mm: float
) -> tuple[Ints, Response]:
    """Rows of the bars worth laying together now, best first, and their response."""
    hot, _ = analysis.hot_places
    operator = stress_operator(analysis.model, analysis.discs, hot)
    now = operator @ analysis.displacement
    adjoint = analysis.solve(np.where(analysis.model.fixed, 0.0, operator.T @ _gradient(now, len(hot))))
    short = _short_list(analysis, offer, adjoint, host, is_open, gap_mm)
    response = analysis.respond(offer.columns(short))
    if not len(short):
        return short, response
    bars, modes, count = offer.bars.take(short), offer.modes, len(short)
    layers = len(now) // (TENSOR * len(hot))
    exact = Shortlist(
        now=now.reshape(-1, TENSOR),
        relief=analysis.between(sp.csc_matrix(operator.T), response).reshape(len(now), count, modes),
        flexibility=analysis.between(response.coupling, response).reshape(count, modes, count, modes),
        strain=(response.coupling.T @ analysis.displacement).reshape(count, modes),
        own=bar_tensors(analysis.model.section, analysis.model.wall_mm, bars, modes),
        under=np.repeat(bars.cover(analysis.model.mesh.nodes[hot]), layers, axis=0),
        clash=np.stack([bars.in_the_way_of(k, gap_mm) for k in range(count)]),
    )
    chosen = np.array(greedy(exact, offer.price[short], aim_mpa, LEAST_GAIN, PER_ROUND), np.int64)
    return short[chosen], response.take(block(chosen, modes))


def _short_list(
    analysis: Reanalysis, offer: _Offer, adjoint: Floats, host: Floats, is_open: Flags, gap_mm: float
) -> Ints:
    """Rows of the bars that promise most by first-order sensitivity per price, few in each other's way."""
    strain = (offer.coupling.T @ analysis.displacement).reshape(-1, offer.modes)
    wish = (offer.coupling.T @ adjoint).reshape(-1, offer.modes)
    # A bar far stiffer than the part takes what the part yields, not what its own stiffness asks for.
    gain = (strain * wish / (1.0 + host)).sum(axis=1) / offer.price
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
    """Which of the laid bars still take stress off, one by one in the order in which they were laid."""
    useful = np.ones(count, np.bool_)
    if count < 2:
        return useful
    hot, _ = analysis.hot_places
    seen = analysis.subset(stress_operator(analysis.model, analysis.discs, hot))
    modes = analysis.modes // count

    def stress(bars: Flags) -> float:
        return float(power_mean(von_mises(seen(np.repeat(bars, modes)).reshape(-1, TENSOR))))

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


def _key(bridge: Bridge) -> tuple[float, ...]:
    """A bar as rounded numbers: candidates are found anew for each pattern."""
    return tuple(round(x, 3) for x in (*bridge.start, *bridge.end, bridge.width_mm))


def _price(bars: Candidates, module_mm: float) -> Floats:
    """Decoding margin that each bar costs."""
    return (
        BASE_PRICE
        + bars.loss.clip(0.0)
        + CENTRE_PRICE * bars.covered
        + LENGTH_PRICE * bars.length_mm / module_mm
    )


def _gradient(tensors: Floats, places: int) -> Floats:
    """Derivative of the power mean's sum by each tensor component, to scale only: it ranks."""
    parts = tensors.reshape(places, -1, TENSOR)
    stress = von_mises(parts)
    weight = (stress / stress.max()) ** (NORM - 1) / np.maximum(stress, np.finfo(float).tiny)
    xx, yy, xy, xz, yz = np.moveaxis(parts, -1, 0)
    slope = np.stack([xx - 0.5 * yy, yy - 0.5 * xx, 3.0 * xy, 3.0 * xz, 3.0 * yz], axis=-1)
    return (weight[..., None] * slope).ravel()


def _with_those_that_fit(pattern: Pattern, bridges: list[Bridge]) -> tuple[Pattern, list[Bridge]]:
    """The pattern with these bridges less those that break one of its rules; sought by halving."""
    if not bridges:
        return pattern, []
    try:
        return pattern.with_bridges(bridges), bridges
    except DesignError:
        if len(bridges) == 1:
            return pattern, []
    half = len(bridges) // 2
    pattern, first = _with_those_that_fit(pattern, bridges[:half])
    pattern, rest = _with_those_that_fit(pattern, bridges[half:])
    return pattern, first + rest
