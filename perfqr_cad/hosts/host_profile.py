"""The profile of a code in a wall that is not ours: its bars are as high as that wall asks for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry.outline import Loop
from perfqr_cad.hosts.body import Body
from perfqr_cad.hosts.host_placement import HostPlacement
from perfqr_cad.hosts.probe import probe
from perfqr_cad.pattern import Bridge, Pattern
from perfqr_cad.profile import Profile


def host_profile(pattern: Pattern) -> Profile:
    """The profile of a pattern that a host's wall goes on around. Raises `DesignError` for the inverted
    tone."""
    if pattern.spec.tone == "inverted":
        raise DesignError(
            "tone inverted leaves dark material around the code where its light margin must be: "
            "carve tone normal into a light wall, or make a plate"
        )
    return Profile.of(pattern)


def with_fitted_bars(profile: Profile, body: Body, placement: HostPlacement) -> Profile:
    """The same with bars as high, counted from the wall's nominal back, as they are in its thinnest spot
    under them: no bar is lower than asked, none comes nearer to the front."""
    if not profile.bars:
        return profile
    corners = np.vstack([loop.flatten() for loop in bar_loops(profile.bars)])
    lines, frames = placement.line(corners)
    spare = placement.thickness_mm - float(np.nanmin(probe(body, lines, frames[:, 2]).wall_mm))
    bars = tuple(replace(bar, height_mm=(bar.height_mm or 0.0) + spare) for bar in profile.bars)
    return replace(profile, bars=bars)


def bar_loops(bars: Sequence[Bridge], longer_mm: float = 0.0) -> list[Loop]:
    """Bars as rectangles, longer at both ends."""
    return [Loop.from_points(bar.lengthened(longer_mm).corners()) for bar in bars]
