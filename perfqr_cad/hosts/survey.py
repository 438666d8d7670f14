"""The survey of the wall under a code: heights, thickness, slopes, edges, what is in the way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.geometry.arrays import Array, Indices, Mask
from perfqr_cad.hosts.body import Body
from perfqr_cad.hosts.frame import Frame
from perfqr_cad.hosts.probe import probe
from perfqr_cad.surface import DistortionLimit

MAX_TILT_DEG = DistortionLimit().tilt_deg
MAX_CREASE_DEG = 20.0  # a sharper edge under the code catches light and shade like a module's
MAX_UNEVEN = 2.0  # greatest over least wall: beyond, one thickness no longer describes the wall's strength
# A hole is read at up to 20-30° of tilt when the wall is 0.6-0.9 of a module high, and only from straight
# ahead when it is much deeper; a wall over this many modules is a block, not a wall.
MAX_WALL_MODULES = 5.0
# A version-1 code with its quiet zone is 29 modules wide: the widest module a code of given size can have.
LEAST_MODULES = 29
STEP_SLACK = 0.05  # of the sample spacing: height change that no slope explains
INSET = 1e-4  # of the code's edge: rays of the rim fall just inside a face of exactly the code's size
OFF_SPOT = 1e-3  # of the code's edge: the surface at the centre against the frame's origin
FINE, COARSE = 61, 9  # samples a side: to judge a place, and to look for one


@dataclass(frozen=True)
class Survey:
    """The wall under a square of edge `size_mm`, sampled on a grid (k, k); row 0 at the bottom, column 0
    left.

    height_mm   of the front above the tangent plane, NaN where there is no front
    wall_mm     material behind the front along the axis, NaN where unknown
    tilt_deg    of the front against the axis
    normal      (k, k, 3) in frame coordinates
    front, back numbers of the faces, -1 for none
    hidden      something of the part stands before the front
    faceted     the body is a plain mesh, whose slopes jump from facet to facet
    """

    frame: Frame
    size_mm: float
    height_mm: Array
    wall_mm: Array
    tilt_deg: Array
    normal: Array
    front: Indices
    back: Indices
    hidden: Mask
    faceted: bool = False

    @property
    def thickness_mm(self) -> float:
        """Median wall."""
        return float(np.nanmedian(self.wall_mm))

    def sheet_mm(self, depth_mm: float | None) -> float:
        """Thickness of the sheet that carries the code: the wall, or of a block with pockets `depth_mm` deep
        as much as they disturb, twice their depth."""
        return self.thickness_mm if depth_mm is None else min(self.thickness_mm, 2 * depth_mm)

    @property
    def thickness_range_mm(self) -> tuple[float, float]:
        """Least and greatest wall."""
        return float(np.nanmin(self.wall_mm)), float(np.nanmax(self.wall_mm))

    def problem(self, depth_mm: float | None) -> str | None:
        """Why the code cannot be carved here, as through-holes or pockets `depth_mm` deep, or None."""
        return self.front_problem() or self.wall_problem(depth_mm)

    def front_problem(self) -> str | None:
        """Why the front cannot carry the code, or None."""
        missing = np.isnan(self.height_mm)
        if missing.all():
            return "there is no material under the code"
        if missing.any():
            return f"{_share(missing)} of the code hangs over the edge of the part"
        middle = len(self.height_mm) // 2
        if abs(self.height_mm[middle, middle]) > OFF_SPOT * self.size_mm:
            return "the middle of the code falls into an opening or recess of the face"
        if self.hidden.any():
            return f"{_share(self.hidden)} of the code is hidden behind other walls of the part"
        if (jump := self._steps()).any():
            return f"the code runs over a step, opening or rib of the surface ({_share(jump)} of its area)"
        worst = float(self.tilt_deg.max())
        if worst > MAX_TILT_DEG:
            return (
                f"the surface turns {worst:.0f}° away from the reader under the code "
                f"(limit {MAX_TILT_DEG:.0f}°)"
            )
        crease = self._crease_deg()
        if crease > MAX_CREASE_DEG:
            return (
                f"the code runs over an edge of the face that bends {crease:.0f}° "
                f"(limit {MAX_CREASE_DEG:.0f}°)"
            )
        return None

    def wall_problem(self, depth_mm: float | None) -> str | None:
        """Why the wall behind the front cannot be perforated (or pocketed `depth_mm` deep), or None."""
        wall_limit_mm = MAX_WALL_MODULES * self.size_mm / LEAST_MODULES
        if np.isnan(self.wall_mm).any():
            return "the far side of the wall was not found"
        least, most = self.thickness_range_mm
        if depth_mm is not None:
            if depth_mm >= least:
                return (
                    f"pockets of {depth_mm:g} mm break through the wall of {least:.3g} mm: set depth below it"
                )
            return None
        if most > wall_limit_mm:
            return (
                f"{most:.4g} mm of material lie behind the face (limit {wall_limit_mm:.3g} mm for "
                f"through-holes): "
                "set depth (mm) for blind pockets"
            )
        if most > MAX_UNEVEN * least:
            return (
                f"the wall is uneven, {least:.3g} to {most:.3g} mm (limit a ratio of {MAX_UNEVEN:g}): "
                "a rib, boss or slope lies behind"
            )
        return None

    def _steps(self) -> Mask:
        """Samples next to a height change that the slopes on both sides do not explain."""
        spacing = self.size_mm / (len(self.height_mm) - 1)
        marked = np.zeros(self.height_mm.shape, bool)
        for axis, component in ((1, 0), (0, 1)):
            slope = -self.normal[..., component] / np.maximum(self.normal[..., 2], 1e-3)
            low, high = _neighbours(slope, axis)
            change = np.diff(self.height_mm, axis=axis)
            allowed = spacing * (np.abs(high - low) + STEP_SLACK * (1 + np.abs(low) + np.abs(high)))
            bad = np.abs(change - spacing * (low + high) / 2) > allowed
            if self.faceted:  # only what no facet within the tilt limit explains
                bad = np.abs(change) > spacing * np.tan(np.radians(MAX_TILT_DEG))
            first, second = _neighbours(marked, axis)
            first |= bad
            second |= bad
        return marked

    def _crease_deg(self) -> float:
        """Greatest turn of the normal between neighbouring samples on different faces."""
        worst = 0.0
        for axis in (0, 1):
            a, b = _neighbours(self.normal, axis)
            f, g = _neighbours(self.front, axis)
            cosine = np.einsum("ijk,ijk->ij", a, b)[f != g]
            if cosine.size:
                worst = max(worst, float(np.degrees(np.arccos(np.clip(cosine.min(), -1, 1)))))
        return worst


def survey(body: Body, frame: Frame, size_mm: float, samples: int = FINE) -> Survey:
    """Sample the wall under a code that is projected along the frame's normal."""
    return surveys(body, [frame], size_mm, samples)[0]


