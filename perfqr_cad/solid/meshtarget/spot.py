"""Finding the place for a code on a mesh: a given spot, or the flattest that takes it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from perfqr_cad.errors import DesignError
from perfqr_cad.solid.imported.body import Array, Body
from perfqr_cad.solid.imported.survey import COARSE, Frame, Survey, largest_below, survey

Problem = Callable[[Survey], str | None]

CANDIDATES = 250  # spots tried
BEST = 12  # of them judged finely, the flattest first
SEED = 0
OUTER = np.array([0])  # face numbers of outer surfaces
AVERAGED = 3  # rounds of turning the axis towards the mean normal under the code
ON_SURFACE_SHARE = 1e-3  # of the diagonal: a given point this near to the surface is on it


@dataclass(frozen=True)
class Wish:
    """What the user said about the place: where the reader is and looks, and up."""

    point: tuple[float, float, float] | None = None
    direction: tuple[float, float, float] | None = None
    up: tuple[float, float, float] | None = None


def place(body: Body, wish: Wish, size_mm: float, problem: Problem) -> Survey:
    """The survey of the place for a code of that edge.

    The axis is the mean normal under the code: one facet's own says little. Raises `DesignError` with the
    reason,
    the largest size that works there and the nearest place that works.
    """
    if wish.point is None:
        return _flattest(body, size_mm, problem, wish.up)
    origin, normal = _met(body, wish)
    found = _settled(body, origin, normal, size_mm, wish.up)
    reason = "there is no flat enough surface" if found is None else problem(found)
    if found is not None and reason is None:
        return found
    raise DesignError(
        f"a code of {size_mm:.4g} mm does not work at {_triple(origin)}: {reason}"
        f"{_largest(body, origin, normal, size_mm, problem, wish.up)}"
        f"{_nearest(body, origin, size_mm, problem, wish.up)}"
    )


def _flattest(body: Body, size_mm: float, problem: Problem, up: ArrayLike | None) -> Survey:
    """The spot with the least worst tilt among samples of the surface."""
    points, normals, _ = body.samples(CANDIDATES, SEED, OUTER)
    ranked: list[tuple[float, int, Frame]] = []
    reasons: dict[str, int] = {}
    for i, (point, normal) in enumerate(zip(points, normals, strict=True)):
        found = _settled(body, point, normal, size_mm, up, COARSE)
        reason = "no surface" if found is None else problem(found)
        if found is None or reason is not None:
            reasons[reason or ""] = reasons.get(reason or "", 0) + 1
            continue
        ranked.append((float(np.nanmax(found.tilt_deg)), i, found.frame))
    for _, _, frame in sorted(ranked, key=lambda r: r[:2])[:BEST]:
        fine = survey(body, frame, size_mm)
        if problem(fine) is None:
            return fine
    commonest = max(reasons, key=lambda r: reasons[r]) if reasons else "steps between the samples"
    raise DesignError(
        f"no spot of the mesh takes a code of {size_mm:.4g} mm ({CANDIDATES} tried; mostly, {commonest}): "
        "take a smaller size"
    )


def _settled(
    body: Body, origin: Array, normal: Array, size_mm: float, up: ArrayLike | None, samples: int | None = None
) -> Survey | None:
    """The survey whose axis is the mean normal under the code; None where that has no meaning."""
    for _ in range(AVERAGED):
        try:
            frame = Frame.at(origin, normal, up)
        except DesignError:
            return None
        found = survey(body, frame, size_mm, COARSE)
        middle = found.height_mm[COARSE // 2, COARSE // 2]
        mean = np.nansum(found.normal.reshape(-1, 3), axis=0)
        if not np.isfinite(middle) or np.linalg.norm(mean) < 1e-9:
            return None
        origin, normal = frame.to_space([[0.0, 0.0, middle]])[0], mean @ frame.axes
    try:
        frame = Frame.at(origin, normal, up)
    except DesignError:
        return None
    return survey(body, frame, size_mm) if samples is None else survey(body, frame, size_mm, samples)


def _met(body: Body, wish: Wish) -> tuple[Array, Array]:
    """The surface point that is meant, and its facet's normal."""
    point = np.asarray(wish.point, float)
    triangle, on = body.nearest(point)
    near = np.linalg.norm(on - point) < ON_SURFACE_SHARE * body.diagonal_mm
    if wish.direction is None or near:
        return on, body.facet_normals[triangle]
    look = np.asarray(wish.direction, float)
    if not np.linalg.norm(look) > 0:
        raise DesignError(f"direction={_triple(look)} has no length: give the direction the reader looks in")
    look = look / np.linalg.norm(look)
    met = body.crossings(point[None], look[None])
    entering = np.flatnonzero(met.entering)
    if not len(entering):
        raise DesignError(
            f"looking from {_triple(point)} along {_triple(look)} meets no outer surface: start outside "
            f"and look at it"
        )
    first = entering[0]
    return point + met.distance_mm[first] * look, body.facet_normals[met.triangle[first]]


def _largest(
    body: Body, origin: Array, normal: Array, size_mm: float, problem: Problem, up: ArrayLike | None
) -> str:
    """The largest size that works at a spot, as a clause."""

    def works(size: float) -> bool:
        found = _settled(body, origin, normal, size, up)
        return found is not None and problem(found) is None

    largest = largest_below(size_mm, works)
    return f"; at most {np.floor(largest * 100) / 100:.4g} mm works there" if largest > 0 else ""


def _nearest(body: Body, origin: Array, size_mm: float, problem: Problem, up: ArrayLike | None) -> str:
    """The nearest spot that works, as a clause."""
    points, normals, _ = body.samples(CANDIDATES, SEED, OUTER)
    for i in np.argsort(np.linalg.norm(points - origin, axis=1), kind="stable"):
        coarse = _settled(body, points[i], normals[i], size_mm, up, COARSE)
        if coarse is None or problem(coarse) is not None:
            continue
        if problem(survey(body, coarse.frame, size_mm)) is None:
            at = coarse.frame
            away = float(np.linalg.norm(at.origin - origin))
            return (
                f"; the nearest place that works is {away:.3g} mm away: point={_triple(at.origin)} "
                f"direction={_triple(-at.axes[2])}"
            )
    return "; no place on the mesh takes it: choose a smaller size"


def _triple(v: ArrayLike) -> str:
    return "(" + ",".join(f"{x:.4g}" for x in np.asarray(v, float)) + ")"
