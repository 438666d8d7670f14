"""The better choice of bridges: most stress removed per unit of decoding margin spent.

One adjoint solve ranks every bar; the best few are then compared exactly through Woodbury's identity, where
also their joint effect is a matter of small matrices, so bars that would do the same work are not laid twice.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp
import shapely
from numpy.typing import NDArray

from perfqr_cad.errors import DesignError
from perfqr_cad.structure.bars import bar_tensors, couplings
from perfqr_cad.structure.candidates import Candidates, lattice_candidates
from perfqr_cad.structure.measure import von_mises
from perfqr_cad.structure.reanalysis import Reanalysis, Response, stress_operator
from perfqr_cad.structure.t6 import Floats, Ints

if TYPE_CHECKING:
    from perfqr_cad.pattern import Bridge, Pattern

WIDTHS_IN_WEBS = (1.0, 1.5)
NORM = 12  # exponent of the mean that stands for the largest stress while bars are ranked
SHORT_LIST = 32  # bars compared exactly in a round
PROBES = 8  # bars whose exact flexibility stands for all in the ranking
TENSOR = 5  # components of a stress tensor here
PER_ROUND = 16  # bars laid in a round at most
MOST_ROUNDS = 6  # between two conforming meshes
AIM = 0.97  # of the limit: bars stand on the old mesh, the conforming one may say a little more
LEAST_GAIN = 1e-3  # of the stress: what a bar must take off to be laid, and to stay
BASE_PRICE = 0.2  # margin that any bar costs: two small ones are no better than one that helps
LENGTH_PRICE = 0.05  # margin that a module's length of bar costs even along module edges
CENTRE_PRICE = 0.2  # margin that a fully lightened module centre costs besides its codeword


@dataclass(frozen=True)
class _Round:
    """The exact small model of a short list: what a subset of it does at hot places, and bears."""

    now: Floats  # (rows,) tensors at the hot places
    relief: Floats  # (rows, modes): tensors per unit of mode force
    flexibility: Floats  # (modes, modes)
    strain: Floats  # (modes,) what each mode feels now
    bar_tensors: Floats  # (bars, 2, 5, modes of a bar)

    def stresses(self, chosen: list[int]) -> Floats:
        """Von Mises' stress at the hot places and at the ends of the bars with these bars laid."""
        if not chosen:
            return von_mises(self.now.reshape(-1, TENSOR))
        modes = self.bar_tensors.shape[3]
        columns = (np.array(chosen)[:, None] * modes + np.arange(modes)).ravel()
        small = np.eye(len(columns)) + self.flexibility[np.ix_(columns, columns)]
        amplitudes = np.linalg.solve(small, self.strain[columns])
        places = self.now - self.relief[:, columns] @ amplitudes
        bars = np.einsum("keam,km->kea", self.bar_tensors[chosen], amplitudes.reshape(-1, modes))
        return von_mises(np.concatenate([places.reshape(-1, TENSOR), bars.reshape(-1, TENSOR)]))


