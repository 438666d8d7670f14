"""Finding the place for a code on a solid: a given face, a given spot, or the largest face that takes it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from perfqr_cad.errors import DesignError
from perfqr_cad.hosts.body import Array
from perfqr_cad.hosts.wall import COARSE, Frame, Survey, frame_at, largest_below, survey, surveys
from perfqr_cad.hosts.wish import Wish, floored, triple

if TYPE_CHECKING:
    from perfqr_cad.hosts.step.host import Host

Problem = Callable[[Survey], str | None]

CANDIDATES = 160  # spots tried on one face, or round a spot that does not work
FACES_TRIED = 40
FACES_SIZED = 4  # of them asked for the largest code when none takes the one that is wanted
TURNS_DEG = (0.0, 45.0, 30.0, 60.0, 15.0, 75.0)
ON_FACE_MM = 1e-3  # a given point this near to the surface is on it
SEED = 0


def place(host: Host, wish: Wish, size_mm: float, problem: Problem) -> Survey:
    """The survey of the place for a code of that edge.

    Raises `DesignError` with the reason, the largest size that works there and the nearest place that works.
    """
    if wish.point is not None:
        return _judged(host, _at_point(host, wish), size_mm, problem, wish)
    if wish.face is not None:
        index = _number(host, wish.face)
        found = _on_face(host, index, size_mm, problem, wish.up)
        if found is None:
            frame = _centre(host, index, wish.up)
            if frame is None:
                raise DesignError(
                    f"face {index + 1} of {host.name!r} has no usable spot: choose another face or up"
                )
            return _judged(host, frame, size_mm, problem, wish)
        return found
    return _largest_that_fits(host, size_mm, problem, wish)


def _largest_that_fits(host: Host, size_mm: float, problem: Problem, wish: Wish) -> Survey:
    """The largest face that takes the code, alone or with the faces it runs smoothly into."""
    areas = np.bincount(host.body.face_of, host.body.areas_mm2, minlength=len(host.faces))
    order = [int(i) for i in np.argsort(-areas, kind="stable")[:FACES_TRIED] if areas[i] > 0]

    def first(size: float, among: list[int]) -> tuple[int, Survey] | None:
        tried = ((i, _on_face(host, i, size, problem, wish.up)) for i in among)
        return next(((i, found) for i, found in tried if found is not None), None)

    if (chosen := first(size_mm, order)) is not None:
        return chosen[1]
    centres = [_centre(host, i, wish.up) for i in order[:FACES_SIZED]]
    middles = surveys(host.body, [frame for frame in centres if frame is not None], size_mm)
    if not middles:
        raise DesignError(f"{host.name!r} has no face with a middle to lay a code on: name a point")
    nearly = [found for found in middles if found.front_problem() is None] or middles
    reason = problem(nearly[0]) or "no place takes it"
    few = order[:FACES_SIZED]
    largest = largest_below(size_mm, lambda size: first(size, few) is not None)
    remedy = ""
    if largest and (smaller := first(largest, few)) is not None:
        remedy = f"; at most {floored(largest)} mm fits: face={smaller[0] + 1}"
    raise DesignError(
        f"no face of {host.name!r} takes a code of {size_mm:.4g} mm; in the middle of the largest, "
        f"{reason}{remedy}"
    )


def _on_face(host: Host, index: int, size_mm: float, problem: Problem, up: ArrayLike | None) -> Survey | None:
    """The first spot of a face, from its middle outwards, that takes the code; best one without edges or
    seams.
    """
    over_edges: Survey | None = None
    for rough in _promising(host, index, size_mm, problem, up):
        depth = rough.thickness_mm + float(np.abs(rough.height_mm).max())
        clear = not host.has_edges_under(rough.frame, size_mm, depth)
        if not clear and over_edges is not None:
            continue
        frame = host.frame_near(index, rough.frame.origin, rough.frame.axes[1])
        fine = None if frame is None else survey(host.body, frame, size_mm)
        if fine is not None and problem(fine) is None:
            if clear:
                return fine
            over_edges = fine
    return over_edges


def _promising(
    host: Host, index: int, size_mm: float, problem: Problem, up: ArrayLike | None
) -> Iterator[Survey]:
    """Spots of a face that a coarse survey finds good, those next to its middle first; without a wish for
    `up`, turned ones at the end.
    """
    points, normals, _ = host.body.samples(CANDIDATES, SEED, np.array([index]))
    middle = points.mean(axis=0)
    order = np.argsort(np.linalg.norm(points - middle, axis=1), kind="stable")
    frames = [host.frame_near(index, middle, up)]
    frames += [frame_at(p, n, up) for p, n in zip(points[order], normals[order], strict=True)]
    level = [frame for frame in frames if frame is not None]
    few = level[: CANDIDATES // 8]
    for angle in TURNS_DEG if up is None else TURNS_DEG[:1]:
        turned = level if angle == 0 else [frame.turned(angle) for frame in few]
        yield from (f for f in surveys(host.body, turned, size_mm, COARSE) if problem(f) is None)


def _centre(host: Host, index: int, up: ArrayLike | None) -> Frame | None:
    """The frame nearest to the middle of a face; None where no spot has one."""
    points, _, _ = host.body.samples(CANDIDATES, SEED, np.array([index]))
    middle = points.mean(axis=0)
    order = np.argsort(np.linalg.norm(points - middle, axis=1), kind="stable")
    found = (host.frame_near(index, p, up) for p in (middle, *points[order]))
    return next((f for f in found if f is not None), None)


def _judged(host: Host, frame: Frame, size_mm: float, problem: Problem, wish: Wish) -> Survey:
    """The survey at one frame, or the refusal with what would work instead."""
    found = survey(host.body, frame, size_mm)
    reason = problem(found)
    if reason is None:
        return found
    largest = _largest_mm(host, frame, problem, size_mm)
    nearest = _nearest(host, frame, size_mm, problem, wish.up)
    if nearest is None:
        remedy = _size(largest) or "; no place on the part takes it: choose a smaller size"
    else:
        away = float(np.linalg.norm(nearest.origin - frame.origin))
        remedy = (
            f"{_size(largest)}; the nearest place that works is {away:.3g} mm away: "
            f"point={triple(nearest.origin)} "
            f"direction={triple(-nearest.axes[2])}"
        )
    raise DesignError(f"a code of {size_mm:.4g} mm does not work at {triple(frame.origin)}: {reason}{remedy}")


def _largest_mm(host: Host, frame: Frame, problem: Problem, size_mm: float) -> float:
    """Edge of the largest code below `size_mm` that works at a frame, 0 when none does."""
    return largest_below(size_mm, lambda size: problem(survey(host.body, frame, size)) is None)


def _nearest(
    host: Host, frame: Frame, size_mm: float, problem: Problem, up: ArrayLike | None
) -> Frame | None:
    points, normals, faces = host.body.samples(2 * CANDIDATES, SEED)
    facing = normals @ frame.axes[2]
    # The same side of the part first: another side is rarely what was meant.
    order = np.lexsort((np.linalg.norm(points - frame.origin, axis=1), facing < 0.5))
    frames = [(i, frame_at(points[i], normals[i], up)) for i in order]
    usable = [(i, f) for i, f in frames if f is not None]
    coarse = surveys(host.body, [f for _, f in usable], size_mm, COARSE)
    for (i, _), rough in zip(usable, coarse, strict=True):
        if problem(rough) is not None:
            continue
        spot = host.frame_near(int(faces[i]), points[i], up)
        if spot is not None and problem(survey(host.body, spot, size_mm)) is None:
            return spot
    return None


def _at_point(host: Host, wish: Wish) -> Frame:
    """Where the reader, at the point and looking along the direction, first meets the part.

    A point on the surface itself is taken as it is; without a direction the nearest surface is meant.
    """
    point, look = np.asarray(wish.point, float), wish.look()
    index, on = host.nearest(point)
    if look is None or np.linalg.norm(on - point) < ON_FACE_MM:
        return _required(host, index, on, wish)
    entered = host.body.first_entered(point, look)
    if entered is None:
        raise DesignError(
            f"looking from {triple(point)} along {triple(look)} meets no outer face of {host.name!r} (the "
            f"nearest is face {index + 1} at {triple(on)}): move the point, or give one on the surface"
        )
    triangle, hit = entered
    return _required(host, int(host.body.face_of[triangle]), hit, wish)


def _required(host: Host, face: int, at: Array, wish: Wish) -> Frame:
    """The frame on a face next to a point. Raises `DesignError` where the surface or `up` gives none."""
    frame = host.frame_near(face, at, wish.up)
    if frame is not None:
        return frame
    if wish.up is not None and host.frame_near(face, at, None) is not None:
        raise DesignError(f"up={triple(wish.up)} points along the normal of face {face + 1}: choose another")
    raise DesignError(f"the surface has no normal at {triple(at)}: move the point a little")


def _number(host: Host, face: int) -> int:
    if not 1 <= face <= len(host.faces):
        raise DesignError(f"face {face} does not exist: {host.name!r} has faces 1 to {len(host.faces)}")
    return face - 1


def _size(largest_mm: float) -> str:
    return f"; at most {floored(largest_mm)} mm works there" if largest_mm > 0 else ""
