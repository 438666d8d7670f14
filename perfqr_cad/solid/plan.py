"""What is to be made of a pattern: its loops, and everything that goes beside them."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

from perfqr_cad.pattern import Bridge
from perfqr_cad.pattern.outline import Circle, Region

from .flare import NoFlare
from .lettering import Lettering
from .recess import NoRecess
from .relief import lettered
from .sections import Sections, sections
from .walls import Walls


@dataclass(frozen=True)
class Plan:
    """Loops of the pattern plane, mm.

    front       pieces of the front face, the one with the part's outline first
    bars        recessed bars that join them behind
    flush       one region, bars included, for where they cannot lie behind the face; None without bars
    min_web_mm  of the material at the back of drafted walls
    mounts      holes of the front that go straight through whatever the walls do
    lettering   on the first piece; None without
    """

    front: tuple[Region, ...]
    bars: tuple[Bridge, ...] = ()
    flush: Region | None = None
    min_web_mm: float = 0.0
    mounts: Collection[Circle] = ()
    lettering: Lettering | None = None

    def sections(
        self, thickness_mm: float, walls: Walls, whole_circles: bool, *, rim: bool = True
    ) -> tuple[Sections, tuple[str, ...]]:
        """The loops at each depth, and what was made otherwise than asked; see `sections.sections`."""
        try:
            found, notes = self._cut(thickness_mm, walls, whole_circles, rim)
        except NoFlare as reason:
            if not walls.or_straight:
                raise
            straight = replace(walls, draft_deg=0.0)
            found, notes = self._cut(thickness_mm, straight, whole_circles, rim)
            notes = (*notes, f"the walls are straight: {reason}")
        return found if self.lettering is None else lettered(found, self.lettering), notes

    def _cut(
        self, thickness_mm: float, walls: Walls, whole_circles: bool, rim: bool
    ) -> tuple[Sections, tuple[str, ...]]:
        """The same without letters; with flush bars where they cannot lie behind the face."""

        def cut(front: tuple[Region, ...], bars: tuple[Bridge, ...]) -> Sections:
            return sections(
                front,
                thickness_mm,
                walls,
                whole_circles,
                bars=bars,
                min_web_mm=self.min_web_mm,
                rim=rim,
                mounts=self.mounts,
            )

        try:
            return cut(self.front, self.bars), ()
        except NoRecess as reason:
            assert self.flush is not None  # bars come with the region that has them flush
            return cut((self.flush,), ()), (str(reason),)
