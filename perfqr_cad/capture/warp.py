"""A smooth warp for pages that are not flat, grown from the finders over the symbol.

The three finders and their corners are found as templates. From there the warp grows node by node: each
takes the trend of its known neighbours, then the phase of the module edges around it, which lie on whole
modules. So a page may deviate by many modules from any homography and still be counted right.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from perfqr_cad.capture.grid import Floats, Grid, look_up, project
from perfqr_cad.capture.register import WORK_MODULE_PX, Workspace, known_modules

FINDER_RADIUS = 3.5  # modules about its centre that a whole finder is compared in
CORNER_RADIUS = 2.0  # the same for one corner of a finder: its stretch may differ from the symbol's
MARK_RADIUS = 2.5  # the same for a piece of timing line
TIMING_STEP = 3  # modules between the pieces
REACH = 0.9  # modules that a landmark may lie off the expected place
STEP = 6  # places tried along a module
SPACING = 3  # samples along a module of a landmark
PATCH_SPACING = 5  # samples along a module of a patch
BLUR_MODULES = 0.3
LEAST_CORRELATION = 0.55
STIFFNESS = 0.3  # of the spline: a landmark's error is some hundredths of a module, in few it is gross
LATTICE_MODULES = 3.0  # step of the warp's lattice, near enough
TREND_MODULES = 4.0  # σ of the neighbourhood whose trend an unknown node follows
TREND_RIDGE = 0.02  # holds the trend level where all known nodes lie on one line
KNOWN_MODULES = 2.1  # from a landmark to the nodes that it settles
PATCH_MODULES = 6.0  # side of the patch around a node whose edges are looked at
EDGE_WINDOW_MODULES = 3.0  # σ of the window in which the phase of module edges is taken
EDGE_TRUST = 0.25  # coherence of the edges' phase, 0..1, that is worth half a correction
EDGE_ROUNDS = 3


@dataclass(frozen=True, eq=False)
class Landmark:
    """Centre (2,) in modules; (m, 2) offsets to samples of known modules, and their light (m,), ±1."""

    centre: Floats
    offsets: Floats
    light: Floats


def bent(space: Workspace, grid: Grid) -> Grid:
    """The grid with the warp that the picture shows."""
    inside = replace(grid, homography=space.transform @ grid.homography)
    image = np.asarray(cv2.GaussianBlur(space.image, (0, 0), BLUR_MODULES * WORK_MODULE_PX), np.float32)
    inside = _grown(image, inside, *_at_finders(image, inside))
    for _ in range(EDGE_ROUNDS):
        inside = _on_edges(space.image, inside)
    return replace(inside, homography=grid.homography)


def _at_finders(image: NDArray[np.float32], grid: Grid) -> tuple[Floats, Floats]:
    """(m, 2) places of the finders and their corners that are seen, and their (m, 2) displacements."""
    sign = np.float32(1.0 if _finders_light(image, grid) else -1.0)
    places: list[Floats] = []
    shifts: list[Floats] = []
    for group in landmarks(grid.size):
        expected = _spline(np.array(places), np.array(shifts), np.array([mark.centre for mark in group]))
        for mark, start in zip(group, expected, strict=True):
            shift = _found(image * sign, grid, mark, start)
            if shift is not None:
                places.append(mark.centre)
                shifts.append(shift)
    return np.array(places).reshape(-1, 2), np.array(shifts).reshape(-1, 2)


def _grown(image: NDArray[np.float32], grid: Grid, places: Floats, shifts: Floats) -> Grid:
    """The warp on its whole lattice, in waves from the finders outwards."""
    steps = max(2, round(grid.size / LATTICE_MODULES)) + 1
    x, y = np.meshgrid(*[np.linspace(0, grid.size, steps)] * 2)
    nodes = np.stack([x, y], axis=-1)
    reach = np.min(np.max(np.abs(nodes[:, :, None] - places), axis=-1), axis=-1, initial=np.inf)
    weight = (reach <= KNOWN_MODULES).astype(float)
    warp = _spline(places, shifts, nodes.reshape(-1, 2)).reshape(nodes.shape) * weight[..., None]
    known = weight > 0
    while not known.all():
        wave = ~known & (cv2.dilate(known.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0)
        expected = _trend(nodes[known], warp[known], weight[known], nodes[wave])
        shift, coherence = _phase(image, grid, nodes[wave], expected)
        trust = _trust(coherence)
        warp[wave] = expected + trust * shift
        weight[wave] = np.maximum(trust.min(axis=1), 0.02)
        known |= wave
    return replace(grid, warp=warp)


def _trend(nodes: Floats, warp: Floats, weight: Floats, at: Floats) -> Floats:
    """(k, 2) linear extrapolation of the (m, 2) warp at known nodes, each place by its own neighbours."""
    away = (nodes[None] - at[:, None]) / TREND_MODULES
    square = np.sum(away**2, axis=-1)
    share = weight[None] * np.exp(-0.5 * (square - square.min(axis=1, keepdims=True)))
    base = np.concatenate([np.ones((*square.shape, 1)), away], axis=-1)
    normal = np.einsum("km,kmi,kmj->kij", share, base, base)
    normal += np.diag([1e-9, TREND_RIDGE, TREND_RIDGE]) * share.sum(axis=1)[:, None, None]
    right = np.einsum("km,kmi,mc->kic", share, base, warp)
    return np.linalg.solve(normal, right)[:, 0]


def _phase(image: NDArray[np.float32], grid: Grid, nodes: Floats, start: Floats) -> tuple[Floats, Floats]:
    """(k, 2) how far edges lie off whole modules around each node, in −½..½, and (k, 2) their coherence."""
    steps = np.arange(-PATCH_MODULES / 2, PATCH_MODULES / 2, 1 / PATCH_SPACING) + 0.5 / PATCH_SPACING
    about = np.stack(np.meshgrid(steps, steps), axis=-1)
    points = nodes[:, None, None] + about
    inside = np.all((points > 0) & (points < grid.size), axis=-1)
    moved = points + start[:, None, None]
    seen = look_up(image, project(grid.homography, moved).reshape(len(nodes), -1, 2)).reshape(
        points.shape[:3]
    )
    window = np.exp(-np.sum(about**2, axis=-1) / (2 * (PATCH_MODULES / 3) ** 2)) * inside
    total = np.empty((len(nodes), 2))
    turned = np.empty((len(nodes), 2), complex)
    for axis in (0, 1):
        edge = np.abs(np.gradient(seen, axis=2 - axis)) * window
        total[:, axis] = edge.sum(axis=(1, 2))
        turned[:, axis] = np.sum(edge * np.exp(2j * np.pi * points[..., axis]), axis=(1, 2))
    return np.angle(turned) / (2 * np.pi), np.abs(turned) / np.maximum(total, 1e-6)


def _trust(coherence: Floats) -> Floats:
    """How much of a measured shift to believe, 0..1."""
    return coherence**2 / (coherence**2 + EDGE_TRUST**2)


def _finders_light(image: NDArray[np.float32], grid: Grid) -> bool:
    """Whether light modules are light in the picture."""
    known, dark = known_modules(grid.size, "finders")
    rows, columns = np.nonzero(known)
    seen = look_up(image, grid.pixels(np.stack([columns + 0.5, rows + 0.5], axis=1))[None])[0]
    is_dark = dark[rows, columns]
    return bool(seen[~is_dark].mean() >= seen[is_dark].mean())


@lru_cache(maxsize=8)
def landmarks(size: int) -> tuple[tuple[Landmark, ...], ...]:
    """The three finders, four corners of each, then pieces of the timing lines from the finders outwards."""
    finders = np.array([[3.5, 3.5], [size - 3.5, 3.5], [3.5, size - 3.5]])
    corners = (finders[:, None] + np.array([[-2, -2], [2, -2], [-2, 2], [2, 2]])).reshape(-1, 2)
    along = np.arange(8.5, size - 8, TIMING_STEP)
    order = np.argsort(np.minimum(along - 3.5, size - 3.5 - along), kind="stable")
    pairs = [np.array([[place, 6.5], [6.5, place]]) for place in along[order]]
    groups = ((finders, FINDER_RADIUS), (corners, CORNER_RADIUS), *((pair, MARK_RADIUS) for pair in pairs))
    return tuple(tuple(_landmark(centre, radius, size) for centre in group) for group, radius in groups)


def _landmark(centre: Floats, radius: float, size: int) -> Landmark:
    known, dark = known_modules(size, "all")
    steps = np.arange(-radius, radius, 1 / SPACING) + 0.5 / SPACING
    x, y = np.meshgrid(steps, steps)
    column, row = np.floor(centre[0] + x).astype(int), np.floor(centre[1] + y).astype(int)
    inside = (column >= 0) & (row >= 0) & (column < size) & (row < size)
    inside[inside] = known[row[inside], column[inside]]
    light = np.where(dark[row[inside], column[inside]], -1.0, 1.0)
    return Landmark(centre, np.stack([x[inside], y[inside]], axis=1), light)


def _found(image: NDArray[np.float32], grid: Grid, mark: Landmark, start: Floats) -> Floats | None:
    """Displacement in modules at which the landmark is seen best; None when it is not seen near `start`."""
    reach = round(REACH * STEP)
    steps = np.arange(-reach, reach + 1) / STEP
    dx, dy = np.meshgrid(steps, steps)
    shifts = np.stack([dx.ravel(), dy.ravel()], axis=1) + start
    points = (mark.centre + mark.offsets)[None] + shifts[:, None]
    seen = look_up(image, grid.pixels(points)).astype(np.float64)
    seen -= seen.mean(axis=1, keepdims=True)
    ideal = mark.light - mark.light.mean()
    scores = seen @ ideal / (np.linalg.norm(seen, axis=1) * np.linalg.norm(ideal) + 1e-9)
    best = int(np.argmax(scores))
    if scores[best] < LEAST_CORRELATION:
        return None
    return shifts[best] + _summit(scores.reshape(dx.shape), best) / STEP


def _summit(scores: Floats, best: int) -> Floats:
    """Offset (x, y) in steps of a parabola's top from the best score."""
    row, column = divmod(best, scores.shape[1])
    offset = np.zeros(2)
    if 0 < row < scores.shape[0] - 1 and 0 < column < scores.shape[1] - 1:
        for axis, (low, high) in enumerate(
            (
                (scores[row, column - 1], scores[row, column + 1]),
                (scores[row - 1, column], scores[row + 1, column]),
            )
        ):
            bow = low - 2 * scores[row, column] + high
            offset[axis] = 0.5 * (low - high) / bow if bow < 0 else 0.0
    return offset


