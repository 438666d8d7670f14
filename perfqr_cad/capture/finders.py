"""Finder patterns by their 1:1:3:1:1 profile (ISO/IEC 18004 §6.3.3), and triples that may be a symbol."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree  # pyright: ignore[reportAttributeAccessIssue] - no stub

from perfqr_cad.capture.grid import Floats, cross
from perfqr_cad.symbol import size_of

PROFILE = np.array([1, 1, 3, 1, 1]) / 7.0
PROFILE_TOLERANCE = np.array([0.6, 0.6, 1.1, 0.6, 0.6]) / 7.0  # of the whole run: half a module, and a little
LEAST_RUN_PX = 9.0  # a finder of 7 modules at 1.3 px; smaller ones are found in enlarged pictures
CLUSTER_MODULES = 1.2  # hits nearer than this belong to one finder
CROSSING_MODULES = 1.0  # between the centres found along rows and along columns
LEAST_SUPPORT = 0.3  # of the three modules of scan lines that cross a finder's core
SAME_SIZE = 1.8  # ratio of the module widths of two finders of one symbol, at the most
MAX_HITS = 10_000  # the longest; as many as a textured photograph of 1 megapixel has, noise 300,000
MAX_FINDERS = 14  # best supported; 364 triples
MAX_TRIPLES = 8
MAX_SIDES_RATIO = 2.2  # of the two sides of a symbol under perspective
LEAST_SINE = 0.5  # of the angle at the top-left finder
THRESHOLD_BLOCKS = (25, 81)  # px, windows of the local threshold


@dataclass(frozen=True, eq=False)
class Finder:
    """Centre (2,) px, module width px, and how many scan lines support it, in units of its own width."""

    centre: Floats
    module_px: float
    support: float


@dataclass(frozen=True, eq=False)
class Triple:
    """Top-left, top-right and bottom-left finders, and the sizes in modules they allow, likeliest first."""

    centres: Floats
    sizes: tuple[int, ...]


def triples(image: NDArray[np.uint8]) -> Iterator[Triple]:
    """Triples of finders of a grey picture, best first; light-on-dark ones included."""
    found: list[Finder] = []
    for dark in _thresholded(image):
        found += _finders(dark)
        found += _finders(~dark)
    yield from _assembled(_merged(found))


def _thresholded(image: NDArray[np.uint8]) -> Iterator[NDArray[np.bool_]]:
    split, _ = cv2.threshold(image, 0, 255, cv2.THRESH_BINARY | cv2.THRESH_OTSU)
    yield image <= split
    for block in THRESHOLD_BLOCKS:
        yield image < cv2.blur(image, (block, block))


def _finders(dark: NDArray[np.bool_]) -> list[Finder]:
    """Finders whose profile is right along rows and along columns."""
    rows, columns = _hits(dark), _hits(dark.T)[:, [1, 0, 2]]
    if not len(rows) or not len(columns):
        return []
    near = cKDTree(columns[:, :2])
    found: list[Finder] = []
    for cluster in _clusters(rows):
        if len(cluster) < max(2.0, LEAST_SUPPORT * 3 * cluster[0, 2] / 7):
            continue
        x, y, width = np.median(cluster, axis=0)
        module = width / 7
        partners = columns[near.query_ball_point((x, y), CROSSING_MODULES * module)]
        partners = partners[(partners[:, 2] < SAME_SIZE * width) & (partners[:, 2] * SAME_SIZE > width)]
        if len(partners):
            height = float(np.median(partners[:, 2]))
            centre = np.array([np.mean([x, np.median(partners[:, 0])]), np.median(partners[:, 1])])
            support = (len(cluster) + len(partners)) / (3 * module + 3 * height / 7)
            found.append(Finder(centre, float(np.sqrt(width * height)) / 7, min(float(support), 1.0)))
    return found


def _hits(dark: NDArray[np.bool_]) -> NDArray[np.float64]:
    """(k, 3) x, y of the centre and length of every dark-light-dark-light-dark run of 1:1:3:1:1."""
    height, width = dark.shape
    framed = np.zeros((height, width + 2), np.bool_)
    framed[:, 1:-1] = dark
    flat = framed.ravel()
    edges = np.flatnonzero(flat[1:] != flat[:-1]) + 1
    if len(edges) < 6:
        return np.zeros((0, 3))
    starts = edges[:-5:2]  # every even edge enters dark: rows begin and end light
    ends = np.stack([edges[k : len(edges) - 5 + k : 2] for k in range(6)], axis=1).astype(np.float64)
    runs = np.diff(ends, axis=1)
    length = ends[:, 5] - ends[:, 0]
    same_row = starts // (width + 2) == (edges[5::2][: len(starts)] - 1) // (width + 2)
    good = same_row & (length >= LEAST_RUN_PX)
    good &= np.all(
        np.abs(runs - PROFILE * length[:, None]) <= PROFILE_TOLERANCE * length[:, None] + 0.5, axis=1
    )
    y, x = np.divmod((ends[good, 2] + ends[good, 3]) / 2, width + 2)
    hits = np.stack([x - 1.5, y, length[good]], axis=1)
    if len(hits) <= MAX_HITS:
        return hits
    return hits[np.sort(np.argsort(-hits[:, 2], kind="stable")[:MAX_HITS])]


def _clusters(hits: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """Hits of one finder: of about the same length and within `CLUSTER_MODULES` of its first one."""
    reach = np.maximum(CLUSTER_MODULES * 2 * hits[:, 2] / 7, 2.0)
    neighbours = cKDTree(hits[:, :2]).query_ball_point(hits[:, :2], reach)
    left = np.ones(len(hits), np.bool_)
    clusters: list[NDArray[np.float64]] = []
    for hit, members in zip(hits, neighbours, strict=True):
        near = np.array(members)
        near = near[left[near] & (np.abs(hits[near, 2] - hit[2]) < 0.4 * hit[2])]
        if len(near):
            left[near] = False
            clusters.append(hits[near])
    return clusters


def _merged(found: list[Finder]) -> list[Finder]:
    """One finder for each place, best supported first."""
    kept: list[Finder] = []
    for one in sorted(found, key=lambda finder: -finder.support * min(finder.module_px, 4.0)):
        if all(np.hypot(*(one.centre - other.centre)) > 2 * other.module_px for other in kept):
            kept.append(one)
        if len(kept) == MAX_FINDERS:
            break
    return kept


def _assembled(finders: list[Finder]) -> Iterator[Triple]:
    ranked: list[tuple[float, Triple]] = []
    for three in combinations(finders, 3):
        widths = [one.module_px for one in three]
        if max(widths) > SAME_SIZE * min(widths):
            continue
        candidate = _triple(three)
        if candidate is not None:
            ranked.append(candidate)
    ranked.sort(key=lambda one: one[0])
    yield from (triple for _, triple in ranked[:MAX_TRIPLES])


def _triple(three: tuple[Finder, ...]) -> tuple[float, Triple] | None:
    """The triple with its corner first, and a cost: its skewness and the weakness of its support."""
    centres = np.stack([one.centre for one in three])
    sides = [float(np.hypot(*(centres[(k + 1) % 3] - centres[(k + 2) % 3]))) for k in range(3)]
    corner = int(np.argmax(sides))
    a, b, c = centres[corner], centres[(corner + 1) % 3], centres[(corner + 2) % 3]
    if cross(b - a, c - a) < 0:
        b, c = c, b
    first, second = float(np.hypot(*(b - a))), float(np.hypot(*(c - a)))
    sine = float(cross(b - a, c - a)) / max(first * second, 1e-9)
    if sine < LEAST_SINE or max(first, second) > MAX_SIDES_RATIO * min(first, second):
        return None
    # Along a slanted side the scan lines cut the finder at an angle and see it wider.
    module = float(np.mean([one.module_px for one in three]))
    tilt = max(abs(float((b - a)[0])), abs(float((b - a)[1]))) / first
    modules = np.sqrt(first * second) / (module * tilt) + 7
    if modules < 17 or modules > 200:
        return None
    skew = abs(np.log(first / second)) + (1 - sine)
    spread = float(np.std([one.module_px for one in three])) / module
    cost = float(skew + spread + 0.5 * sum(1 - one.support for one in three))
    return cost, Triple(np.stack([a, b, c]), _sizes_near(float(modules)))


def _sizes_near(modules: float) -> tuple[int, ...]:
    """Sizes within a fifth of an estimate, nearest first."""
    sizes = [size_of(version) for version in range(1, 41)]
    near = [size for size in sizes if abs(size - modules) <= max(5.0, 0.14 * modules)]
    return tuple(sorted(near, key=lambda size: abs(size - modules)))
