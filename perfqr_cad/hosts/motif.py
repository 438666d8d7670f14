"""What is carved into a wall that is not ours: the front's pieces, the bars behind it, and both as one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry.outline import Loop, Region
from perfqr_cad.hosts.body import Body
from perfqr_cad.hosts.lay import Laid
from perfqr_cad.hosts.probe import probe
from perfqr_cad.pattern import Bridge
from perfqr_cad.profile.recess import top_depth_mm
from perfqr_cad.profile.sections import Sections, sections
from perfqr_cad.profile.walls import Walls

if TYPE_CHECKING:
    from perfqr_cad.pattern import Pattern


@dataclass(frozen=True)
class Motif:
    """A pattern as a wall takes it.

    front       the pieces of the front face, the first of them part of the wall around the code
    bars        recessed bars that hold the others, of full height in the thinnest wall under them
    flush       the material with all bars flush
    min_web_mm  least width of material at the back of drafted walls
    """

    front: tuple[Region, ...]
    bars: tuple[Bridge, ...]
    flush: Region
    min_web_mm: float = 0.0

    @staticmethod
    def of(pattern: Pattern) -> Motif:
        """The motif of a pattern. Raises `DesignError` for the inverted tone."""
        if pattern.spec.tone == "inverted":
            raise DesignError(
                "tone inverted leaves dark material around the code where its light margin must be: "
                "carve tone normal into a light wall, or make a plate"
            )
        return Motif(pattern.front, pattern.recessed, pattern.region, pattern.spec.web_mm)

    @staticmethod
    def plain(region: Region) -> Motif:
        """A region without bars."""
        return Motif((region,), (), region)

    def flushed(self) -> Motif:
        """The same with flush bars."""
        return Motif((self.flush,), (), self.flush, self.min_web_mm)

    def fitted(self, body: Body, laid: Laid) -> Motif:
        """The same with bars as high, counted from the wall's nominal back, as they are in its thinnest
        spot under them: no bar is lower than asked, none comes nearer to the front.
        """
        if not self.bars:
            return self
        corners = np.vstack([loop.flatten() for loop in self.bar_loops(0.0)])
        lines, frames = laid.line(corners)
        spare = laid.thickness_mm - float(np.nanmin(probe(body, lines, frames[:, 2]).wall_mm))
        bars = tuple(replace(bar, height_mm=(bar.height_mm or 0.0) + spare) for bar in self.bars)
        return replace(self, bars=bars)

    def sections(self, thickness_mm: float, walls: Walls, *, barred: bool) -> Sections:
        """The wells of the front, with the bars or without; raises as `sections.sections` does."""
        bars = self.bars if barred else ()
        return sections(
            self.front, thickness_mm, walls, False, bars=bars, min_web_mm=self.min_web_mm, rim=False
        )

    def top_depth_mm(self, thickness_mm: float) -> float:
        """Depth of the bars' tops. Raises `NoRecess` where the wall is too thin."""
        return top_depth_mm(self.bars, thickness_mm)

    def bar_loops(self, longer_mm: float) -> Sequence[Loop]:
        """The bars as rectangles, longer at both ends."""
        return [_rectangle(bar, longer_mm) for bar in self.bars]


def _rectangle(bar: Bridge, longer_mm: float) -> Loop:
    start, end = np.array(bar.start), np.array(bar.end)
    along = (end - start) / np.linalg.norm(end - start)
    side = bar.width_mm / 2 * np.array([-along[1], along[0]])
    start, end = start - longer_mm * along, end + longer_mm * along
    corners = (start - side, end - side, end + side, start + side)
    return Loop.from_points([(float(x), float(y)) for x, y in corners])
