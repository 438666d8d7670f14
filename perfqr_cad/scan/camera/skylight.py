"""How bright it is inside a perforated plate: on its front, on the walls of its holes, on bars and on the
ground.

The method of discrete ordinates on a stack of sections. First comes what sky and lamps send, less what the
phone before the part hides; reflections follow, each a pass of its own, on coarser pictures.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.scan.camera.look import Light
from perfqr_cad.scan.camera.marching import Beam, Lit, Picture, Slab, directions
from perfqr_cad.scan.camera.raster import resized, shrunk
from perfqr_cad.scan.camera.stack import MARGIN, Stack

LEVELS = 6  # depths at which light is marched; it changes smoothly between them
# Pictures of light need no sharp edges: this many pixels a side, whatever the sections have.
LIGHT_PX = 256
GLOW_PX = 96  # and reflected light fewer still
BOUNCES = 4  # worked out one by one


@dataclass(frozen=True)
class Brightness:
    """Irradiance of what is seen.

    front    (n, n) on the front face
    ground   (n, n) on the plane behind
    side     (L, n, n) on side walls at a few levels, `up` (L, n, n) on faces that look at the reader there
    places   (K,) of each section among the levels
    ledge    (K, n, n) where material begins that is not in the section before: tops of bars and of steps
    steps    sections in which it does: no view may skip them
    """

    front: Picture
    ground: Picture
    side: Picture
    up: Picture
    places: NDArray[np.float64]
    ledge: Sequence[Picture]
    steps: tuple[int, ...]

    def wall(self, section: int) -> Picture:
        """Irradiance (n, n) on the material that begins to be seen at a section."""
        place = float(self.places[section])
        lower = min(int(place), max(len(self.side) - 2, 0))
        upper = min(lower + 1, len(self.side) - 1)
        part = np.float32(place - lower)
        wall = self.side[lower] + part * (self.side[upper] - self.side[lower])
        # A ledge is lit as at the level over it: at the next one it stands in its own shadow.
        over = self.up[int(place)]
        return np.asarray(wall + self.ledge[section] * (over - wall), np.float32)


@dataclass(frozen=True)
class PlateLight:
    """All light on a plate, without the phone before it; what a phone hides is taken off view by view.

    stack, light, gap_mm   what it was worked out for
    front                  (n, n) on the open front
    first, reflected       straight from sky and lamps; by all reflections
    ledge                  as in `Brightness`
    """

    stack: Stack
    light: Light
    gap_mm: float
    front: Picture
    first: Lit
    reflected: Lit
    ledge: Sequence[Picture]

    def seen(self, hidden: NDArray[np.float64] | None = None) -> Brightness:
        """The light of a view; `hidden` are shares of the `towards` that the phone covers."""
        front, lit = self.front, self.first.plus(self.reflected)
        if hidden is not None and hidden.any():
            off = first_light(self.stack, self.light, gap_mm=self.gap_mm, shares=hidden, pixels=GLOW_PX)
            share = float(off.front.sum() / len(off.front) ** 2 / self.front.mean())
            front = front - resized(off.front, len(front))
            lit = self.first.plus(off.lit.sized(len(front)).times(-1.0)).plus(self.reflected.times(1 - share))
        count = len(self.ledge)
        places = np.interp(np.arange(count), _levels(count), np.arange(len(_levels(count))))
        steps = tuple(k for k in range(1, count) if float(self.ledge[k].max()) > 0.5)
        return Brightness(front, lit.ground, lit.side, lit.up, places, self.ledge, steps)


@dataclass(frozen=True)
class FirstLight:
    """Light that comes straight from sky and lamps: on the open front (n, n), and on all faces of a plate."""

    front: Picture
    lit: Lit


def towards(light: Light) -> NDArray[np.float64]:
    """Unit vectors (k, 3) to all that shines: patches of sky, then lamps."""
    return np.concatenate([directions(), light.lamp_directions])


def first_light(
    stack: Stack,
    light: Light,
    *,
    gap_mm: float,
    shares: NDArray[np.float64] | None = None,
    pixels: int = LIGHT_PX,
) -> FirstLight:
    """Light of sky and lamps before any reflection, or of shares of them. It depends on no reflectance."""
    slab = _slab(stack, pixels, gap_mm)
    sources = _sources(light, len(slab.material[0]), shares)
    return FirstLight(_on_open(sources), slab.gather(sources, slab.dark))


def plate_light(
    stack: Stack, light: Light, first: FirstLight, *, gap_mm: float, reflectance: float, ground: float
) -> PlateLight:
    """All light, from the first: the tail of the series of reflections is taken as a geometric one.

    reflectance   of the material
    ground        reflectance of the ground, which sends light up through the holes and the slots
    """
    slab = _slab(stack, GLOW_PX, gap_mm)
    sky = [source.dark for source in _sky(1.0, len(slab.material[0]))]
    step = first.lit.sized(len(slab.material[0]))
    total: Lit | None = None
    before = step
    for _ in range(BOUNCES):
        sent = slab.sent(step, reflectance, ground)
        before, step = step, slab.gather(sky, sent)
        total = step if total is None else total.plus(step)
    assert total is not None
    reflected = total.plus(step.continued(before)).sized(len(first.front))
    return PlateLight(stack, light, gap_mm, first.front, first.lit, reflected, _ledges(stack))


def brightness(
    stack: Stack, light: Light, *, gap_mm: float = 0.0, reflectance: float = 0.85, ground: float = 0.0
) -> Brightness:
    """Light on front, walls and ground of a plate, with all reflections between them and no phone."""
    first = first_light(stack, light, gap_mm=gap_mm)
    return plate_light(stack, light, first, gap_mm=gap_mm, reflectance=reflectance, ground=ground).seen()


def open_face(light: Light, hidden: NDArray[np.float64] | None = None) -> Brightness:
    """Light on a level face that nothing shades but the phone."""
    front = _on_open(_sources(light, GLOW_PX, None if hidden is None else 1 - hidden))
    return Brightness(front, front, front[None], front[None], np.zeros(1), [np.zeros_like(front)], ())


def _on_open(sources: Sequence[Beam]) -> Picture:
    """Irradiance (n, n) of an open, level face."""
    return np.sum([np.float32(s.weight * s.direction[2]) * s.radiance for s in sources], axis=0)


def _sources(light: Light, size: int, shares: NDArray[np.float64] | None) -> list[Beam]:
    """The sky's directions and the lamps', for pictures of `size` pixels over a plate; those that shine."""
    across = (np.arange(size) - (size - 1) / 2) / size * MARGIN
    points = np.stack(np.meshgrid(across, -across), axis=-1)
    found = _sky(light.ambient, size)
    for direction in light.lamp_directions:
        radiance = light.lamp / light.lamp_sides * light.fall_off(direction, points)
        found.append(Beam(direction, radiance.astype(np.float32), 1.0, False))
    if shares is not None:
        found = [source.dimmed(float(share)) for source, share in zip(found, shares, strict=True)]
    return [source for source in found if source.radiance.any()]


def _sky(ambient: float, size: int) -> list[Beam]:
    """Patches of an even sky that gives an open level face exactly `ambient`."""
    sky = directions()
    weight = 1 / float(sky[:, 2].sum())
    even = np.full((size, size), ambient, np.float32)
    return [Beam(direction, even, weight, True) for direction in sky]


def _slab(stack: Stack, pixels: int, gap_mm: float) -> Slab:
    """The plate in pictures of some size at a few levels."""
    size, levels = min(pixels, stack.pixels), _levels(len(stack.material))
    small = {id(m): shrunk(m, (size, size)) for m in (stack.material[k] for k in levels)}
    material = np.stack([small[id(stack.material[k])] for k in levels]) * np.float32(1 / 255)
    return Slab(material, stack.depth_mm[levels], size / stack.edge_mm, gap_mm)


def _ledges(stack: Stack) -> list[Picture]:
    """Where each section has material that the one before has not (n, n); neighbours that are one have
    none."""
    size = min(LIGHT_PX, stack.pixels)
    small = {id(m): shrunk(m, (size, size)).astype(np.float32) / np.float32(255) for m in stack.material}
    none = np.zeros((size, size), np.float32)
    pairs = zip((None, *stack.material[:-1]), stack.material, strict=True)
    return [
        none
        if before is now
        else np.clip(small[id(now)] - (none if before is None else small[id(before)]), 0, 1)
        for before, now in pairs
    ]


def _levels(count: int) -> NDArray[np.intp]:
    """Indices of the sections at which light is marched."""
    return np.unique(np.linspace(0, count - 1, LEVELS).round().astype(np.intp))