def surveys(body: Body, frames: Sequence[Frame], size_mm: float, samples: int = FINE) -> list[Survey]:
    """The same for many places, their lines followed at once."""
    half = size_mm * (0.5 - INSET)
    line = np.linspace(-half, half, samples)
    x, y = (a.ravel() for a in np.meshgrid(line, line))
    flat = np.column_stack([x, y, np.zeros(x.size)])
    if not frames:
        return []
    points = np.concatenate([frame.to_space(flat) for frame in frames])
    met = probe(body, points, np.repeat([frame.axes[2] for frame in frames], x.size, axis=0))
    square = (len(frames), samples, samples)
    normal = met.normal.reshape(*square, 3) @ np.stack([frame.axes.T for frame in frames])[:, None]
    tilt = np.degrees(np.arccos(np.clip(normal[..., 2], -1, 1)))
    height = met.offset_mm.reshape(square)
    tilt[np.isnan(height)] = np.nan
    wall, front, back, hidden = (a.reshape(square) for a in (met.wall_mm, met.front, met.back, met.hidden))
    return [
        Survey(
            frame, size_mm, height[k], wall[k], tilt[k], normal[k], front[k], back[k], hidden[k], body.faceted
        )
        for k, frame in enumerate(frames)
    ]


def coarse_surveys(body: Body, frames: Sequence[Frame | None], size_mm: float) -> list[Survey | None]:
    """Coarse surveys of many places, None where there is no frame."""
    made = iter(surveys(body, [frame for frame in frames if frame is not None], size_mm, COARSE))
    return [None if frame is None else next(made) for frame in frames]


def _neighbours(values: NDArray, axis: int) -> tuple[NDArray, NDArray]:
    """Views of all samples but the last, and all but the first, along an axis."""
    return (values[:-1], values[1:]) if axis == 0 else (values[:, :-1], values[:, 1:])


def _share(mask: Mask) -> str:
    return f"{max(mask.mean(), 0.001):.1%}"
