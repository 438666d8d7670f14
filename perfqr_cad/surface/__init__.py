"""Where the code lies: maps from the pattern plane onto walls of material."""

from .cylinder import Cylinder
from .placement import Distortion, DistortionLimit, Placement, Triangles
from .plane import Plane

__all__ = ["Cylinder", "Distortion", "DistortionLimit", "Placement", "Plane", "Triangles"]
