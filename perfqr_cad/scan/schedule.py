"""Which views of a part are filmed, and before which grounds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from perfqr_cad.scan.camera.camera import View
from perfqr_cad.scan.colours import BACKGROUNDS
from perfqr_cad.scan.grounds import GROUNDS, Ground

# The paper gives a scanner 2 s. A phone decodes ten frames and more in that time, of which these are tried.
PATIENCE = 3
# Whether a part reads at all must not hang on the noise of one frame, nor on one distance: who scans from
# straight above moves the phone until it reads. Picture sizes of the frontal frames, of the schedule's own.
NEARER = (1.0, 1.25, 0.8, 1.25, 1.5)
FRONTAL_FRAMES = len(NEARER)
STEEP_DEG = 45.0  # beyond it few read anything: every second side tells enough


@dataclass(frozen=True)
class Schedule:
    """Which views are filmed. Tilts rise from 0; each is filmed from every azimuth.

    frames         a view is missed when this many frames of an unsteady hand are; the frontal view always
                   gets `FRONTAL_FRAMES`
    backgrounds    colours before which the part is filmed from straight above
    grounds        before which it is filmed at `ground_tilts_deg` from `ground_sides` of the azimuths
    ground_known   the ground of the look is what will be behind the part: no other is looked at
    """

    tilts_deg: tuple[float, ...]
    azimuths_deg: tuple[float, ...]
    frames: int = 1
    backgrounds: tuple[str, ...] = ()
    size_px: int = 800
    grounds: tuple[Ground, ...] = ()
    ground_tilts_deg: tuple[float, ...] = (0.0, 20.0)
    ground_sides: int = 1
    ground_known: bool = False

    def patience(self, views: Sequence[View]) -> list[int]:
        """Frames for each of some views."""
        frontal = max(self.frames, FRONTAL_FRAMES)
        return [frontal if view.tilt_deg == 0 else self.frames for view in views]

    def views(self) -> list[View]:
        """Every view, the frontal one once.

        >>> [(view.tilt_deg, view.azimuth_deg) for view in Schedule((0.0, 30.0), (65.0, 205.0)).views()]
        [(0.0, 65.0), (30.0, 65.0), (30.0, 205.0)]
        """
        return [view for tilt in self.tilts_deg for view in self._around(tilt, 2 if tilt > STEEP_DEG else 1)]

    def flat_views(self) -> list[View]:
        """Those of the flat print: it has no walls that hide more from one side than from another."""
        return [view for tilt in self.tilts_deg for view in self._around(tilt, 2)]

    def ground_views(self) -> list[View]:
        """Those before each of the grounds."""
        every = len(self.azimuths_deg) // self.ground_sides
        return [view for tilt in self.ground_tilts_deg for view in self._around(tilt, every)]

    def _around(self, tilt_deg: float, every: int) -> list[View]:
        """The views at one tilt from every so many of the sides."""
        sides = self.azimuths_deg[:: max(1, every)] if tilt_deg > 0 else self.azimuths_deg[:1]
        return [View(tilt_deg, side, size_px=self.size_px) for side in sides]


# Near the code's axes, where walls hide most; the full schedule has the diagonals between them too.
QUICK = Schedule(
    (0.0, 20.0, 30.0), (25.0, 115.0, 205.0, 295.0), frames=PATIENCE, size_px=720, grounds=GROUNDS
)
FULL = Schedule(
    (0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0),
    tuple(25.0 + 45.0 * side for side in range(8)),
    frames=PATIENCE,
    backgrounds=tuple(BACKGROUNDS),
    grounds=GROUNDS,
    ground_tilts_deg=(0.0, 20.0, 30.0),
    ground_sides=2,
)
