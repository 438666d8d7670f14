"""Finding the place for a code on a mesh: a given spot, or the flattest that takes it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from perfqr_cad.errors import DesignError
from perfqr_cad.hosts.body import Array, Body
from perfqr_cad.hosts.wall import COARSE, Frame, Survey, frame_at, largest_below, survey, surveys
from perfqr_cad.hosts.wish import Wish, floored, triple

Problem = Callable[[Survey], str | None]

CANDIDATES = 250  # spots tried
BEST = 12  # of them judged finely, the flattest first
SEED = 0
OUTER = np.array([0])  # face numbers of outer surfaces
AVERAGED = 3  # rounds of turning the axis towards the mean normal under the code
ON_SURFACE_SHARE = 1e-3  # of the diagonal: a given point this near to the surface is on it


def place(body: Body, wish: Wish, size_mm: float, problem: Problem) -> Survey:
    """The survey of the place for a code of that edge.

    The axis is the mean normal under the code: one facet's own says little. Raises `DesignError` with the
    reason, the largest size that works and, for a given spot, the nearest place that works.
    """
    if wish.point is None:
        return _flattest(body, size_mm, problem, wish.up)
    origin, normal = _met(body, wish)
    found = _settled_at(body, origin, normal, size_mm, wish.up)
    reason = "there is no flat enough surface" if found is None else problem(found)
    if found is not None and reason is None:
        return found
    raise DesignError(
        f"a code of {size_mm:.4g} mm does not work at {triple(origin)}: {reason}"
        f"{_largest(body, origin, normal, size_mm, problem, wish.up)}"
        f"{_nearest(body, origin, size_mm, problem, wish.up)}"
    )


def _flattest(body: Body, size_mm: float, problem: Problem, up: ArrayLike | None) -> Survey:
    """The spot with the least worst tilt among samples of the surface."""
    found, reasons = _flat_spot(body, size_mm, problem, up)
    if found is not None:
        return found
    commonest = reasons.most_common(1)[0][0] if reasons else "steps between the samples"
    largest = largest_below(size_mm, lambda size: _flat_spot(body, size, problem, up)[0] is not None)
    remedy = f"; at most {floored(largest)} mm fits" if largest else ""
    raise DesignError(
        f"no spot of the mesh takes a code of {size_mm:.4g} mm ({CANDIDATES} tried); mostly, "
        f"{commonest}{remedy}"
    )


def _flat_spot(
    body: Body, size_mm: float, problem: Problem, up: ArrayLike | None
) -> tuple[Survey | None, Counter[str]]:
    """The flattest spot that works, if any, and what is wrong with the others: of those with a good front,
    where there are any.
    """
    points, normals, _ = body.samples(CANDIDATES, SEED, OUTER)
    spots = [spot for spot in _settled(body, points, normals, size_mm, up) if spot is not None]
    good = [spot for spot in spots if problem(spot) is None]
    good.sort(key=lambda spot: float(np.nanmax(spot.tilt_deg)))
    fine = (survey(body, spot.frame, size_mm) for spot in good[:BEST])
    flattest = next((spot for spot in fine if problem(spot) is None), None)
    nearly = [spot for spot in spots if spot.front_problem() is None] or spots
    return flattest, Counter(reason for spot in nearly if (reason := problem(spot)) is not None)


def _settled(
    body: Body, origins: Array, normals: Array, size_mm: float, up: ArrayLike | None
) -> list[Survey | None]:
    """Coarse surveys whose axes are the mean normals under the code; None where that has no meaning."""
    frames = [frame_at(o, n, up) for o, n in zip(origins, normals, strict=True)]
    for _ in range(AVERAGED):
        frames = [None if f is None else _averaged(f, up) for f in _coarse(body, frames, size_mm)]
    return _coarse(body, frames, size_mm)


def _settled_at(
    body: Body, origin: Array, normal: Array, size_mm: float, up: ArrayLike | None
) -> Survey | None:
    """The fine survey at one such spot."""
    (coarse,) = _settled(body, origin[None], normal[None], size_mm, up)
    return None if coarse is None else survey(body, coarse.frame, size_mm)


def _coarse(body: Body, frames: list[Frame | None], size_mm: float) -> list[Survey | None]:
    made = iter(surveys(body, [f for f in frames if f is not None], size_mm, COARSE))
    return [None if frame is None else next(made) for frame in frames]


def _averaged(found: Survey, up: ArrayLike | None) -> Frame | None:
    """The frame on the surface before the middle, its axis the mean normal of what was surveyed."""
    middle = found.height_mm[COARSE // 2, COARSE // 2]
    mean = np.nansum(found.normal.reshape(-1, 3), axis=0)
    if not np.isfinite(middle) or np.linalg.norm(mean) < 1e-9:
        return None
    return frame_at(found.frame.to_space([[0.0, 0.0, middle]])[0], mean @ found.frame.axes, up)


def _met(body: Body, wish: Wish) -> tuple[Array, Array]:
    """The surface point that is meant, and its facet's normal."""
    point, look = np.asarray(wish.point, float), wish.look()
    triangle, on = body.nearest(point)
    if look is None or np.linalg.norm(on - point) < ON_SURFACE_SHARE * body.diagonal_mm:
        return on, body.facet_normals[triangle]
    entered = body.first_entered(point, look)
    if entered is None:
        raise DesignError(
            f"looking from {triple(point)} along {triple(look)} meets no outer surface: start outside "
            f"and look at it"
        )
    triangle, hit = entered
    return hit, body.facet_normals[triangle]


def _largest(
    body: Body, origin: Array, normal: Array, size_mm: float, problem: Problem, up: ArrayLike | None
) -> str:
    """The largest size that works at a spot, as a clause."""

    def works(size: float) -> bool:
        found = _settled_at(body, origin, normal, size, up)
        return found is not None and problem(found) is None

    largest = largest_below(size_mm, works)
    return f"; at most {floored(largest)} mm works there" if largest > 0 else ""


def _nearest(body: Body, origin: Array, size_mm: float, problem: Problem, up: ArrayLike | None) -> str:
    """The nearest spot that works, as a clause."""
    points, normals, _ = body.samples(CANDIDATES, SEED, OUTER)
    order = np.argsort(np.linalg.norm(points - origin, axis=1), kind="stable")
    for coarse in _settled(body, points[order], normals[order], size_mm, up):
        if coarse is None or problem(coarse) is not None:
            continue
        if problem(survey(body, coarse.frame, size_mm)) is None:
            at = coarse.frame
            away = float(np.linalg.norm(at.origin - origin))
            return (
                f"; the nearest place that works is {away:.3g} mm away: point={triple(at.origin)} "
                f"direction={triple(-at.axes[2])}"
            )
    return "; no place on the mesh takes it: choose a smaller size"
