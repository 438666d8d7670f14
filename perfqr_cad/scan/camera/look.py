"""What the scene looks like: material, ground, light, and the camera's own faults."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

RGB = tuple[float, float, float]  # linear reflectance of red, green and blue, 0 to 1

# A sheet of paper or white plastic sends back 80-90 % of the light, black card 3-5 %.
WHITE: RGB = (0.85, 0.85, 0.85)
BLACK: RGB = (0.04, 0.04, 0.04)


@dataclass(frozen=True)
class Light:
    """A sky of irradiance `ambient` and a lamp that adds `lamp` to a face turned towards it.

    lamp_azimuth_deg as in `View`; lamp_elevation_deg above the code's plane
    lamp_sides      how many lamps share the light, evenly around the code
    lamp_distance   from the code's centre in edges of the code: nearer places get more; infinite: all the
                    same
    """

    ambient: float = 0.8
    lamp: float = 0.25
    lamp_azimuth_deg: float = 120.0
    lamp_elevation_deg: float = 55.0
    lamp_sides: int = 1
    lamp_distance: float = math.inf

    @property
    def lamp_directions(self) -> NDArray[np.float64]:
        """Unit vectors to the lamps (`lamp_sides`, 3), in the code's frame."""
        around = np.arange(self.lamp_sides) * 2 * np.pi / self.lamp_sides
        azimuth, elevation = np.radians(self.lamp_azimuth_deg) + around, np.radians(self.lamp_elevation_deg)
        flat = np.cos(elevation)
        up = np.full(self.lamp_sides, np.sin(elevation))
        return np.stack([flat * np.cos(azimuth), flat * np.sin(azimuth), up], axis=1)

    @property
    def on_front(self) -> float:
        """Irradiance of the unshaded front face, at the code's centre."""
        return self.ambient + self.lamp * float(np.sin(np.radians(self.lamp_elevation_deg)))

    def fall_off(self, towards: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.float64]:
        """What a lamp in one direction gives points (..., 2) of the code's plane, in edges of the code from
        its centre, over what it gives the centre: the inverse square of the distance times the cosine."""
        if math.isinf(self.lamp_distance):
            return np.ones(points.shape[:-1])
        lamp = self.lamp_distance * towards
        squared = ((points - lamp[:2]) ** 2).sum(axis=-1) + lamp[2] ** 2
        return (self.lamp_distance**2 / squared) ** 1.5


@dataclass(frozen=True)
class Optics:
    """Faults of the camera. Lengths in pixels of the picture; zero switches a fault off.

    defocus_px    diameter of the blur disc
    motion_px, motion_deg   length and direction of a straight smear
    noise         standard deviation of the sensor's noise at white, as a part of full scale (shot noise
                  falls with the root of the signal)
    gamma         encoding exponent (sRGB is close to 2.2)
    jpeg_quality  1 to 100, or None for no compression
    """

    defocus_px: float = 1.5
    motion_px: float = 0.0
    motion_deg: float = 0.0
    noise: float = 0.01
    gamma: float = 2.2
    jpeg_quality: int | None = 90


@dataclass(frozen=True)
class Look:
    """Everything about a picture except the part's shape and the camera's place.

    gap_mm          from the lowest point of the part to the ground behind it
    translucency    part of the light on the front that comes out of any wall of the material
    texture         (h, w) or (h, w, 3) reflectance factors tiled over the ground, or None
    texture_mm      edge of one tile
    phone           whether the body of the phone stands in the light
    """

    material: RGB = WHITE
    ground: RGB = BLACK
    gap_mm: float = 0.0
    translucency: float = 0.0
    texture: NDArray[np.float32] | None = None
    texture_mm: float = 40.0
    phone: bool = True
    light: Light = field(default_factory=Light)
    optics: Optics = field(default_factory=Optics)
