"""Algorithm 1 as published: from the point of largest deformation to the visible point of least Eq. (5)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp
import shapely
from scipy.sparse.csgraph import dijkstra

from perfqr_cad.errors import DesignError
from perfqr_cad.structure.mesh.triangle import EDGES, Floats, Ints, Mesh
from perfqr_cad.structure.reinforcement.bar_candidates import Allowance, Candidates, affordable, holes_of
from perfqr_cad.structure.reinforcement.bar_stiffness import bar_tensors, couplings, places_under
from perfqr_cad.structure.reinforcement.reanalysis import Reanalysis

if TYPE_CHECKING:
    from perfqr_cad.pattern import Bridge, Pattern

LOSS_WEIGHT = 1.0  # λ of Eq. (5)
MOST_BRIDGES = 40  # between two conforming meshes
MOST_STARTS = (
    12  # most deformed places that are tried; one beside a finder or alignment ring may see no bridge
)
MOST_REFUSED = 8  # cheapest bridges from a place that may break a rule of the pattern
ON_WALL_MM = 0.03  # the model's outline strays by 1/20 nozzle; a sight line may graze the wall it starts from


class PaperChoice:
    """Chooses one bridge at a time by Eq. (5)."""

    removed = 0  # the paper keeps every bridge

    def __init__(self, allowance: Allowance) -> None:
        self._allowance = allowance

    def add_bridges(
        self, pattern: Pattern, analysis: Reanalysis, limit_mpa: float
    ) -> tuple[Pattern, list[Bridge], list[float]]:
        """Bridges until the re-analysed stress is within the limit: pattern, bridges, stress after each."""
        graph = _light_graph(analysis.model.mesh)
        bridges: list[Bridge] = []
        stresses: list[float] = []
        while len(bridges) < MOST_BRIDGES:
            found = self._cheapest(pattern, analysis, graph)
            if found is None:
                break
            pattern, bridge, bar = found
            coupling = couplings(analysis.model, bar)
            own = bar_tensors(analysis.model.section, analysis.model.wall_mm, bar, len(coupling.indptr) - 1)
            analysis.add(analysis.respond(coupling), own, places_under(analysis.model.mesh, bar))
            bridges.append(bridge)
            # Bars are judged by the next mesh.
            stresses.append(analysis.largest_in_part)
            if stresses[-1] <= limit_mpa:
                break
        return pattern, bridges, stresses

    def avoid(self, bridges: Sequence[Bridge], place: tuple[float, float], reach_mm: float) -> None:
        """The paper keeps what it has added."""

    def _cheapest(
        self, pattern: Pattern, analysis: Reanalysis, graph: sp.csr_matrix
    ) -> tuple[Pattern, Bridge, Candidates] | None:
        """The cheapest bridge that can be added from the most deformed contour point that has one."""
        mesh = analysis.model.mesh
        displacement = analysis.displacements[:, analysis.worst_load]
        moved = np.linalg.norm(analysis.model.translations(displacement), axis=1)
        contour = np.unique(mesh.boundary)
        for start in _apart(mesh, contour[np.argsort(-moved[contour])], pattern.module_mm):
            found = self._cheapest_from(pattern, analysis, graph, contour, start)
            if found is not None:
                return found
        return None

    def _cheapest_from(
        self, pattern: Pattern, analysis: Reanalysis, graph: sp.csr_matrix, contour: Ints, start: int
    ) -> tuple[Pattern, Bridge, Candidates] | None:
        """The cheapest bridge that can be added from a contour point."""
        mesh = analysis.model.mesh
        ends = _visible(pattern, mesh, contour, start)
        if not len(ends):
            return None
        width = np.full(len(ends), pattern.spec.web_mm)
        p = np.repeat(mesh.nodes[start][None], len(ends), axis=0)
        bars = affordable(pattern, self._allowance, p, mesh.nodes[ends], width)
        if not len(bars):
            return None
        geodesic = dijkstra(graph, directed=False, indices=start)
        nearest = {tuple(xy): node for xy, node in zip(mesh.nodes[ends].tolist(), ends.tolist(), strict=True)}
        around = geodesic[[nearest[tuple(q)] for q in bars.end.tolist()]]
        loss = pattern.readability.total + bars.loss
        cost = LOSS_WEIGHT * loss + bars.length_mm**2 / around
        for row in np.argsort(cost, kind="stable").tolist()[:MOST_REFUSED]:
            bridge = bars.bridge(row, float(cost[row]))
            try:
                bridged = pattern.with_bridge(bridge)
            except DesignError:  # breaks a web or gap rule: the next cheapest
                continue
            if self._allowance.covers(bridged.readability):
                return bridged, bridge, bars.take(np.array([row]))
        return None


def _apart(mesh: Mesh, order: Ints, least_mm: float) -> list[int]:
    """The first of some nodes that are no nearer to each other than a distance."""
    starts: list[int] = []
    left = order
    while len(left) and len(starts) < MOST_STARTS:
        starts.append(int(left[0]))
        left = left[np.linalg.norm(mesh.nodes[left] - mesh.nodes[left[0]], axis=1) > least_mm]
    return starts


def _visible(pattern: Pattern, mesh: Mesh, contour: Ints, start: int) -> Ints:
    """Contour nodes seen from one of them across a hole: V_p of Algorithm 1."""
    here = mesh.nodes[start]
    others = contour[np.linalg.norm(mesh.nodes[contour] - here, axis=1) > pattern.spec.gap_mm]
    sights = shapely.linestrings(
        np.stack([np.repeat(here[None], len(others), axis=0), mesh.nodes[others]], axis=1)
    )
    seen = np.zeros(len(others), bool)
    for hole in holes_of(pattern.polygon):
        if shapely.distance(hole, shapely.points(here)) > ON_WALL_MM:
            continue
        wide = shapely.buffer(hole, ON_WALL_MM)
        shapely.prepare(wide)
        middles = shapely.line_interpolate_point(sights, 0.5, normalized=True)
        seen |= shapely.covers(wide, sights) & shapely.contains_properly(hole, middles)
    return others[seen]


def _light_graph(mesh: Mesh) -> sp.csr_matrix:
    """Edges of the mesh, halves and element diagonals, with their lengths: paths on the light region."""
    pairs = [(i, 3 + k) for k, (i, _) in enumerate(EDGES)] + [(3 + k, j) for k, (_, j) in enumerate(EDGES)]
    pairs += [(3, 4), (4, 5), (5, 3), (0, 4), (1, 5), (2, 3)]
    count = len(mesh.nodes)
    links = np.sort(np.concatenate([mesh.elements[:, pair] for pair in pairs]), axis=1)
    first, second = np.divmod(np.unique(links[:, 0] * count + links[:, 1]), count)
    lengths: Floats = np.linalg.norm(mesh.nodes[first] - mesh.nodes[second], axis=1)
    return sp.csr_matrix((lengths, (first, second)), shape=(count, count))
