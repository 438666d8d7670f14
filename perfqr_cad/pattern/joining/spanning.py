"""The cheapest set of links that joins all islands, with a proof (HiGHS).

A link joins two islands, or three through a junction, at a price; some links cost codewords, which are paid
once however many links share them. This is the minimum spanning tree problem in a hypergraph with fixed
charges:

    minimise    Σ price·x + CODEWORD_PRICE·Σ y
    subject to  Σ (parts that F touches − 1)·x_F ≥ parts − 1    for partitions of the islands
                x_F ≤ y_c                                       for each codeword c that F loses

The partitions that Kruskal's algorithm passes through make the linear relaxation exact for plain trees; the
pieces of a solution that is not connected give the next inequality, until it is.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from scipy.cluster.hierarchy import DisjointSet

CODEWORD_PRICE = 1000.0  # expected misread modules: more than all links of a pattern together can cost
MOST_PARTITIONS = 60  # of Kruskal's; the others come back as cuts where they are needed
LEAST_NODES = 10  # what one run of the solver counts for at least: its root alone takes work
SOLVER_TOL = 1e-7  # HiGHS's own tolerance on a constraint


class Optimality(NamedTuple):
    """What the solver proved about the chosen bridges."""

    objective: float
    bound: float
    gap: float


@dataclass(frozen=True)
class Link:
    """A way to join islands: which, at what price, and which codewords it turns wrong."""

    islands: tuple[int, ...]
    price: float
    codewords: frozenset[int] = frozenset()

    @property
    def full_price(self) -> float:
        return self.price + CODEWORD_PRICE * len(self.codewords)


@dataclass(frozen=True)
class Conflict:
    """Links that are harmless alone but together turn codewords wrong."""

    links: tuple[int, ...]
    codewords: frozenset[int]


def kruskal(links: Sequence[Link], taken: Sequence[int] = ()) -> list[int]:
    """Links of a spanning tree by rising price, after those that are taken already."""
    islands = _islands_of(links)
    for k in taken:
        unite(islands, links[k].islands)
    by_price = sorted(range(len(links)), key=lambda k: links[k].full_price)
    return [*taken, *(k for k in by_price if unite(islands, links[k].islands))]


def cheapest(
    links: Sequence[Link], conflicts: Sequence[Conflict], most_nodes: int
) -> tuple[list[int], Optimality]:
    """Indices of the chosen links, and what was proved about them within so many nodes of the search."""
    chosen = kruskal(links)
    model = _Model(links, conflicts, chosen)
    bound = 0.0
    while most_nodes > 0:
        answer = model.solve(most_nodes)
        most_nodes -= max(int(answer.mip_node_count or 0), LEAST_NODES)
        if answer.mip_dual_bound is not None and np.isfinite(answer.mip_dual_bound):
            bound = max(bound, float(answer.mip_dual_bound))
        if answer.x is None:
            break
        picked = [k for k in range(len(links)) if answer.x[k] > 0.5]
        islands = _islands_of(links)
        for k in picked:
            unite(islands, links[k].islands)
        whole = kruskal(links, picked)
        if cost(links, conflicts, whole) < cost(links, conflicts, chosen):
            chosen = whole
        if islands.n_subsets == 1:
            break
        model.add_pieces(_partition(islands))
    return chosen, proved(cost(links, conflicts, chosen), bound)


def cost(links: Sequence[Link], conflicts: Sequence[Conflict], chosen: Sequence[int]) -> float:
    """The price of a choice of links, each lost codeword counted once."""
    taken = set(chosen)
    lost = set[int]().union(*(links[k].codewords for k in chosen))
    for conflict in conflicts:
        if taken.issuperset(conflict.links):
            lost |= conflict.codewords
    return sum(links[k].price for k in chosen) + CODEWORD_PRICE * len(lost)


def proved(price: float, bound: float) -> Optimality:
    """What is known of a price, given a lower bound."""
    bound = min(bound, price)  # the solver's bound carries its own rounding
    gap = (price - bound) / price if price > 0 else 0.0
    return Optimality(price, bound, gap if gap > SOLVER_TOL else 0.0)


class _Model:
    """The integer programme; inequalities are added as solutions fall apart."""

    def __init__(self, links: Sequence[Link], conflicts: Sequence[Conflict], tree: Sequence[int]) -> None:
        codewords = set[int]().union(*(link.codewords for link in links), *(c.codewords for c in conflicts))
        self._links = links
        self._codeword = {c: len(links) + k for k, c in enumerate(sorted(codewords))}
        self._rows: list[dict[int, float]] = []
        self._lower: list[float] = []
        for k, link in enumerate(links):
            for c in sorted(link.codewords):
                self._add({self._codeword[c]: 1.0, k: -1.0}, 0.0)
        for conflict in conflicts:
            for c in sorted(conflict.codewords):
                row = {self._codeword[c]: 1.0} | dict.fromkeys(conflict.links, -1.0)
                self._add(row, 1.0 - len(conflict.links))
        islands = _islands_of(links)
        kept = {round(k) for k in np.linspace(0, len(tree) - 1, MOST_PARTITIONS)}
        for k, link in enumerate(tree):
            if k in kept:
                self.add_partition(_partition(islands))
            unite(islands, links[link].islands)

    def add_pieces(self, part: dict[int, int]) -> None:
        """The parts must hold together, and each of them to the rest."""
        self.add_partition(part)
        for piece in sorted(set(part.values())):
            self.add_partition({i: int(p == piece) for i, p in part.items()})

    def add_partition(self, part: dict[int, int]) -> None:
        """The links must hold the parts together."""
        row: dict[int, float] = {}
        for k, link in enumerate(self._links):
            touched = len({part[i] for i in link.islands})
            if touched > 1:
                row[k] = touched - 1.0
        self._add(row, len(set(part.values())) - 1.0)

    def _add(self, row: dict[int, float], lower: float) -> None:
        self._rows.append(row)
        self._lower.append(lower)

    def solve(self, most_nodes: int) -> Any:
        from scipy.optimize import Bounds, LinearConstraint, milp
        from scipy.sparse import csr_array

        counts = [len(row) for row in self._rows]
        matrix = csr_array(
            (
                np.array([v for row in self._rows for v in row.values()]),
                np.array([k for row in self._rows for k in row], np.int64),
                np.concatenate([[0], np.cumsum(counts)]),
            ),
            shape=(len(self._rows), len(self._links) + len(self._codeword)),
        )
        price = [link.price for link in self._links] + [CODEWORD_PRICE] * len(self._codeword)
        return milp(
            np.array(price),
            integrality=np.ones(len(price)),
            bounds=Bounds(0, 1),
            constraints=LinearConstraint(matrix, self._lower, np.inf),  # pyright: ignore[reportArgumentType]
            options={"node_limit": most_nodes, "mip_rel_gap": 0.0},
        )


def disjoint(members: Iterable[int]) -> DisjointSet:
    """Each member in a set of its own; scipy's module is imported on first use, for it is heavy."""
    from scipy.cluster.hierarchy import DisjointSet

    return DisjointSet(members)


def _islands_of(links: Iterable[Link]) -> DisjointSet:
    """All islands that the links name, none of them joined."""
    return disjoint(island for link in links for island in link.islands)


def unite(sets: DisjointSet, members: Sequence[int]) -> bool:
    """Makes one set of those that the members lie in; whether there was more than one."""
    merged = [sets.merge(members[0], other) for other in members[1:]]
    return any(merged)


def _partition(sets: DisjointSet) -> dict[int, int]:
    """A member that stands for its set, for each member."""
    return {member: sets[member] for member in sorted(sets)}
