"""Where a fingertip stresses a part most."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from perfqr_cad.structure.handling.capacity import Hand
from perfqr_cad.structure.handling.pushes import Push, fingertip
from perfqr_cad.structure.mesh.triangle import Floats

SITES_ACROSS = 10  # places along the longer side where a fingertip is tried first
LEAST_SITE_MM = 4.0  # between them: half a fingertip
REFINED = 3  # worst places around which more are tried
LEAST_UNDER_FINGER = 0.2  # of its pad: a finger rests on material, not on a sliver of it
Place = tuple[float, float]
AT_ONCE = 24  # right-hand sides: bounds memory


def worst_fingertips(hand: Hand, apart: Sequence[Callable[[Place], bool]], count: int) -> list[list[Push]]:
    """Where a fingertip stresses a part most, worst first, no two under one finger: for each kind of place.

    Places of a grid, then more around the worst of each kind, are compared by the stress at the centres of
    elements. The kinds are told `apart` by what holds for their places.
    """
    left, low, right, high = hand.model.domain.bounds
    step = max((right - left) / SITES_ACROSS, (high - low) / SITES_ACROSS, LEAST_SITE_MM)
    grid = [
        np.linspace(first, last, max(2, round((last - first) / step) + 1))
        for first, last in ((left + step / 2, right - step / 2), (low + step / 2, high - step / 2))
    ]
    tried = _stresses_at(hand, np.stack(np.meshgrid(*grid), axis=-1).reshape(-1, 2))

    def worst(of_kind: Callable[[Place], bool], count: int) -> list[Place]:
        return _apart({place: stress for place, stress in tried.items() if of_kind(place)}, count, step)

    around = step / 2 * np.array([(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j])
    finer = [np.array(place) + around for kind in apart for place in worst(kind, REFINED)]
    tried |= _stresses_at(hand, np.concatenate(finer or [np.zeros((0, 2))]))
    return [[fingertip(place, hand.rim) for place in worst(kind, count)] for kind in apart]


def _apart(stress_at: dict[Place, float], count: int, least_mm: float) -> list[Place]:
    """The places of largest stress that are no nearer to each other than a distance."""
    kept: list[Place] = []
    for place in sorted(stress_at, key=lambda place: -stress_at[place]):
        if len(kept) == count:
            break
        if all(np.hypot(place[0] - x, place[1] - y) >= least_mm for x, y in kept):
            kept.append(place)
    return kept


def _stresses_at(hand: Hand, places: Floats) -> dict[Place, float]:
    """The largest stress at any element's centre under one newton of a fingertip at each of some places."""
    model, found = hand.model, {}
    forces: list[Floats] = []
    kept: list[Place] = []
    for x, y in places.tolist():
        push = fingertip((x, y), hand.rim)
        assert push.loaded is not None
        under = float(model.share_inside(push.loaded) @ model.area_mm2)
        if under >= LEAST_UNDER_FINGER * push.loaded.area:
            kept.append((x, y))
            forces.append(hand.forces(push))
    for start in range(0, len(kept), AT_ONCE):
        some = np.stack(forces[start : start + AT_ONCE], axis=1)
        moved = hand.factor.solve(np.where(model.fixed[:, None], 0.0, some))
        found |= dict(
            zip(kept[start : start + AT_ONCE], model.largest_at_centres(moved).tolist(), strict=True)
        )
    return found
