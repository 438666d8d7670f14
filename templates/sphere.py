"""A hollow ball with the code projected on it."""

from build123d import Sphere

from perfqr_cad import DesignError, make, settings
from perfqr_cad.hosts.step import ImportedFace

# [Shared: Code]

# [Ball]
# outer diameter, mm
diameter = 80.0  # [5:0.1:5000]
# thickness of the wall, mm
thickness = 1.6  # [0.1:0.1:50]

# [Shared: Look, Walls, Strength, Proof, Files]


def build(p):
    if p.thickness >= p.diameter / 2:
        raise DesignError(
            f"a ball of {p.diameter:g} mm has no room for a wall of {p.thickness:g} mm: make it thinner"
        )
    ball = Sphere(p.diameter / 2) - Sphere(p.diameter / 2 - p.thickness)
    front = (0.0, -p.diameter / 2, 0.0)
    return make(target=ImportedFace.of(ball, point=front), **settings(p))
