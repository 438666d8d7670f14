"""What a pattern becomes in the depth of a wall: loops and heights, before any solid is built.

Walls of the holes and their flare, recessed bars, pockets, letters and the plate behind. All is 2-D with
depths; no surface in space, no modeller.
"""

from perfqr_cad.profile.backing import Backing
from perfqr_cad.profile.caption import Caption
from perfqr_cad.profile.profile import Profile
from perfqr_cad.profile.walls import Walls

__all__ = ["Backing", "Caption", "Profile", "Walls"]
