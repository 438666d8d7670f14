"""The search for the place of a code on a solid: a given face or spot, or the largest face that takes it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry.arrays import Array
from perfqr_cad.hosts.frame import Frame, frame_at
from perfqr_cad.hosts.place import (
    PlaceRequest,
    PlaceSearch,
    Problem,
    Spot,
    floored,
    largest_below,
    triple,
)
from perfqr_cad.hosts.step.host import Host
from perfqr_cad.hosts.survey import COARSE, Survey, coarse_surveys, survey, surveys
from perfqr_cad.remedy import Remedy

CANDIDATES = 160  # spots tried on one face, half of those tried round a spot that does not work
FACES_TRIED = 40
FACES_SIZED = 4  # of them asked for the largest code when none takes the one that is wanted
TURNS_DEG = (0.0, 45.0, 30.0, 60.0, 15.0, 75.0)


def place(host: Host, wanted: PlaceRequest, size_mm: float, problem: Problem, seen: float = 1.0) -> Survey:
    """The survey of the place for a code of that edge; see `PlaceSearch.place`.

    seen   share of the edge that is surveyed: a code that is laid along the wall turns away at its sides
    """
    return FaceSearch(host.body, repr(host.name), wanted, problem, host, seen).place(size_mm)


@dataclass(frozen=True)
class FaceSearch(PlaceSearch):
    """A search on a solid: frames are those of its exact faces."""

    host: Host
    seen: float = 1.0

    @property
    def on_surface_mm(self) -> float:
        return 1e-3

    @property
    def candidates(self) -> Sequence[Spot]:
        return self.sampled(2 * CANDIDATES)

    def survey_at(self, spot: Spot, size_mm: float) -> Survey | None:
        frame = self.host.frame_near(spot.face, spot.point, self.wanted.up)
        return None if frame is None else survey(self.body, frame, self.seen * size_mm)

    def rough_surveys(self, spots: Sequence[Spot], size_mm: float) -> Sequence[Survey | None]:
        frames = [frame_at(spot.point, spot.normal, self.wanted.up) for spot in spots]
        return coarse_surveys(self.body, frames, self.seen * size_mm)

    def met(self) -> Spot:
        """As `PlaceSearch.met`. Raises `DesignError` where the surface or `up` gives no frame."""
        spot, up = super().met(), self.wanted.up
        if self.host.frame_near(spot.face, spot.point, up) is not None:
            return spot
        if up is not None and self.host.frame_near(spot.face, spot.point, None) is not None:
            raise DesignError(
                f"up={triple(up)} points along the normal of face {spot.face + 1}: choose another"
            )
        raise DesignError(f"the surface has no normal at {triple(spot.point)}: move the point a little")

    def searched(self, size_mm: float) -> Survey:
        """On the face that is asked for, or on the largest that takes the code."""
        if self.wanted.face is None:
            return self._on_largest(size_mm)
        index = self._number(self.wanted.face)
        if (found := self._on_face(index, size_mm)) is not None:
            return found
        centre = self._centre(index)
        if centre is None:
            raise DesignError(
                f"face {index + 1} of {self.name} has no usable spot: choose another face or up"
            )
        return self.judged(Spot(centre.origin, centre.axes[2], index), size_mm)

    def _on_largest(self, size_mm: float) -> Survey:
        """On the largest face that takes the code, alone or with the faces it runs smoothly into."""
        areas = np.bincount(self.body.face_of, self.body.areas_mm2, minlength=len(self.host.faces))
        order = [int(i) for i in np.argsort(-areas, kind="stable")[:FACES_TRIED] if areas[i] > 0]
        if (chosen := self._first(order, size_mm)) is not None:
            return chosen[1]
        few = order[:FACES_SIZED]
        centres = [frame for i in few if (frame := self._centre(i)) is not None]
        middles = surveys(self.body, centres, self.seen * size_mm)
        if not middles:
            raise DesignError(f"{self.name} has no face with a middle for a code: name a point")
        nearly = [found for found in middles if found.front_problem() is None] or middles
        reason = self.problem(nearly[0]) or "no place takes it"
        largest = largest_below(size_mm, lambda size: self._first(few, size) is not None)
        raise DesignError(
            f"no face of {self.name} takes a code of {size_mm:.4g} mm; in the middle of the largest, "
            f"{reason}",
            *([Remedy(size_mm=floored(largest))] if largest else []),
        )

    def _first(self, faces: Sequence[int], size_mm: float) -> tuple[int, Survey] | None:
        """The first of some faces that takes the code, and where."""
        tried = ((i, self._on_face(i, size_mm)) for i in faces)
        return next(((i, found) for i, found in tried if found is not None), None)

    def _on_face(self, index: int, size_mm: float) -> Survey | None:
        """The first spot of a face, from its middle outwards, that takes the code; best one without edges or
        seams."""
        over_edges: Survey | None = None
        for rough in self._promising(index, size_mm):
            depth = rough.thickness_mm + float(np.abs(rough.height_mm).max())
            clear = not self.host.has_edges_under(rough.frame, self.seen * size_mm, depth)
            if not clear and over_edges is not None:
                continue
            frame = self.host.frame_near(index, rough.frame.origin, rough.frame.axes[1])
            fine = None if frame is None else survey(self.body, frame, self.seen * size_mm)
            if fine is not None and self.problem(fine) is None:
                if clear:
                    return fine
                over_edges = fine
        return over_edges

    def _promising(self, index: int, size_mm: float) -> Iterator[Survey]:
        """Spots of a face that a coarse survey finds good, those next to its middle first; without a wanted
        `up`, turned ones at the end."""
        up = self.wanted.up
        middle, spots = self._from_the_middle(index)
        frames = [self.host.frame_near(index, middle, up)]
        frames += [frame_at(spot.point, spot.normal, up) for spot in spots]
        level = [frame for frame in frames if frame is not None]
        few = level[: CANDIDATES // 8]
        for angle in TURNS_DEG if up is None else TURNS_DEG[:1]:
            turned = level if angle == 0 else [frame.turned(angle) for frame in few]
            yield from (
                f for f in surveys(self.body, turned, self.seen * size_mm, COARSE) if self.problem(f) is None
            )

    def _centre(self, index: int) -> Frame | None:
        """The frame nearest to the middle of a face; None where no spot has one."""
        middle, spots = self._from_the_middle(index)
        points = (middle, *(spot.point for spot in spots))
        found = (self.host.frame_near(index, point, self.wanted.up) for point in points)
        return next((frame for frame in found if frame is not None), None)

    def _from_the_middle(self, index: int) -> tuple[Array, list[Spot]]:
        """The middle (3,) of a face, and spots of it, the nearest to it first."""
        spots = self.sampled(CANDIDATES, [index])
        points = np.array([spot.point for spot in spots])
        middle = self.body.middle_of(index)
        if middle is None:  # a face that runs all round is nowhere nearest to it: any side will do
            middle = points.mean(axis=0)
        order = np.argsort(np.linalg.norm(points - middle, axis=1), kind="stable")
        return middle, [spots[i] for i in order.tolist()]

    def _number(self, face: int) -> int:
        if not 1 <= face <= len(self.host.faces):
            raise DesignError(
                f"face {face} does not exist: {self.name} has faces 1 to {len(self.host.faces)}"
            )
        return face - 1
