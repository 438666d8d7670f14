"""The cheapest choice of pairs and junctions when no link costs a codeword, by branch and bound.

An optimal choice needs no pair outside the minimum spanning tree of the pairs. To build a junction of three
islands saves the dearest edges of the tree that it makes superfluous; taking it merges its islands. What a
junction saves never grows as others are taken (the saving is submodular, as the rank of a matroid), so one
that saves less than it costs can be dropped, and the sum of all gains bounds what any choice can gain.
Junctions that share no edge of the tree on their ways do not touch each other: they fall into blocks.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

from perfqr_cad.pattern.joining.spanning import SOLVER_TOL, Link, Optimality, disjoint, kruskal, proved, unite

LARGEST_BLOCK = 24  # junctions that branch and bound sorts out in a moment; of more, so many at a time


class Edge(NamedTuple):
    """An edge of the tree."""

    a: int
    b: int
    price: float


Edges = dict[int, Edge]


class Junction(NamedTuple):
    """A junction by its number, the islands that it joins, and its price."""

    number: int
    islands: tuple[int, ...]
    price: float


@dataclass(frozen=True, eq=False)
class Offer:
    """What a junction would change: the edges on its ways, those it replaces, and what is gained."""

    junction: Junction
    ways: frozenset[int]
    replaced: frozenset[int]
    gain: float


class Choice(NamedTuple):
    """Junctions to take, what they gain, and the most that any choice could gain."""

    gain: float
    most: float
    taken: tuple[int, ...]


def cheapest_without_loss(pairs: Sequence[Link], stars: Sequence[Link]) -> tuple[list[int], Optimality]:
    """Indices into pairs + stars of the cheapest choice, and the proof."""
    links = [*pairs, *stars]
    tree = {k: Edge(pairs[k].islands[0], pairs[k].islands[1], pairs[k].price) for k in kruskal(pairs)}
    junctions = [Junction(k, star.islands, star.price) for k, star in enumerate(stars, start=len(pairs))]
    whole = sum(edge.price for edge in tree.values())
    choice = _best(tree, junctions)
    usable = [*range(len(pairs)), *choice.taken]
    chosen = kruskal([links[k] for k in usable], taken=range(len(pairs), len(usable)))
    result = sorted(usable[k] for k in chosen)
    return result, proved(sum(links[k].price for k in result), whole - choice.most)


def _best(tree: Edges, junctions: Sequence[Junction]) -> Choice:
    """The junctions that gain most on a forest."""
    gain = most = 0.0
    taken: list[int] = []
    for block in _blocks(_offers(tree, junctions)):
        solve = _best_of_block if len(block) <= LARGEST_BLOCK else _good_of_large_block
        choice = solve({k: tree[k] for k in frozenset[int]().union(*(o.ways for o in block))}, block)
        gain, most = gain + choice.gain, most + choice.most
        taken += choice.taken
    return Choice(gain, most, tuple(taken))


def _best_of_block(tree: Edges, block: Sequence[Offer]) -> Choice:
    """Branches on the junction that touches most others: taken first, then not, if that can gain more."""
    if len(block) == 1:
        return Choice(block[0].gain, block[0].gain, (block[0].junction.number,))
    pivot = max(block, key=lambda o: (sum(not o.ways.isdisjoint(p.ways) for p in block), o.gain))
    others = [offer.junction for offer in block if offer is not pivot]
    rest = _best(*_contracted(tree, others, pivot))
    found = Choice(pivot.gain + rest.gain, pivot.gain + rest.most, (pivot.junction.number, *rest.taken))
    if sum(offer.gain for offer in block if offer is not pivot) <= found.gain + SOLVER_TOL:
        return found
    other = _best(tree, others)
    return max(found, other, key=lambda choice: choice.gain)._replace(most=max(found.most, other.most))


def _good_of_large_block(tree: Edges, block: Sequence[Offer]) -> Choice:
    """Group by group of neighbours: each is solved after the ones before, and alone for the bound.

    What a choice gains is at most the sum of what its parts in each group would gain alone.
    """
    ordered = [o.junction for o in sorted(block, key=lambda o: (min(o.ways), o.junction.number))]
    starts = range(0, len(ordered), LARGEST_BLOCK)
    most = sum(_best(tree, ordered[k : k + LARGEST_BLOCK]).most for k in starts)
    gain = 0.0
    taken: list[int] = []
    for k in starts:
        choice = _best(tree, ordered[k : k + LARGEST_BLOCK])
        gain += choice.gain
        taken += choice.taken
        for at in [at for at, junction in enumerate(ordered) if junction.number in choice.taken]:
            (offer,) = _offers(tree, [ordered[at]], least=-math.inf)
            tree, ordered = _contracted(tree, ordered, offer)
    return Choice(gain, most, tuple(taken))


def _contracted(tree: Edges, junctions: Sequence[Junction], taken: Offer) -> tuple[Edges, list[Junction]]:
    """The tree without the edges that a junction replaces and with its islands made one; others renamed."""
    merged = dict.fromkeys(taken.junction.islands, taken.junction.islands[0])
    edges = {
        k: Edge(merged.get(a, a), merged.get(b, b), price)
        for k, (a, b, price) in tree.items()
        if k not in taken.replaced
    }
    return edges, [Junction(k, tuple(merged.get(i, i) for i in islands), p) for k, islands, p in junctions]


def _blocks(offers: Sequence[Offer]) -> list[list[Offer]]:
    """Offers put together that share an edge on their ways."""
    alike = disjoint(range(len(offers)))
    holder: dict[int, int] = {}
    for number, offer in enumerate(offers):
        for k in offer.ways:
            alike.merge(holder.setdefault(k, number), number)
    blocks: dict[int, list[Offer]] = defaultdict(list)
    for number, offer in enumerate(offers):
        blocks[alike[number]].append(offer)
    return list(blocks.values())


def _offers(tree: Edges, junctions: Sequence[Junction], least: float = SOLVER_TOL) -> list[Offer]:
    """What each junction offers, of those that gain more than the least."""
    up, depth = _rooted(tree)
    offers: list[Offer] = []
    for junction in junctions:
        ways: set[int] = set()
        for a, b in pairwise(junction.islands):
            while a != b:
                if depth[a] < depth[b]:
                    a, b = b, a
                a, k = up[a]
                ways.add(k)
        joined = disjoint(island for k in ways for island in tree[k][:2])
        if ways:
            unite(joined, junction.islands)
        replaced: list[int] = []
        for k in sorted(ways, key=lambda k: (tree[k].price, k)):
            if not joined.merge(tree[k].a, tree[k].b):
                replaced.append(k)
        gain = sum(tree[k].price for k in replaced) - junction.price
        if gain > least:
            offers.append(Offer(junction, frozenset(ways), frozenset(replaced), gain))
    return offers


def _rooted(tree: Edges) -> tuple[dict[int, tuple[int, int]], dict[int, int]]:
    """For each island but the roots, the next towards its root and the edge there; and every depth."""
    around: dict[int, list[tuple[int, int]]] = defaultdict(list)
    for k, (a, b, _) in tree.items():
        around[a].append((b, k))
        around[b].append((a, k))
    up: dict[int, tuple[int, int]] = {}
    depth: dict[int, int] = {}
    for root in around:
        if root in depth:
            continue
        depth[root] = 0
        queue = [root]
        for island in queue:
            for other, k in around[island]:
                if other not in depth:
                    depth[other] = depth[island] + 1
                    up[other] = island, k
                    queue.append(other)
    return up, depth
