"""How readability was spent on bridges (the paper's Fig. 9)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import shapely

if TYPE_CHECKING:
    from perfqr_cad.pattern import Bridge, Pattern


INSIDE = 0.999  # of a bar's width: a module that it only touches is not crossed


def loss_curve(pattern: Pattern) -> list[float]:
    """L(Q) of Eq. (1) before the first bridge and after each, in the order in which they were laid.

    Wrong modules are those of the finished pattern: one that bridges cross counts from the first of them,
    the others from the start. The last value is the pattern's own loss.
    """
    from perfqr_cad.symbol import ReadabilityTracker

    wrong = np.argwhere(pattern.observed.dark != pattern.symbol.matrix.dark)
    tree = shapely.STRtree(_squares(wrong, pattern.symbol.size, pattern.module_mm))
    tracker = ReadabilityTracker(pattern.symbol)
    charged: set[int] = set()
    by_bridge = [_newly_under(bridge, tree, charged) for bridge in pattern.bridges]
    for index in set(range(len(wrong))) - charged:
        tracker.flip(*wrong[index].tolist())
    losses = [tracker.total]
    for indices in by_bridge:
        for index in indices:
            tracker.flip(*wrong[index].tolist())
        losses.append(tracker.total)
    return losses


def _newly_under(bridge: Bridge, tree: shapely.STRtree, charged: set[int]) -> list[int]:
    """Wrong modules that this bridge is the first to cross; adds them to `charged`."""
    bar = shapely.LineString([bridge.start, bridge.end]).buffer(
        bridge.width_mm / 2 * INSIDE, cap_style="flat"
    )
    new = [index for index in tree.query(bar, predicate="intersects").tolist() if index not in charged]
    charged.update(new)
    return new


def _squares(modules: np.ndarray, size: int, module_mm: float) -> np.ndarray:
    """Squares of modules (k, 2) row and column in the pattern plane."""
    row, column = modules.T
    left, top = (column - size / 2) * module_mm, (size / 2 - row) * module_mm
    return shapely.box(left, top - module_mm, left + module_mm, top)