def _spline(places: Floats, shifts: Floats, at: Floats, scale: float = 10.0) -> Floats:
    """(k, 2) thin plate smoothing spline through (m, 2) shifts at (m, 2) places; 0 with fewer than three.

    Not scipy's RBFInterpolator: it refuses places on one line, such as pieces of one timing line, which the
    small ridge on the linear part bears.
    """
    if len(places) < 3:
        return np.zeros_like(at)
    kernel = _kernel(places, places, scale) + STIFFNESS * np.eye(len(places))
    flat = np.column_stack([np.ones(len(places)), places / scale])
    system = np.block([[kernel, flat], [flat.T, 1e-9 * np.eye(3)]])
    weights = np.linalg.solve(system, np.vstack([shifts, np.zeros((3, 2))]))
    beyond = np.column_stack([np.ones(len(at)), at / scale])
    return _kernel(at, places, scale) @ weights[:-3] + beyond @ weights[-3:]


def _kernel(a: Floats, b: Floats, scale: float) -> Floats:
    square = np.sum((a[:, None] - b[None]) ** 2, axis=-1) / scale**2
    return 0.5 * square * np.log(square + 1e-12)


def _on_edges(image: NDArray[np.float32], grid: Grid) -> Grid:
    """The warp moved so that the picture's edges lie on whole modules, where they are periodic at all."""
    scale = int(WORK_MODULE_PX)
    axis = (np.arange(grid.size * scale) + 0.5) / scale
    points = np.stack(np.meshgrid(axis, axis), axis=-1)
    seen = look_up(image, grid.pixels(points))
    corrections = []
    for along in (0, 1):
        edge = np.abs(np.gradient(seen, axis=1 - along))
        turn: NDArray[np.complex128] = np.exp(2j * np.pi * points[..., along])
        window = (0, 0), EDGE_WINDOW_MODULES * scale
        real, imaginary, total = (
            cv2.GaussianBlur(part.astype(np.float32), *window)
            for part in (edge * turn.real, edge * turn.imag, edge)
        )
        coherence = np.hypot(real, imaginary) / np.maximum(total, 1e-6)
        corrections.append(_trust(coherence) * np.arctan2(imaginary, real) / (2 * np.pi))
    steps = grid.warp.shape[0]
    nodes = np.linspace(0, grid.size * scale - 1, steps)
    mesh = np.stack(np.meshgrid(nodes, nodes), axis=-1)
    change = np.stack([look_up(one.astype(np.float32), mesh) for one in corrections], axis=-1)
    return replace(grid, warp=grid.warp + change)
