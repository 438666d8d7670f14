"""How bright it is inside a perforated plate: light marched layer by layer along a set of directions.

The method of discrete ordinates on a stack of sections. Along each direction the radiance at one depth
is that of the depth before, shifted by the parallax, wherever the section lets it pass, and the radiance
of the wall where it does not. A first pass has black walls; every further pass adds one reflection.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.scan.camera.look import Light
from perfqr_cad.scan.camera.raster import shift, shrunk, slopes, smooth
from perfqr_cad.scan.camera.stack import Stack

Picture = NDArray[np.float32]
DIRECTIONS = 24  # over the hemisphere
LEVELS = 6  # depths at which light is marched; it changes smoothly between them
GOLDEN_ANGLE = np.pi * (3 - np.sqrt(5))
# Pictures of light need no sharp edges: this many pixels a side, whatever the sections have.
LIGHT_PX = 256
REACH_PX = 1.5  # light beside a wall is taken from about this far out
_TINY = 1e-6


@dataclass(frozen=True)
class Brightness:
    """Irradiance relative to an open, level face under unit light.

    wall     (K, n, n) on the material seen at each section
    ground   (n, n) on the plane behind
    steps    sections in which material begins that is not in the one before: no view may skip them
    """

    wall: Picture
    ground: Picture
    steps: tuple[int, ...]


def directions(count: int = DIRECTIONS) -> NDArray[np.float64]:
    """Unit vectors (count, 3) spread evenly over the upper hemisphere (Fibonacci lattice)."""
    height = (np.arange(count) + 0.5) / count
    angle = np.arange(count) * GOLDEN_ANGLE
    flat = np.sqrt(1 - height**2)
    return np.stack([flat * np.cos(angle), flat * np.sin(angle), height], axis=1)


def brightness(
    stack: Stack, light: Light, *, gap_mm: float = 0.0, reflectance: float = 0.85, bounces: int = 1
) -> Brightness:
    """Light on walls and ground of a plate.

    reflectance is the material's; the ground is taken as black for the reflections.
    """
    size = min(LIGHT_PX, stack.pixels)
    small = {id(m): shrunk(m, (size, size)) for m in stack.material}
    material = np.stack([small[id(m)] for m in stack.material]) * np.float32(1 / 255)
    count = len(material)
    levels = np.unique(np.linspace(0, count - 1, LEVELS).round().astype(int))
    scene = _Scene(material[levels], stack.depth_mm[levels], size / stack.edge_mm, gap_mm)
    side, up, ground = scene.gather(_sources(light), np.zeros_like(scene.material))
    for _ in range(bounces):
        side, up, ground = scene.gather(_sources(light), np.float32(reflectance) * side)
    above = np.concatenate([np.zeros_like(material[:1]), material[:-1]])
    ledge = np.clip(material - above, 0, 1)  # tops of recessed bars and of steps, at their own section
    wall = _between(side, levels, count)
    # A ledge is lit as at the level over it: at the next one it stands in its own shadow.
    wall += ledge * (up[np.searchsorted(levels, np.arange(count), "right") - 1] - wall)
    wall.setflags(write=False)
    ground.setflags(write=False)
    steps = tuple(int(k) for k in range(1, count) if ledge[k].max() > 0.5)
    return Brightness(wall, ground, steps)


def _between(pictures: Picture, levels: NDArray[np.integer], count: int) -> Picture:
    """Pictures at some of `count` sections, interpolated linearly to all of them."""
    at = np.interp(np.arange(count), levels, np.arange(len(levels)))
    lower = np.minimum(np.floor(at).astype(int), max(len(levels) - 2, 0))
    upper = np.minimum(lower + 1, len(levels) - 1)
    part = (at - lower).astype(np.float32)[:, None, None]
    return (pictures[lower] * (1 - part) + pictures[upper] * part).astype(np.float32)


def _sources(light: Light) -> list[tuple[NDArray[np.float64], float, float]]:
    """(direction, radiance, weight); weight x radiance x cosine adds up to the irradiance of a face."""
    sky = directions()
    # Sum of cosines over the lattice, so that an open level face gets exactly `ambient`.
    weight = 1 / float(sky[:, 2].sum())
    return [(d, light.ambient, weight) for d in sky] + [(light.lamp_direction, light.lamp, 1.0)]


@dataclass(frozen=True)
class _Scene:
    material: Picture
    depth_mm: NDArray[np.float64]
    px_per_mm: float
    gap_mm: float

    def gather(
        self, sources: list[tuple[NDArray[np.float64], float, float]], glow: Picture
    ) -> tuple[Picture, Picture, Picture]:
        """Irradiance on side walls, level tops (K, n, n) and the ground (n, n); walls glow by `glow`."""
        shape = self.material.shape
        # Irradiance of faces that look along +x, -x, +y, -y and up, at every section.
        cube = np.zeros((5, *shape), np.float32)
        ground = np.zeros(shape[1:], np.float32)
        for direction, radiance, weight in sources:
            facing = [direction[0], -direction[0], direction[1], -direction[1], direction[2]]
            shares = [(face, np.float32(weight * c)) for face, c in enumerate(facing) if c > 0]
            for k, seen in self._downwards(direction, radiance, glow):
                if k == shape[0]:
                    ground += np.float32(weight * direction[2]) * seen
                else:
                    for face, share in shares:
                        cube[face, k] += share * seen
            if weight < 1:  # a patch of sky has its mirror image below, where only walls glow
                below = direction * [1, 1, -1]
                for k, seen in self._upwards(below, glow):
                    for face, share in shares[:-1]:
                        cube[face, k] += share * seen
        return *self._on_walls(cube), ground

    def _downwards(
        self, direction: NDArray[np.float64], radiance: float, glow: Picture
    ) -> Iterator[tuple[int, Picture]]:
        """Radiance that arrives from above at each section, and last at the ground."""
        depth = np.append(self.depth_mm, self.depth_mm[-1] + self.gap_mm)
        seen = np.full(self.material.shape[1:], radiance, np.float32)
        yield 0, seen
        for k in range(1, len(depth)):
            passed = seen + self.material[k - 1] * (glow[k - 1] - seen)
            seen = self._shift(passed, direction, depth[k] - depth[k - 1], radiance)
            yield k, seen

    def _upwards(self, direction: NDArray[np.float64], glow: Picture) -> Iterator[tuple[int, Picture]]:
        """Radiance that arrives from below at each section, above a black ground."""
        last = len(self.depth_mm) - 1
        seen = np.zeros(self.material.shape[1:], np.float32)
        for k in range(last - 1, -1, -1):
            passed = seen + self.material[k + 1] * (glow[k + 1] - seen)
            seen = self._shift(passed, direction, self.depth_mm[k] - self.depth_mm[k + 1], 0.0)
            yield k, seen

    def _shift(
        self, picture: Picture, towards: NDArray[np.float64], step_mm: float, open_sky: float
    ) -> Picture:
        """What a point sees one step away along a direction: the picture moved by the parallax."""
        reach = step_mm * self.px_per_mm / towards[2]
        return shift(picture, reach * towards[0], -reach * towards[1], open_sky)

    def _on_walls(self, cube: Picture) -> tuple[Picture, Picture]:
        """Irradiance of the material's own faces, from that of the free space beside them."""
        side, up = np.empty_like(self.material), np.empty_like(self.material)
        for k, material in enumerate(self.material):
            free = 1 - material
            share = smooth(free, REACH_PX) + _TINY
            beside = [smooth(face[k] * free, REACH_PX) / share for face in cube[:4]]
            right, down = slopes(smooth(material, 1.0))
            size = right**2 + down**2 + _TINY
            # The wall looks away from the material: against the gradient. Rows run downwards, y upwards.
            side[k] = np.where(right < 0, beside[0], beside[1]) * (right**2 / size)
            side[k] += np.where(down > 0, beside[2], beside[3]) * (down**2 / size)
            up[k] = cube[4, k]
        return side, up
