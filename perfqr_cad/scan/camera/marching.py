"""Light marched through a plate, layer by layer along a set of directions.

Along each direction the radiance at one depth is that of the depth before, shifted by the parallax, wherever
the section lets it pass, and the radiance of the wall where it does not.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.scan.camera.raster import resized, shift, slopes, smooth

Picture = NDArray[np.float32]
DIRECTIONS = 24  # over the hemisphere
GOLDEN_ANGLE = np.pi * (3 - np.sqrt(5))
MOST_KEPT = 0.8  # of the light by a reflection: no paper or plastic sends back more
REACH_PX = 1.5  # light beside a wall is taken from about this far out
_TINY = 1e-6


def directions(count: int = DIRECTIONS) -> NDArray[np.float64]:
    """Unit vectors (count, 3) spread evenly over the upper hemisphere (Fibonacci lattice)."""
    height = (np.arange(count) + 0.5) / count
    angle = np.arange(count) * GOLDEN_ANGLE
    flat = np.sqrt(1 - height**2)
    return np.stack([flat * np.cos(angle), flat * np.sin(angle), height], axis=1)


@dataclass(frozen=True)
class Beam:
    """Light from one direction (3,): its radiance (n, n) over the plate, and what it weighs; weight x
    radiance x cosine adds up to the irradiance of a face."""

    direction: NDArray[np.float64]
    radiance: Picture
    weight: float
    is_sky: bool

    @property
    def dark(self) -> Beam:
        """The same direction without its own light."""
        return replace(self, radiance=np.zeros_like(self.radiance))

    def dimmed(self, share: float) -> Beam:
        """A share of its light."""
        return replace(self, radiance=np.float32(share) * self.radiance)


@dataclass(frozen=True)
class Lit:
    """Irradiance on side walls, level tops and undersides (K, n, n), and on the ground (n, n)."""

    side: Picture
    up: Picture
    down: Picture
    ground: Picture

    @property
    def _all(self) -> tuple[Picture, Picture, Picture, Picture]:
        return self.side, self.up, self.down, self.ground

    def times(self, factor: float) -> Lit:
        """A multiple."""
        share = np.float32(factor)
        return Lit(share * self.side, share * self.up, share * self.down, share * self.ground)

    def plus(self, other: Lit) -> Lit:
        """Both together."""
        return Lit(
            self.side + other.side, self.up + other.up, self.down + other.down, self.ground + other.ground
        )

    def continued(self, before: Lit) -> Lit:
        """What follows in a geometric series of which `before` and this are the last two terms."""
        last, now = (sum(float(picture.sum()) for picture in lit._all) for lit in (before, self))
        ratio = min(now / max(last, _TINY), MOST_KEPT)
        return self.times(ratio / (1 - ratio))

    def sized(self, size: int) -> Lit:
        """The same on pictures of another size."""
        if len(self.ground) == size:
            return self
        side, up, down = (np.stack([resized(one, size) for one in part]) for part in self._all[:3])
        return Lit(side, up, down, resized(self.ground, size))


@dataclass(frozen=True)
class Glow:
    """What material sends down and up (K, n, n), and the ground up (n, n)."""

    downwards: Picture
    upwards: Picture
    ground: Picture
    shines: bool = True


@dataclass(frozen=True)
class Slab:
    """A plate at a few of its sections: material (K, n, n), 0 to 1, at depths (K,); the ground lies below."""

    material: Picture
    depth_mm: NDArray[np.float64]
    px_per_mm: float
    gap_mm: float

    @property
    def dark(self) -> Glow:
        """Nothing sends light."""
        none = np.zeros_like(self.material)
        return Glow(none, none, none[0], shines=False)

    def sent(self, lit: Lit, reflectance: float, ground: float) -> Glow:
        """What is sent on of what was received: by walls, and where no material follows by the faces
        there."""
        none = np.zeros_like(self.material[:1])
        touching = self.material[-1:]  # the ground hides the back
        below = np.concatenate([self.material[1:], none if self.gap_mm > 0 else touching])
        above = np.concatenate([none, self.material[:-1]])
        down = lit.side + np.clip(self.material - below, 0, 1) * (lit.down - lit.side)
        up = lit.side + np.clip(self.material - above, 0, 1) * (lit.up - lit.side)
        down, up = (np.asarray(reflectance * sides, np.float32) for sides in (down, up))
        return Glow(down, up, np.float32(ground) * lit.ground)

    def gather(self, sources: Sequence[Beam], glow: Glow) -> Lit:
        """What every face receives of the sources and of what glows."""
        shape = self.material.shape
        # Irradiance of faces that look along +x, -x, +y, -y, up and down, at every section.
        cube = np.zeros((6, *shape), np.float32)
        ground = np.zeros(shape[1:], np.float32)
        for source in sources:
            direction, weight = source.direction, source.weight
            facing = [direction[0], -direction[0], direction[1], -direction[1], direction[2]]
            shares = [(face, np.float32(weight * c)) for face, c in enumerate(facing) if c > 0]
            for k, seen in self._downwards(source, glow):
                if k == shape[0]:
                    ground += np.float32(weight * direction[2]) * seen
                else:
                    for face, share in shares:
                        cube[face, k] += share * seen
            if source.is_sky and glow.shines:  # a patch of sky has its mirror image below
                below = direction * [1, 1, -1]
                to_below = [*shares[:-1], (5, shares[-1][1])]
                for k, seen in self._upwards(below, glow):
                    for face, share in to_below:
                        cube[face, k] += share * seen
        return Lit(self._on_walls(cube), cube[4], cube[5], ground)

    def _downwards(self, source: Beam, glow: Glow) -> Iterator[tuple[int, Picture]]:
        """Radiance that arrives from above at each section, and last at the ground. A lamp is no patch of the
        sky: walls that hide it take its light away, and what they send comes with the sky's directions."""
        depth = np.append(self.depth_mm, self.depth_mm[-1] + self.gap_mm)
        direction, seen = source.direction, source.radiance
        open_sky = float(seen[seen.shape[0] // 2, 0])
        yield 0, seen
        for k in range(1, len(depth)):
            sent = glow.downwards[k - 1] if source.is_sky else np.float32(0)
            passed = seen + self.material[k - 1] * (sent - seen)
            seen = self._shift(passed, direction, depth[k] - depth[k - 1], open_sky)
            yield k, seen

    def _upwards(self, direction: NDArray[np.float64], glow: Glow) -> Iterator[tuple[int, Picture]]:
        """Radiance that arrives from below at each section."""
        last = len(self.depth_mm) - 1
        beyond = float(glow.ground[0, 0])
        seen = self._shift(glow.ground, direction, -self.gap_mm, beyond)
        yield last, seen
        for k in range(last - 1, -1, -1):
            passed = seen + self.material[k + 1] * (glow.upwards[k + 1] - seen)
            seen = self._shift(passed, direction, self.depth_mm[k] - self.depth_mm[k + 1], beyond)
            yield k, seen

    def _shift(
        self, picture: Picture, towards: NDArray[np.float64], step_mm: float, open_sky: float
    ) -> Picture:
        """What a point sees one step away along a direction: the picture moved by the parallax."""
        reach = step_mm * self.px_per_mm / towards[2]
        return shift(picture, reach * towards[0], -reach * towards[1], open_sky)

    def _on_walls(self, cube: Picture) -> Picture:
        """Irradiance of the material's own side walls, from that of the free space beside them."""
        side = np.empty_like(self.material)
        for k, material in enumerate(self.material):
            free = 1 - material
            share = smooth(free, REACH_PX) + _TINY
            beside = [smooth(face[k] * free, REACH_PX) / share for face in cube[:4]]
            right, down = slopes(smooth(material, 1.0))
            size = right**2 + down**2 + _TINY
            # The wall looks away from the material: against the gradient. Rows run downwards, y upwards.
            side[k] = np.where(right < 0, beside[0], beside[1]) * (right**2 / size)
            side[k] += np.where(down > 0, beside[2], beside[3]) * (down**2 / size)
        return side
