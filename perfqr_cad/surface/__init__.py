"""Where the code lies: maps from the pattern plane onto walls of material, and how much they bend a module.

Formulas on arrays. No loops, no solids, no modeller: those lie on these maps in `solid/charts`.
"""

from perfqr_cad.geometry.triangles import Triangles
from perfqr_cad.surface.cone import Cone
from perfqr_cad.surface.heightfield import HeightField
from perfqr_cad.surface.placement import Distortion, DistortionLimit, Placement
from perfqr_cad.surface.plane import Plane, TurnedPlane
from perfqr_cad.surface.revolved import Cylinder, Revolution, Revolved, Sphere

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
    "TurnedPlane",
]
