"""A plate before its solid exists: the sections that a pattern and its walls would have.

The search for good walls tries many plates. What the camera needs of a plate is its sections, and those
follow from the outline: walls that flare set every edge back, by as much as the webs allow. The finished
solid is filmed for itself.

The rule is that of `profile.flare`: both sides of a web give way alike, until half the least web is left.
There webs are measured between segments and whole edges set back, exactly; here distances are taken pixel by
pixel, to a fraction of one. So the two share the rule and no step of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import cv2
import numpy as np
from numpy.typing import NDArray

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry.outline import Line
from perfqr_cad.pattern.drawing.front import edge_under
from perfqr_cad.scan.camera import layers
from perfqr_cad.scan.camera.camera import facing_up
from perfqr_cad.scan.camera.marching import Picture
from perfqr_cad.scan.camera.placing import FilmedPart
from perfqr_cad.scan.camera.raster import shrunk
from perfqr_cad.scan.camera.scene import LEAST_WEB_MM, SECTION_PX, STEEPEST_DEG, Scene
from perfqr_cad.scan.camera.stack import MARGIN, Stack, area

if TYPE_CHECKING:
    from perfqr_cad.pattern import Bridge, Pattern

FINER = 2  # distances are measured at this many times the sections' resolution
STEPS = 4  # shares of the flare that webs of different widths are granted


def plate_scene(
    pattern: Pattern, thickness_mm: float, *, draft_deg: float = 0.0, lip_mm: float = 0.0
) -> Scene:
    """The plate that a pattern would be, ready to be filmed.

    Walls stand upright for the lip and flare behind it by the draft, as far as the pattern's least web
    allows; the banks of pinched slots are upright throughout. DesignError if the lip leaves nothing
    to flare.
    """
    if draft_deg > 0 and lip_mm >= thickness_mm:
        raise DesignError(
            f"a lip of {lip_mm:g} mm leaves nothing to flare in {thickness_mm:g} mm: shorten it"
        )
    edge_mm = MARGIN * pattern.size_mm
    depth_mm = np.linspace(0.0, thickness_mm, layers.layers_needed(thickness_mm, STEEPEST_DEG, LEAST_WEB_MM))
    flared_mm = thickness_mm - lip_mm if draft_deg > 0 else 0.0
    flare_mm = flared_mm * float(np.tan(np.radians(draft_deg)))
    walls = _walls(pattern, edge_mm, flare_mm)
    bars = _picture(_reaching(pattern.recessed, flare_mm), edge_mm, SECTION_PX)
    height_mm = max((bar.height_mm or 0.0 for bar in pattern.recessed), default=0.0)
    shares = np.clip((depth_mm - lip_mm) / flared_mm, 0.0, 1.0) if flared_mm > 0 else np.zeros(len(depth_mm))
    kinds = list(zip(shares.tolist(), (depth_mm > thickness_mm - height_mm).tolist(), strict=True))
    sections = {kind: _bytes(walls.section(kind[0]), bars if kind[1] else None) for kind in set(kinds)}
    code = facing_up((0.0, 0.0, thickness_mm), pattern.size_mm)
    meshless = FilmedPart(np.zeros((0, 3)), np.zeros((0, 3), np.int64), code, flat=True)
    return Scene(meshless, sections=Stack(tuple(sections[kind] for kind in kinds), depth_mm, edge_mm))


@dataclass(frozen=True)
class _WallPictures:
    """Walls of a plate as pictures (n, n).

    front    material of the front face, 0 to 1
    inside   distance of the material from the nearest hole, in pixels
    room     how far the nearest wall may be set back at most, in pixels
    """

    front: Picture
    inside: Picture
    room: Picture

    def section(self, share: float) -> Picture:
        """Material where the walls have given way by this share of what they do at the back."""
        if share == 0:
            return self.front
        left = np.clip(self.inside - np.float32(share) * self.room + np.float32(0.5), 0, 1)
        return np.minimum(left, self.front)


def _walls(pattern: Pattern, edge_mm: float, flare_mm: float) -> _WallPictures:
    loops = [loop.flatten() for region in pattern.front for loop in region.loops]
    front = _picture(loops, edge_mm, SECTION_PX)
    if flare_mm == 0:
        return _WallPictures(front, front, 0 * front)
    fine_px = FINER * SECTION_PX
    per_mm = fine_px / edge_mm
    # The plate is taken to go on beyond its outer edge, which stays upright.
    plain = _picture([pattern.front[0].outer.flatten()], edge_mm, fine_px)
    solid = 1 + _picture(loops, edge_mm, fine_px) - plain > 0.5
    inside = _distance(solid)
    room = np.zeros_like(inside)
    for flare_px in np.linspace(0, flare_mm * per_mm, STEPS + 1)[1:]:
        # Discs that keep half the least web when shrunk by this flare; what they cover has room for it.
        radius = flare_px + pattern.spec.web_mm * per_mm / 2
        room[_distance(inside < radius) <= radius] = flare_px
    room[_picture(_upright(pattern, flare_mm), edge_mm, fine_px) > 0.5] = 0
    return _WallPictures(front, _halved(inside), _halved(room))


def _distance(mask: NDArray[np.bool_]) -> Picture:
    """Distance (n, n) of every pixel of a mask from its edge, in pixels; 0 elsewhere."""
    found = np.asarray(cv2.distanceTransform(mask.astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_5), np.float32)
    return np.maximum(found - np.float32(0.5), 0)


def _halved(lengths: Picture) -> Picture:
    """Lengths in fine pixels as lengths in the sections' pixels, on their grid."""
    return shrunk(lengths, (SECTION_PX, SECTION_PX)) / np.float32(FINER)


def _upright(pattern: Pattern, reach_mm: float) -> list[NDArray[np.float64]]:
    """Corners (4, 2) of the material that lies within a reach of the banks of pinched slots."""
    segments = [s for region in pattern.front for loop in region.loops for s in loop.segments]
    lines = [segment for segment in segments if isinstance(segment, Line)]
    starts, ends = (np.array([getattr(line, end) for line in lines]) for end in ("start", "end"))
    strips: list[NDArray[np.float64]] = []
    for point in (end for bar in pattern.recessed if bar.pinched for end in (bar.start, bar.end)):
        k = edge_under(point, starts, ends)
        assert k is not None  # a pattern's recessed bars stand on straight edges
        start, end = starts[k], ends[k]
        inwards = np.array([start[1] - end[1], end[0] - start[0]]) * reach_mm / np.linalg.norm(end - start)
        strips.append(np.array([start, end, end + inwards, start + inwards]))
    return strips


def _reaching(bars: Sequence[Bridge], reach_mm: float) -> list[NDArray[np.float64]]:
    """Corners (4, 2) of bars that reach further at both ends, for walls that give way."""
    return [np.array(bar.lengthened(reach_mm).corners()) for bar in bars]


def _picture(loops: Sequence[NDArray[np.float64]], edge_mm: float, pixels: int) -> Picture:
    """Share (n, n) of every pixel inside directed loops (k, 2) in mm, material on their left."""
    if not loops:
        return np.zeros((pixels, pixels), np.float32)
    sides = np.concatenate([np.stack([loop, np.roll(loop, -1, axis=0)], axis=1) for loop in loops])
    return area(sides * [pixels / edge_mm, -pixels / edge_mm] + pixels / 2, (pixels, pixels))


def _bytes(section: Picture, bars: Picture | None) -> NDArray[np.uint8]:
    covered = section if bars is None else np.maximum(section, bars)
    picture = (255 * covered + 0.5).astype(np.uint8)
    picture.setflags(write=False)
    return picture