class OptimalChoice:
    """Chooses bridges by exact stress relief per decoding margin."""

    def __init__(self) -> None:
        self._limit = 0.0
        self._refused: set[tuple[float, ...]] = set()
        self._host: Floats | None = None
        self.removed = 0

    def lay(
        self, pattern: Pattern, analysis: Reanalysis, limit_mpa: float
    ) -> tuple[Pattern, list[Bridge], list[float]]:
        """Bridges until the re-analysed stress is within the limit: pattern, bridges, stress by round."""
        self._limit = limit_mpa
        web = pattern.spec.web_mm
        bars = lattice_candidates(pattern, tuple(share * web for share in WIDTHS_IN_WEBS))
        if not len(bars):
            return pattern, [], []
        coupling = couplings(analysis.model, bars)
        open_rows = np.array([_key(bars.bridge(k, 0.0)) not in self._refused for k in range(len(bars))])
        price = _price(bars, pattern.module_mm)
        laid: list[Bridge] = []
        stresses: list[float] = []
        bridged = pattern
        for _ in range(MOST_ROUNDS):
            chosen, response = self._round(analysis, bars, coupling, open_rows, price)
            if not chosen:
                break
            wanted: dict[Bridge, int] = {}
            for row in chosen:
                if open_rows[row]:  # none of those before stands in its way
                    wanted[bars.bridge(row, float(price[row]))] = row
                    open_rows &= ~_in_the_way(bars, row, pattern.spec.gap_mm)
            bridged, added = _with_those_that_fit(bridged, list(wanted))
            self._refused |= {_key(bridge) for bridge in wanted if bridge not in added}
            if not added:
                continue
            laid += added
            rows = [wanted[bridge] for bridge in added]
            analysis.add(response.take(np.concatenate([chosen[row] for row in rows])))
            stresses.append(analysis.largest)
            if stresses[-1] <= AIM * self._limit:
                break
        useful = self._useful(analysis, len(laid))
        if useful.all():
            return bridged, laid, stresses
        self.removed += int((~useful).sum())
        kept = [bridge for bridge, keep in zip(laid, useful, strict=True) if keep]
        return pattern.with_bridges(kept), kept, stresses

    def avoid(self, bridges: Sequence[Bridge], place: tuple[float, float], reach_mm: float) -> None:
        """Do not lay bridges again that end near a place they made worse; all of them if none is near."""
        ends = np.array([[b.start, b.end] for b in bridges])
        near = np.linalg.norm(ends - np.array(place), axis=2).min(axis=1) < reach_mm
        for bridge, worse in zip(bridges, near if near.any() else ~near, strict=True):
            if worse:
                self._refused.add(_key(bridge))

    def _useful(self, analysis: Reanalysis, count: int) -> NDArray[np.bool_]:
        """Which of the laid bars still take stress off, one by one in the order in which they were laid."""
        useful = np.ones(count, np.bool_)
        if count < 2:
            return useful
        hot, _ = analysis.hot_places
        seen = analysis.subset(stress_operator(analysis.model, analysis.discs, hot))
        modes = analysis.modes // count

        def norm(bars: NDArray[np.bool_]) -> float:
            return _norm(von_mises(seen(np.repeat(bars, modes)).reshape(-1, TENSOR)))

        today = norm(useful)
        for k in range(count):
            without = useful.copy()
            without[k] = False
            if norm(without) < (1.0 + LEAST_GAIN) * today:
                useful = without
        return useful

    def _round(
        self,
        analysis: Reanalysis,
        bars: Candidates,
        coupling: sp.csc_matrix,
        open_rows: NDArray[np.bool_],
        price: Floats,
    ) -> tuple[dict[int, Ints], Response]:
        """Bars worth laying together now, best first, and the columns of each in the response."""
        hot, measure = analysis.hot_places
        nothing: dict[int, Ints] = {}
        if measure[0] <= AIM * self._limit or not open_rows.any():
            return nothing, analysis.respond(_columns(coupling, [], len(bars)))
        operator = stress_operator(analysis.model, analysis.discs, hot)
        now = operator @ analysis.displacement
        adjoint = analysis.solve(np.where(analysis.model.fixed, 0.0, operator.T @ _gradient(now, len(hot))))
        short = self._short_list(analysis, coupling, adjoint, price, open_rows)
        columns = _columns(coupling, short.tolist(), len(bars))
        response = analysis.respond(columns)
        if not len(short):
            return nothing, response
        modes = (len(coupling.indptr) - 1) // len(bars)
        own = bar_tensors(analysis.model.section, analysis.model.wall_mm, bars.take(short), modes)
        exact = _Round(
            now=now,
            relief=analysis.between(sp.csc_matrix(operator.T), response),
            flexibility=analysis.between(response.coupling, response),
            strain=columns.T @ analysis.displacement,
            bar_tensors=own,
        )
        chosen = self._greedy(exact, price[short])
        return {int(short[k]): k * modes + np.arange(modes) for k in chosen}, response

    def _short_list(
        self,
        analysis: Reanalysis,
        coupling: sp.csc_matrix,
        adjoint: Floats,
        price: Floats,
        open_rows: NDArray[np.bool_],
    ) -> Ints:
        """The bars that promise most by first-order sensitivity per price."""
        modes = (len(coupling.indptr) - 1) // len(price)
        strain = (coupling.T @ analysis.displacement).reshape(-1, modes)
        wish = (coupling.T @ adjoint).reshape(-1, modes)
        # A bar far stiffer than the part takes what the part yields, not what its own stiffness asks for.
        host = self._host_flexibility(analysis, coupling, open_rows, modes)
        gain = (strain * wish / (1.0 + host)).sum(axis=1) / price
        gain[~open_rows] = -np.inf
        order = np.argsort(-gain, kind="stable")[:SHORT_LIST]
        return order[gain[order] > 0.0]

    def _host_flexibility(
        self, analysis: Reanalysis, coupling: sp.csc_matrix, open_rows: NDArray[np.bool_], modes: int
    ) -> Floats:
        """Typical flexibility of the part under each mode of a bar, from an even sample; computed once."""
        if self._host is None:
            rows = np.flatnonzero(open_rows)
            sample = rows[np.linspace(0, len(rows) - 1, min(PROBES, len(rows))).astype(int)]
            columns = _columns(coupling, sample.tolist(), len(open_rows))
            own = np.diag(analysis.between(columns, analysis.respond(columns)))
            self._host = np.median(own.reshape(-1, modes), axis=0)
        return self._host

    def _greedy(self, exact: _Round, price: Floats) -> list[int]:
        """Positions in the short list, added one by one as long as they pay."""
        chosen: list[int] = []
        today = exact.stresses([])
        stress, places = _norm(today), len(today)
        while len(chosen) < PER_ROUND and len(chosen) < len(price):
            rest = [k for k in range(len(price)) if k not in chosen]
            after = np.array([_norm(exact.stresses([*chosen, k]), places) for k in rest])
            gain = (stress - after) / price[rest]
            best = int(np.argmax(gain))
            if stress - after[best] < LEAST_GAIN * stress:
                break
            chosen.append(rest[best])
            stress = float(after[best])
            if exact.stresses(chosen).max() <= AIM * self._limit:
                break
        return chosen


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


def _norm(stress: Floats, places: int | None = None) -> float:
    """A smooth stand-in for the largest stress: its NORM-mean, over `places` of them."""
    top = float(stress.max())
    if top <= 0.0:
        return 0.0
    return top * float(((stress / top) ** NORM).sum() / (places or len(stress))) ** (1.0 / NORM)


def _gradient(tensors: Floats, places: int) -> Floats:
    """Derivative of the NORM-mean's power sum by each tensor component, to scale only: it ranks."""
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


def _columns(coupling: sp.csc_matrix, rows: list[int], count: int) -> sp.csc_matrix:
    """The columns of C that belong to some bars."""
    modes = (len(coupling.indptr) - 1) // count
    return sp.csc_matrix(coupling[:, (np.array(rows, np.int64)[:, None] * modes + np.arange(modes)).ravel()])


def _in_the_way(bars: Candidates, row: int, gap_mm: float) -> NDArray[np.bool_]:
    """The bars that would leave less than the least gap to one that is laid, or cross it."""
    lines = shapely.linestrings(np.stack([bars.start, bars.end], axis=1))
    clear = 0.5 * (bars.width_mm + bars.width_mm[row]) + gap_mm
    return np.asarray(shapely.distance(lines, np.asarray(lines)[row])) < clear
