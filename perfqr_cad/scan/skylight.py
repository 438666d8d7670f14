"""How bright it is inside a perforated plate: light marched layer by layer along a set of directions.

The method of discrete ordinates on a stack of sections. Along each direction the radiance at one depth
is that of the depth before, shifted by the parallax, wherever the section lets it pass, and the radiance
of the wall where it does not. A first pass has black walls; every further pass adds one reflection.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from perfqr_cad.scan.look import Light
from perfqr_cad.scan.sections import Stack

Picture = NDArray[np.float32]
DIRECTIONS = 32  # over the hemisphere; 128 move no wall by more than 0.02 of the light on the front
GOLDEN_ANGLE = np.pi * (3 - np.sqrt(5))
# Pictures of light need no sharp edges: this many pixels a side, whatever the sections have.
LIGHT_PX = 400
_TINY = 1e-6


@dataclass(frozen=True)
class Brightness:
    """Irradiance relative to an open, level face under unit light.

    wall     (K, n, n) on the material seen at each section
    ground   (n, n) on the plane behind
    """

    wall: Picture
    ground: Picture


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
    size = min(LIGHT_PX, stack.material.shape[1])
    material = np.stack([cv2.resize(m, (size, size), interpolation=cv2.INTER_AREA) for m in stack.material])
    scene = _Scene(material, stack.depth_mm, size / stack.edge_mm, gap_mm)
    wall, ground = np.zeros_like(material), np.zeros((size, size), np.float32)
    for bounce in range(bounces + 1):
        glow = reflectance * wall if bounce else np.zeros_like(wall)
        wall, ground = scene.gather(_sources(light), glow)
    wall.setflags(write=False)
    ground.setflags(write=False)
    return Brightness(wall, ground)


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
    ) -> tuple[Picture, Picture]:
        """Irradiance on the walls and on the ground, with walls that glow by themselves."""
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
        return self._on_walls(cube), ground

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

    def _shift(self, picture: Picture, towards: NDArray[np.float64], step_mm: float, open_sky: float) -> Picture:
        """What a point sees one step away along a direction: the picture moved by the parallax."""
        reach = step_mm * self.px_per_mm / towards[2]
        matrix = np.array([[1, 0, reach * towards[0]], [0, 1, -reach * towards[1]]])
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        return cv2.warpAffine(
            picture, matrix, picture.shape[::-1], flags=flags, borderMode=cv2.BORDER_CONSTANT, borderValue=open_sky
        )

    def _on_walls(self, cube: Picture) -> Picture:
        """Irradiance of the material's own faces, from that of the free space beside them."""
        wall = np.empty_like(self.material)
        for k, material in enumerate(self.material):
            free = 1 - material
            share = cv2.GaussianBlur(free, (0, 0), 1.5) + _TINY
            beside = [cv2.GaussianBlur(face[k] * free, (0, 0), 1.5) / share for face in cube]
            soft = cv2.GaussianBlur(material, (0, 0), 1.0)
            right, down = cv2.Sobel(soft, -1, 1, 0), cv2.Sobel(soft, -1, 0, 1)
            size = right**2 + down**2 + _TINY
            # The wall looks away from the material: against the gradient. Rows run downwards, y upwards.
            across = np.where(right < 0, beside[0], beside[1]) * (right**2 / size)
            along = np.where(down > 0, beside[2], beside[3]) * (down**2 / size)
            above = self.material[k - 1] if k else np.zeros_like(material)
            level = np.clip(material - above, 0, 1)  # tops of recessed bars and of ledges
            wall[k] = level * np.where(material > 0.5, cube[4, k], beside[4]) + (1 - level) * (across + along)
        return wall
