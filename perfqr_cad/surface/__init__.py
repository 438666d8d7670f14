"""Where the code lies: maps from the pattern plane onto walls of material."""

from .cone import Cone
from .heightfield import HeightField
from .placement import Distortion, DistortionLimit, Placement, Triangles
from .plane import Plane
from .revolved import Cylinder, Revolution, Revolved, Sphere

__all__ = [
    "Cone",
    "Cylinder",
    "Distortion",
    "DistortionLimit",
    "HeightField",
    "Placement",
    "Plane",
    "Revolution",
    "Revolved",
    "Sphere",
    "Triangles",
]
