"""The search for the place of a code on a mesh: a given spot, or the flattest that takes it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from perfqr_cad.errors import DesignError
from perfqr_cad.hosts.body import Body
from perfqr_cad.hosts.frame import Frame, frame_at
from perfqr_cad.hosts.place import PlaceRequest, PlaceSearch, Problem, Spot, floored, largest_below
from perfqr_cad.hosts.survey import COARSE, Survey, coarse_surveys, survey
from perfqr_cad.remedy import Remedy

CANDIDATES = 250  # spots tried
BEST = 12  # of them judged finely, the flattest first
OUTER = (0,)  # numbers of outer surfaces
AVERAGED = 3  # rounds of turning the axis towards the mean normal under the code
ON_SURFACE_SHARE = 1e-3  # of the diagonal: a given point this near to the surface is on it


def place(body: Body, wanted: PlaceRequest, size_mm: float, problem: Problem) -> Survey:
    """The survey of the place for a code of that edge; see `PlaceSearch.place`."""
    return MeshSearch(body, "the mesh", wanted, problem).place(size_mm)


@dataclass(frozen=True)
class MeshSearch(PlaceSearch):
    """A search on a mesh: the axis is the mean normal under the code, since one facet's own says little."""

    @property
    def on_surface_mm(self) -> float:
        return ON_SURFACE_SHARE * self.body.diagonal_mm

    @property
    def candidates(self) -> Sequence[Spot]:
        return self.sampled(CANDIDATES, OUTER)

    def survey_at(self, spot: Spot, size_mm: float) -> Survey | None:
        (rough,) = self.rough_surveys([spot], size_mm)
        return None if rough is None else survey(self.body, rough.frame, size_mm)

    def rough_surveys(self, spots: Sequence[Spot], size_mm: float) -> Sequence[Survey | None]:
        frames = [frame_at(spot.point, spot.normal, self.wanted.up) for spot in spots]
        for _ in range(AVERAGED):
            found = coarse_surveys(self.body, frames, size_mm)
            frames = [None if rough is None else _averaged(rough, self.wanted.up) for rough in found]
        return coarse_surveys(self.body, frames, size_mm)

    def searched(self, size_mm: float) -> Survey:
        """At the spot with the least worst tilt among samples of the surface."""
        found, reasons = self._flattest(size_mm)
        if found is not None:
            return found
        commonest = reasons.most_common(1)[0][0] if reasons else "steps between the samples"
        largest = largest_below(size_mm, lambda size: self._flattest(size)[0] is not None)
        raise DesignError(
            f"no spot of the mesh takes a code of {size_mm:.4g} mm ({CANDIDATES} tried); mostly, {commonest}",
            *([Remedy(size_mm=floored(largest))] if largest else []),
        )

    def _flattest(self, size_mm: float) -> tuple[Survey | None, Counter[str]]:
        """The flattest spot that works, if any, and what is wrong with the others: of those with a good
        front, where there are any."""
        rough = [found for found in self.rough_surveys(self.candidates, size_mm) if found is not None]
        good = [found for found in rough if self.problem(found) is None]
        good.sort(key=lambda found: float(np.nanmax(found.tilt_deg)))
        fine = (survey(self.body, found.frame, size_mm) for found in good[:BEST])
        flattest = next((found for found in fine if self.problem(found) is None), None)
        nearly = [found for found in rough if found.front_problem() is None] or rough
        return flattest, Counter(reason for found in nearly if (reason := self.problem(found)) is not None)


def _averaged(found: Survey, up: ArrayLike | None) -> Frame | None:
    """The frame on the surface before the middle, its axis the mean normal of what was surveyed; None where
    that has no meaning."""
    middle = found.height_mm[COARSE // 2, COARSE // 2]
    mean = np.nansum(found.normal.reshape(-1, 3), axis=0)
    if not np.isfinite(middle) or np.linalg.norm(mean) < 1e-9:
        return None
    return frame_at(found.frame.to_space([[0.0, 0.0, middle]])[0], mean @ found.frame.axes, up)
