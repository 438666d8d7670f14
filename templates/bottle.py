"""A ring for a dark bottle: a band of a cylinder with the code wrapped around it."""

from build123d import Cylinder

from perfqr_cad import DesignError, make, settings
from perfqr_cad.hosts.step import ImportedFace, mesh_shape

# [Shared: Code]
size = 40.0  # [1:0.1:2000]

# [Ring]
# outer diameter, mm
diameter = 80.0  # [5:0.1:5000]
# height, mm; 0 takes the code's
height = 0.0  # [0:0.1:5000]
# thickness of the wall, mm
thickness = 1.6  # [0.1:0.1:50]
# play between the ring and the bottle, in diameter, mm
clearance = 0.4  # [0.05:0.05:10]

# [Shared: Look, Walls, Strength, Proof, Files]


def build(p):
    inner = p.diameter / 2 - p.thickness
    if inner <= p.clearance / 2:
        raise DesignError(
            f"a ring of {p.diameter:g} mm has no room for walls of {p.thickness:g} mm: make them thinner"
        )
    height = p.height or p.size
    ring = Cylinder(p.diameter / 2, height) - Cylinder(inner, height)
    bottle = mesh_shape(Cylinder(inner - p.clearance / 2, height))
    front = (0.0, -p.diameter / 2, 0.0)
    target = ImportedFace.of(ring, point=front, wrap=True, behind=bottle)
    return make(target=target, **settings(p))
