"""The profile of a part: its outlines in the pattern plane, and everything that goes beside them."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from perfqr_cad.geometry.outline import Circle, Region
from perfqr_cad.pattern import Bridge
from perfqr_cad.profile.flare import NoFlare
from perfqr_cad.profile.letter_lofts import lettered
from perfqr_cad.profile.recess import NoRecess
from perfqr_cad.profile.sections import Sections, sections
from perfqr_cad.profile.walls import Walls

if TYPE_CHECKING:
    from perfqr_cad.pattern import Pattern


@dataclass(frozen=True)
class Profile:
    """Outlines in the pattern plane, mm.

    front       pieces of the front face, the one with the part's outline first
    bars        recessed bars that join them behind
    flush       one region, bars included, for where they cannot lie behind the face; None without bars
    min_web_mm  of the material at the back of drafted walls
    mounts      holes of the front that go straight through whatever the walls do
    letters     on the first piece, raised by `relief_mm`, or engraved where that is below 0

    >>> from perfqr_cad.geometry import Loop, Region
    >>> plate = Region(Loop.from_points([(0, 0), (4, 0), (4, 3), (0, 3)]))
    >>> [loft.levels[-1].depth_mm for loft in Profile((plate,)).sections(2.0, Walls()).lofts]
    [2.0]
    """

    front: tuple[Region, ...]
    bars: tuple[Bridge, ...] = ()
    flush: Region | None = None
    min_web_mm: float = 0.0
    mounts: Collection[Circle] = ()
    letters: tuple[Region, ...] = ()
    relief_mm: float = 0.0

    @staticmethod
    def of(pattern: Pattern) -> Profile:
        """The profile of a pattern's own part, without letters."""
        mounts = pattern.spec.surround.all_holes(pattern.size_mm)
        return Profile(
            pattern.front,
            pattern.recessed,
            pattern.region,
            pattern.spec.web_mm,
            tuple(hole.circle for hole in mounts),
        )

    def with_flush_bars(self) -> Profile:
        """The same with all bars flush with the face."""
        return self if self.flush is None else replace(self, front=(self.flush,), bars=(), flush=None)

    def without_bars(self) -> Profile:
        """The same without recessed bars, its pieces not joined."""
        return replace(self, bars=(), flush=None)

    def sections(
        self, thickness_mm: float, walls: Walls, *, whole_circles: bool = False, rim: bool = True
    ) -> Sections:
        """The outlines at each depth; see `sections.sections`.

        Raises `NoRecess` where bars cannot lie behind the face, `NoFlare` where no wall can flare.
        """
        cut = sections(
            self.front,
            thickness_mm,
            walls,
            whole_circles,
            bars=self.bars,
            min_web_mm=self.min_web_mm,
            rim=rim,
            mounts=self.mounts,
        )
        return lettered(cut, self.letters, self.relief_mm)

    def feasible_sections(
        self, thickness_mm: float, walls: Walls, *, whole_circles: bool = False
    ) -> tuple[Sections, tuple[str, ...]]:
        """The same with bars flush, or if `walls.or_straight` walls straight, where they cannot be as asked;
        and notes that say so."""
        try:
            return self._recessed_or_flush(thickness_mm, walls, whole_circles)
        except NoFlare as reason:
            if not walls.or_straight:
                raise
            straight = replace(walls, draft_deg=0.0)
            found, notes = self._recessed_or_flush(thickness_mm, straight, whole_circles)
            return found, (*notes, f"the walls are straight: {reason}")

    def _recessed_or_flush(
        self, thickness_mm: float, walls: Walls, whole_circles: bool
    ) -> tuple[Sections, tuple[str, ...]]:
        try:
            return self.sections(thickness_mm, walls, whole_circles=whole_circles), ()
        except NoRecess as reason:
            flush = self.with_flush_bars()
            return flush.sections(thickness_mm, walls, whole_circles=whole_circles), (str(reason),)
