"""The cheapest links, against all choices tried one by one."""

from itertools import combinations

import numpy as np
import pytest

from perfqr_cad.pattern.joining.junctions import cheapest_without_loss
from perfqr_cad.pattern.joining.spanning import Conflict, Link, cheapest, cost, kruskal


def joined(links, chosen, islands):
    parts = [{i} for i in range(islands)]
    for k in chosen:
        touched = [p for p in parts if p & set(links[k].islands)]
        parts = [p for p in parts if p not in touched] + [set().union(*touched)]
    return len(parts) == 1


def least_cost(links, conflicts, islands):
    choices = (c for size in range(1, islands) for c in combinations(range(len(links)), size))
    return min(cost(links, conflicts, c) for c in choices if joined(links, c, islands))


def random_links(seed, islands=6, stars=3, losing=0):
    rng = np.random.default_rng(seed)
    pairs = [Link(pair, float(rng.uniform(1, 2))) for pair in combinations(range(islands), 2)]
    trios = [
        Link(tuple(rng.choice(islands, 3, replace=False).tolist()), float(rng.uniform(1.2, 2.6)))
        for _ in range(stars)
    ]
    for k in rng.choice(len(pairs), losing, replace=False).tolist():
        pairs[k] = Link(pairs[k].islands, pairs[k].price, frozenset({int(rng.integers(3))}))
    return pairs, trios


@pytest.mark.parametrize("seed", range(6))
def test_blocks_find_the_optimum_and_prove_it(seed):
    pairs, trios = random_links(seed)
    chosen, proof = cheapest_without_loss(pairs, trios)
    links = [*pairs, *trios]
    assert joined(links, chosen, 6)
    assert proof.objective == pytest.approx(least_cost(links, (), 6))
    assert proof.gap == 0
    assert proof.bound == pytest.approx(proof.objective)


@pytest.mark.parametrize("seed", range(4))
def test_a_codeword_is_paid_once_however_many_links_lose_it(seed):
    pairs, _ = random_links(seed, islands=5, losing=8)
    chosen, proof = cheapest(pairs, (), 1000)
    assert proof.objective == pytest.approx(least_cost(pairs, (), 5))
    assert proof.objective == pytest.approx(cost(pairs, (), chosen))


def test_a_conflict_is_avoided_when_another_way_costs_less():
    links = [Link((0, 1), 1.0), Link((1, 2), 1.0), Link((0, 2), 1.5)]
    chosen, _ = cheapest(links, [Conflict((0, 1), frozenset({7}))], 1000)
    assert sorted(chosen) in ([0, 2], [1, 2])


def test_without_search_the_tree_is_returned_with_an_honest_gap():
    pairs, trios = random_links(1)
    links = [*pairs, *trios]
    chosen, proof = cheapest(links, (), 0)
    assert chosen == kruskal(links)
    assert proof.bound == 0
    assert proof.gap == 1


@pytest.mark.parametrize("seed", range(4))
def test_many_junctions_agree_with_the_integer_programme(seed):
    rng = np.random.default_rng(seed)
    pairs = [Link((k, k + 1), float(rng.uniform(1, 1.2))) for k in range(39)]
    trios = [Link((k, k + 1, k + 2), float(rng.uniform(1.7, 2.2))) for k in range(38)]
    chosen, proof = cheapest_without_loss(pairs, trios)
    _, expected = cheapest([*pairs, *trios], (), 2000)
    assert joined([*pairs, *trios], chosen, 40)
    assert proof.gap == expected.gap == 0
    assert proof.objective == pytest.approx(expected.objective)


def test_more_junctions_than_are_tried_together_have_an_honest_bound(monkeypatch):
    pairs, trios = random_links(4, islands=9, stars=14)
    _, proof = cheapest_without_loss(pairs, trios)
    monkeypatch.setattr("perfqr_cad.pattern.joining.junctions.LARGEST_BLOCK", 2)
    chosen, rough = cheapest_without_loss(pairs, trios)
    assert joined([*pairs, *trios], chosen, 9)
    assert rough.bound <= proof.objective <= rough.objective
