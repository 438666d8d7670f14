"""A code in a triangle mesh, such as the Bunny."""

from perfqr_cad import make, settings
from perfqr_cad.hosts.mesh import MeshTarget

# [Shared: Code]

# [Mesh]
# the STL, OBJ, PLY, OFF or 3MF file
mesh = ""
# longest edge of the body, mm; none: the file's own size, times the scale
extent: float | None = None  # [0.01:5000]
# factor on the file's coordinates
scale = 1.0
# number of one of several separate bodies, 1 the greatest; none: there is one
part: int | None = None  # [1:100000]
# thickness of the shell that the body is made into, mm; none: as it is
hollow: float | None = None  # [0.01:100]
# where the reader is, mm; none: the flattest spot
point: tuple[float, float, float] | None = None
# where the reader looks; none: the nearest surface to the point
direction: tuple[float, float, float] | None = None
# what points up in the code; none: +z, or +y where the spot looks along z
up: tuple[float, float, float] | None = None
# the panel under the code as an exact B-spline solid, instead of the carved mesh
exact = False

# [Shared: Look, Walls, Strength, Proof, Files]


def build(p):
    at = {"point": p.point, "direction": p.direction, "up": p.up, "part": p.part, "exact": p.exact}
    size = {"scale": p.scale, "extent_mm": p.extent, "hollow_mm": p.hollow}
    return make(target=MeshTarget(p.mesh, **at, **size), **settings(p))
